"""`tippetop info, check, export, systems, presets`: look at stores, scenarios, and what
there is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .numbers import Seconds
from .streams import print_json


def info(store: Path, *, as_json: bool = False, errors: bool = False) -> int:
    """Print what is in a store: status, events, inversion, drift of the invariants, provenance.

    Parameters
    ----------
    store
        A store that `run`, `sweep`, `surface` or `potential` wrote, finished or not.
    as_json
        Print it as one JSON object.
    errors
        Of a run: also how fast small errors of its start grow, and from when on a double says
        nothing. It is integrated again with its derivatives, which costs some ten runs.
    """
    from ..runs.results import summary_of
    from ..runs.summary import lines
    from ..store import root
    from .text import heading, table

    attrs = root.attributes(store)
    if attrs.get("content") == "sweep":
        from ..sweeps.summary import report
        from . import sweep

        return sweep.describe(report(store), as_json)
    if "content" in attrs:
        from .landscape import describe

        return describe(attrs, as_json)
    content = summary_of(attrs)
    growth = _growth(attrs) if errors else None
    if as_json:
        return print_json(content.to_dict() | ({"errors": growth} if growth else {}))
    heading(attrs["title"])
    rows = lines(content)
    if growth:
        rows.append(("errors", growth["sentence"]))
    units = attrs["units"] | _units(attrs)
    for name in ("parameters", "friction", "contact", "stem", "initial", "run"):
        if name in content:
            rows.append((name, entries(content[name], units)))
    rows.append(
        (
            "versions",
            ", ".join(f"{name} {version}" for name, version in content["versions"].items()),
        )
    )
    rows.append(("tolerance", f"{content['tolerance']:.3g}, {content['precision']} precision"))
    rows.append(("processor", content["cpu"]))
    for before in attrs.get("begun_with", []):
        words = ", ".join(f"{name} {version}" for name, version in before["versions"].items())
        rows.append(("begun with", f"{words}; {before['cpu']}"))
    table(rows)
    return 0


def _growth(attrs: dict[str, Any]) -> dict[str, Any]:
    """How errors of the start of a stored run grow.

    Raises InputError where it has no derivatives.
    """
    import numpy as np

    from ..engine.derivatives.growth import growth
    from ..problem import refuse
    from ..scenario import build
    from ..store.root import finite

    problem = build.stored(attrs)
    refuse(problem, ())
    result = growth(problem, np.linspace(0.0, attrs["report"]["t_end"], 201))
    numbers = {
        "factor": float(result.factor[-1]),
        "exponent": float(result.exponents[-1]),
        "horizon": result.horizon,
    }
    return finite(numbers) | {"sentence": result.sentence()}


def check(
    scenario: str,
    *,
    until: Seconds | None = None,
    set_: list[str] | None = None,
    as_json: bool = False,
) -> int:
    """Validate a scenario: invariants at the start, thresholds, expected fate; cost, by the first
    steps of the run.

    The plan of a sweep is validated too: its axes, its size, its cost.

    Parameters
    ----------
    scenario
        TOML file, or preset (see `tippetop presets`), or the plan of a sweep.
    until
        End of the run [s, or with a unit: 2min], instead of the scenario's.
    set_
        Change a value: table.key=value, such as initial.theta=0.2. table.key= removes it. May be
        repeated.
    as_json
        Print the result as one JSON object.
    """
    from ..errors import InputError
    from ..runs import forecast, starting
    from ..runs.cost import measured
    from ..runs.summary import form_sentence, regularisation
    from ..scenario import build, reading
    from ..scenario.doubts import doubts
    from ..sweeps import plan
    from .text import table, warn

    tables = reading.override(reading.read(scenario), set_ or [])
    if plan.is_plan(tables):
        from . import sweep

        if until is not None:
            raise InputError("`--until` cannot be used with a plan: give `set.run.until` in it.")
        return sweep.examine(tables, Path(scenario).parent, as_json)
    if until is not None:
        tables = build.ending(tables, until)
    problem = starting.problem(tables, scenario)
    facts = {**build.resolved(problem), **forecast.assessment(problem)}
    facts["warnings"] = warn(doubts(problem))
    if problem.precision == "double":  # wider numbers compile for a minute
        facts["expected"] |= measured(problem)
    if as_json:
        return print_json(facts)
    units = units_of(problem)
    rows = []
    for name, value in facts.items():
        if name == "regularisation":
            text = regularisation(facts)
        elif name == "form":
            text = form_sentence(facts)
        elif isinstance(value, dict):
            text = entries(value, units)
        else:
            text = plain(value)
        if name not in (
            "auto_form",
            "inversion_by_eps",
            "warnings",
        ):  # in `regularisation`; on standard error
            rows.append((name.replace("_", " "), text))
    table(rows)
    return 0


def export(
    store: Path,
    *,
    to: str,
    out: Path,
    group: str | None = None,
    overwrite: bool = False,
) -> int:
    """Write a store as one netCDF, CSV or Parquet file, or the body of a scenario for a simulator
    (MJCF, URDF).

    Parameters
    ----------
    store
        The store of a run or of a sweep; for mjcf and urdf a scenario, a preset or the store of a
        run.
    to
        The format: netcdf, csv or parquet; mjcf or urdf for the body, its start and its friction.
    out
        The file to write; must not exist yet (or say --overwrite).
    group
        `trajectory` or `events` of a run, `phases` or `impacts` of one whose contact changes its
        phase. Without it CSV and Parquet hold the first, netCDF holds all.
    overwrite
        Replace an existing file.
    """
    from ..errors import InputError
    from ..store.export import export as write

    if to in ("mjcf", "urdf"):
        from . import exchange

        if group is not None:
            raise InputError(
                f"--group must be left out with --to {to}: a scenario has no tables, but is "
                f"`{group}`."
            )
        return exchange.describe(str(store), to, out, overwrite=overwrite)
    write(store, to, out, group, overwrite=overwrite)
    return 0


def systems(*, as_json: bool = False) -> int:
    """List the systems: forms, parameters and initial keys with their units, friction laws,
    integrals, events.

    Parameters
    ----------
    as_json
        Print the list as one JSON object.
    """
    from ..mechanics.systems import SYSTEMS, laws_of, load_entry_points
    from .text import heading, table

    load_entry_points()
    listing: dict[str, dict[str, Any]] = {
        name: {
            "title": s.title,
            "forms": list(s.forms),
            "parameters": {n: p.unit.symbol for n, p in s.parameters.items()},
            "friction": {
                n: {k: p.unit.symbol for k, p in law.parameters.items()}
                for n, law in laws_of(s).items()
            },
            "initial": {n: p.unit.symbol for n, p in s.initial.items()}
            | ({"centre_at_rest": "true or false"} if "nu_x" in s.initial else {}),
            "quantities": {q.name: q.unit.symbol for q in s.quantities},
            "integrals": list(s.integrals),
            "events": [e.name for e in s.events],
            "source": s.source,
        }
        for name, s in SYSTEMS.items()
    }
    if as_json:
        return print_json(listing)
    keys = ("forms", "parameters", "friction", "initial", "quantities", "integrals", "events")
    for number, (name, s) in enumerate(listing.items()):
        heading(f"{chr(10) if number else ''}{name}: {s['title']}")
        table((f"  {key}", _listed(s[key])) for key in keys if s[key])
    return 0


def _listed(names: Any) -> str:
    """Names with their units in brackets; a friction law with the numbers that it takes."""
    if isinstance(names, list):
        return ", ".join(names)
    words = []
    for name, unit in names.items():
        if isinstance(unit, dict):
            words.append(f"{name} ({_listed(unit)})" if unit else name)
        else:
            words.append(name if unit == "1" else f"{name} [{unit}]")
    return ", ".join(words)


def presets(*, as_json: bool = False) -> int:
    """List the built-in scenarios with their sources.

    Parameters
    ----------
    as_json
        Print the list as one JSON object.
    """
    from ..scenario.reading import presets as texts
    from .text import table

    sources = {name: _comment(text) for name, text in texts().items()}
    if as_json:
        return print_json(sources)
    table(sources.items())
    return 0


def _comment(text: str) -> str:
    """The leading comment of a preset: its source."""
    head = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        head.append(line.lstrip("# ").strip())
    return " ".join(head)


def plain(value: Any) -> str:
    """Return a value as text; numbers have eight digits."""
    if isinstance(value, list):
        return ", ".join(map(plain, value))
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def _units(tables: dict[str, Any]) -> dict[str, str]:
    """Units of the keys of [friction] and [run]; of a law that is not known here, none."""
    from ..mechanics.friction import PARTS
    from ..mechanics.systems import find
    from ..problem.options import UNITS

    system = find(tables["system"])
    law = system.laws.get(tables.get("friction", {}).get("law")) if system is not None else None
    rules = PARTS | dict(law.parameters) if law is not None else {}
    friction = {name: p.unit.symbol for name, p in rules.items()}
    return friction | {name: unit.symbol for name, unit in UNITS.items()}


def units_of(problem: Any) -> dict[str, str]:
    """Return the units of the keys of a scenario."""
    units = {key.partition(".")[2]: rule.unit.symbol for key, rule in problem.rules.items()}
    return units | _units({"system": problem.system.name, "friction": {"law": problem.law_name}})


def entries(table: dict[str, Any], units: dict[str, str]) -> str:
    """A table of a scenario, or of quantities, on one line: key = value unit."""
    return ", ".join(
        f"{key} = {_with_unit(entry, units.get(key, '1'))}" for key, entry in table.items()
    )


def _with_unit(entry: Any, unit: str) -> str:
    """A number with its unit: `entry` is the number, or a record of value and unit."""
    if isinstance(entry, dict):
        entry, unit = entry["value"], entry["unit"]
    bare = isinstance(entry, bool) or not isinstance(entry, int | float | list)
    return plain(entry) if bare or unit == "1" else f"{plain(entry)} {unit}"
