"""`tippetop info, check, plot, systems, presets`: look at stores, scenarios, and what there is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


Json = Annotated[bool, Parameter(name="--json", negative=())]


def info(store: Path, *, as_json: Json = False) -> int:
    """Say what is in a store: status, events, inversion, drift of the invariants, provenance."""
    from rich.table import Table

    from ..runs.results import summary_of
    from ..runs.summary import lines
    from ..store import root
    from .text import console

    attrs = root.attributes(store)
    if attrs.get("content") == "sweep":
        from ..sweeps.summary import report
        from . import sweep

        return sweep.describe(report(store), as_json)
    if "content" in attrs:
        from .landscape import describe

        return describe(attrs, as_json)
    found = summary_of(attrs)
    if as_json:
        print(json.dumps(found.to_dict(), allow_nan=False))
        return 0
    out = console()
    out.print(attrs["title"], style="bold")
    table = Table.grid(padding=(0, 2))
    for name, text in lines(found):
        table.add_row(name, text)
    for name in ("parameters", "friction", "initial", "run", "versions"):
        if name in found:
            table.add_row(name, ", ".join(f"{k} = {v}" for k, v in found[name].items()))
    table.add_row("tolerance", f"{found['tolerance']:.3g}, {found['precision']} precision")
    table.add_row("processor", found["cpu"])
    out.print(table)
    return 0


def check(
    scenario: str,
    *,
    set_: Annotated[list[str] | None, Parameter(name="--set", negative=())] = None,
    as_json: Json = False,
) -> int:
    """Validate a scenario without running it: resolved parameters, invariants at the start, expected cost; or the plan
    of a sweep: its size and cost."""
    from rich.table import Table

    from ..runs import forecast
    from ..scenario import build, reading
    from ..sweeps import plan
    from .text import console

    tables = reading.override(reading.read(scenario), set_ or [])
    if plan.is_plan(tables):
        from . import sweep

        return sweep.examine(tables, Path(scenario).parent, as_json)
    problem = build.problem(tables)
    found = {**build.resolved(problem), **forecast.assessment(problem)}
    if as_json:
        from ..store.root import finite

        print(json.dumps(finite(found), allow_nan=False))
        return 0
    table = Table.grid(padding=(0, 2))
    for name, value in found.items():
        text = ", ".join(f"{k} = {_plain(v)}" for k, v in value.items()) if isinstance(value, dict) else _plain(value)
        table.add_row(name.replace("_", " "), text)  # units stand in brackets, which are markup to rich
    console().print(table)
    return 0


def plot(store: Path, kind: str | None = None, *, out: Path) -> int:
    """Draw a store: theta (with the nutational band), normal-force, drift, sphere, energy; band, surface, potential,
    inversion (a run in its landscape); of a sweep class, inversion, normal-force; the stores of `surface` and
    `potential` draw themselves."""
    from ..figures import catalogue
    from ..store import chunks, root
    from .run import _check_picture

    _check_picture(out)
    attrs = root.attributes(store)
    if attrs.get("content") == "sweep":
        catalogue.draw_sweep(kind or "class", store, out)
        return 0
    if "content" in attrs:
        from .landscape import picture

        return picture(store, attrs, out)
    kind = kind or "theta"
    catalogue.check_kind(kind)
    groups = {name: chunks.digest(store, name, "theta") for name in ("trajectory", "events")}
    catalogue.draw(kind, groups, attrs, out)
    return 0


def export(store: Path, *, to: str, out: Path, group: str | None = None) -> int:
    """Write a store as one netCDF, CSV or Parquet file; --group events for the event log (netCDF has both)."""
    from ..store.export import export as write

    write(store, to, out, group)
    return 0


def systems(*, as_json: Json = False) -> int:
    """List the systems with their forms, parameters and events."""
    from rich.table import Table

    from ..mechanics.systems import SYSTEMS, load_entry_points
    from .text import console

    load_entry_points()
    found: dict[str, dict[str, Any]] = {
        name: {
            "title": s.title,
            "forms": list(s.forms),
            "parameters": {n: p.unit.symbol for n, p in s.parameters.items()},
            "initial": {n: p.unit.symbol for n, p in s.initial.items()},
            "integrals": list(s.integrals),
            "events": [e.name for e in s.events],
            "source": s.source,
        }
        for name, s in SYSTEMS.items()
    }
    if as_json:
        print(json.dumps(found))
        return 0
    table = Table("system", "what", "forms", "parameters", "integrals", box=None, padding=(0, 2, 0, 0))
    for name, s in found.items():
        columns = (s["title"], " ".join(s["forms"]), " ".join(s["parameters"]), " ".join(s["integrals"]))
        table.add_row(name, *columns)
    console().print(table)
    return 0


def presets(*, as_json: Json = False) -> int:
    """List the built-in scenarios with their sources."""
    from rich.table import Table

    from ..scenario.reading import presets as texts
    from .text import console

    found = {name: _comment(text) for name, text in texts().items()}
    if as_json:
        print(json.dumps(found))
        return 0
    table = Table.grid(padding=(0, 2))
    for name, comment in found.items():
        table.add_row(name, comment)
    console().print(table)
    return 0


def _comment(text: str) -> str:
    """The leading comment of a preset: its source."""
    head = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        head.append(line.lstrip("# ").strip())
    return " ".join(head)


def _plain(value: Any) -> str:
    return f"{value:.8g}" if isinstance(value, float) else str(value)


COMMANDS: list[Any] = [info, check, plot, export, systems, presets]
TEXT_ONLY: list[Any] = [export, systems, presets]  # they compute nothing, and need no engine
