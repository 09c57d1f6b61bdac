"""`tippetop info, check, export, systems, presets`: look at stores and scenarios."""

from __future__ import annotations

from itertools import takewhile
from pathlib import Path
from typing import Any

from ..errors import InputError
from .streams import print_json, visible
from .text import entries, plain, table, units_of, warn
from .values import Place, Seconds


def info(store: Place, *, as_json: bool = False) -> int:
    """Print the content of a store: status, events, inversion, drift of invariants, provenance.

    Parameters
    ----------
    store
        A store that `run`, `sweep`, `surface` or `potential` wrote, finished or not.
    as_json
        Print it as one JSON object.
    """
    from ..runs.results import summary_of
    from ..runs.summary import lines
    from ..store import root

    attrs = root.attributes(store)
    content = attrs.get("content", "run")
    if content == "sweep":
        from ..sweeps.sweep_summary import report
        from . import sweep_command

        return sweep_command.describe(report(store), as_json)
    if content != "run":
        from .landscape_commands import describe

        return describe(attrs, as_json)
    summary = summary_of(attrs)
    if as_json:
        return print_json(summary.to_dict())
    print(visible(attrs["title"]))
    rows = lines(summary)
    units = attrs["units"] | units_of(attrs)
    for name in ("parameters", "friction", "contact", "stem", "air", "plane", "initial", "run"):
        if name in summary:
            rows.append((name, entries(summary[name], units)))
    rows += [
        ("versions", _pairs(summary["versions"])),
        ("tolerance", f"{summary['tolerance']:.3g}, {summary['precision']} precision"),
        ("processor", summary["cpu"]),
    ]
    for before in attrs.get("begun_with", []):
        rows.append(("begun with", f"{_pairs(before['versions'])}; {before['cpu']}"))
    table(rows)
    return 0


def _pairs(versions: Any) -> str:
    """Return names with versions as a text: "heyoka 7.0, numpy 2.1"."""
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def check(
    scenario: str,
    *,
    until: Seconds | None = None,
    set_: list[str] | None = None,
    as_json: bool = False,
) -> int:
    """Validate a scenario or a plan; print thresholds, expected fate, and cost by the first steps.

    Of the plan of a sweep its axes, its size and its cost are printed. Thresholds named lambda
    are those of |jellett|, those named spin of |omega3|, those named gamma of I1/I3.

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
    from ..runs import forecast, starting
    from ..runs.cost import measured
    from ..scenario import build, reading
    from ..scenario.doubts import doubts
    from ..sweeps import plan

    tables = reading.override(reading.read(scenario), set_)
    if plan.is_plan(tables):
        from . import sweep_command

        if until is not None:
            raise InputError("`--until` cannot be used with a plan: give `set.run.until` in it.")
        facts, units = sweep_command.examine(tables, Path(scenario).parent)
        return _print_facts(facts, units, as_json)
    problem = starting.problem_from_tables(build.ending(tables, until), scenario)
    resolved = build.resolved(problem)
    facts = {**resolved, **forecast.assessment(problem), "warnings": warn(doubts(problem))}
    if problem.precision == "double":  # wider numbers compile for a minute
        facts["expected"] |= measured(problem)
    return _print_facts(facts, units_of(resolved), as_json)


def _print_facts(facts: dict[str, Any], units: dict[str, str], as_json: bool) -> int:
    """Print facts on a checked scenario or plan; return exit code 0.

    `units` are those of keys. The names of facts are those that `check --json` prints.
    """
    if as_json:
        return print_json(facts)
    facts |= facts.pop("plan", {}).get("scenario", {})
    rows: list[tuple[str, str]] = []
    for name, value in facts.items():
        if name == "thresholds":
            lines = [f"{entries({key: t}, {})}: {t['meaning']}" for key, t in value.items()]
            rows += zip([name] + [""] * len(lines), lines, strict=False)
        elif name != "warnings":  # printed already
            rows.append((name.replace("_", " "), plain(value, units)))
    table(rows)
    return 0


def export(
    store: Place,
    *,
    to: str,
    out: Place,
    group: str | None = None,
    overwrite: bool = False,
) -> int:
    """Write a store as netCDF, CSV or Parquet, or the body of a scenario for a simulator.

    Parameters
    ----------
    store
        The store of a run, a sweep, a surface or a potential; for mjcf, urdf and sdf a
        scenario, a preset or the store of a run.
    to
        The format: netcdf, csv or parquet; mjcf, urdf or sdf for the body, its start and its
        friction.
    out
        The file to write; must not exist yet (or use --overwrite).
    group
        `trajectory` or `events` of a run, `phases` or `impacts` of one whose contact changes its
        phase, `sweep` or `events` of a sweep. Without it CSV and Parquet contain the first, netCDF
        contains all, as groups.
    overwrite
        Replace an existing file.
    """
    if to not in ("mjcf", "urdf", "sdf"):
        from ..store import root
        from ..store.export import export as write

        attrs = root.attributes(store)
        tables = {
            name: root.open_group(store, name)
            for name in root.groups_of(store)
            if name != "keyframes"
        }
        write(tables, attrs, f"`{store}`", to, out, group, overwrite=overwrite)
        return 0
    from ..exchange.simulators import text_of
    from ..runs.starting import load_any
    from ..store import files

    if group is not None:
        raise InputError(
            f"--group must be left out with --to {to}: a scenario has no tables, but is `{group}`."
        )
    files.write_text(out, text_of(load_any(str(store)), to), overwrite=overwrite)
    print(f"file  {out}")
    return 0


def systems(*, as_json: bool = False) -> int:
    """List the systems: forms, integrals and sources; `tippetop help scenario` lists their keys.

    Parameters
    ----------
    as_json
        Print the list as one JSON object.
    """
    from ..scenario.scenario_reference import systems_table

    (section,) = systems_table()
    listing = {name: dict(zip(section.head[1:], row, strict=True)) for name, *row in section.rows}
    if as_json:
        return print_json(listing)
    for name, facts in listing.items():
        print(f"{name}: {facts.pop('title')}")
        table((f"  {key}", text) for key, text in facts.items())
        print()
    return 0


def presets(*, as_json: bool = False) -> int:
    """List the built-in scenarios with their sources.

    Parameters
    ----------
    as_json
        Print the list as one JSON object.
    """
    from ..scenario.reading import presets as texts

    sources = {
        name: " ".join(
            line.lstrip("# ").strip()
            for line in takewhile(lambda line: line.startswith("#"), text.splitlines())
        )
        for name, text in texts().items()
    }
    if as_json:
        return print_json(sources)
    table(sources.items())
    return 0
