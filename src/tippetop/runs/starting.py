"""Load scenarios, also those whose start is exactly the end of a stored run.

A file, a preset or tables go in, a checked `Problem` comes out; `scenario.build` checks it.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData, path_of
from ..engine.observables import Observables
from ..engine.status import Status
from ..errors import InputError, StoreError
from ..mechanics.contact.surroundings import TABLES
from ..mechanics.system import System
from ..problem import Problem
from ..scenario import build, reading
from ..store import hexfloat, ledger, root


SAME = ("system", "form", "parameters")
"""Tables that a run shares with the one where it starts."""
TAKEN = (*SAME, "friction", "contact", "stem", *TABLES)
"""Tables that are copied from the other run unless they are given."""


def load(
    source: str | os.PathLike,
    assignments: list[str] | None = None,
    until: float | str | None = None,
) -> Problem:
    """Return the checked Problem of a TOML file or a preset.

    Parameters
    ----------
    source : str or path
        A TOML file, or the name of a preset.
    assignments : list of str, optional
        `table.key=value` texts, as the command line's `--set` takes them.
    until : float or str, optional
        Another end of the run [s], or a text with a unit, "2 min".

    Returns
    -------
    Problem

    Raises
    ------
    InputError
        With one message for each fault.
    StoreError
        If `initial.from` is not a store from which a run can start.
    """
    tables = reading.override(reading.read(str(path_of("source", source))), assignments)
    return problem_from_tables(build.ending(tables, until), source)


def load_any(source: str | os.PathLike, assignments: list[str] | None = None) -> Problem:
    """Return the Problem of a TOML file, a preset or the store of a run. Raises InputError."""
    if not Path(source).is_dir():
        return load(source, assignments)
    attrs = root.attributes(Path(source))
    if "content" in attrs:
        raise InputError(
            f"the reference must be a scenario or a run, but `{source}` is a {attrs['content']}."
        )
    if not assignments:
        return build.stored(attrs)
    return build.problem(reading.override(build.tables_of(attrs), assignments))


def problem_from_tables(tables: PlainData, source: Any, known: System | None = None) -> Problem:
    """Return the checked Problem of a scenario's tables, read from `source`.

    Their `initial.from` may name the store of a run, from the folder of the source. The new run
    keeps its exact end as `Problem.origin`, the stored attribute `start`. `known` is the system, if
    it has user-defined events or columns.

    Raises
    ------
    InputError
        With one message for each fault.
    StoreError
        There is no store of a run that has ended, or it is damaged.
    """
    initial = tables.get("initial")
    if not isinstance(initial, dict) or "from" not in initial:
        return build.problem(tables, known)
    if len(initial) > 1:
        surplus = ", ".join(f"`{name}`" for name in initial if name != "from")
        raise InputError(f"`initial.from` must be given alone, but {surplus} is given too.")
    is_file = isinstance(source, str | os.PathLike) and os.path.isfile(source)
    folder = Path(source).parent if is_file else Path()
    path = folder / path_of("initial.from", initial["from"])
    attrs = _ended(path)
    tables = {name: attrs[name] for name in TAKEN if name in attrs} | tables
    if tables["form"] == "auto":
        tables["form"] = attrs["form"]
    # its user-defined events and columns are not needed
    options = {k: v for k, v in attrs["run"].items() if k not in ("events", "columns")}
    before = build.problem(build.tables_of(attrs) | {"run": options})
    end = ledger.read(path).end
    # doubles to be added, here and in `Problem.alone`
    parts = [[float.fromhex(part) for part in text.split()] for text in end["end"]["state"]]
    state = np.array([[sum(map(before.number, each)) for each in parts]], dtype=before.number)
    others: list[str] = ["system"] if tables["system"] != attrs["system"] else []
    if not others:
        run = build.problem(tables | {"initial": _rounded(before, state)}, known)
        resolved = build.resolved(run)
        others = [name for name in SAME if resolved[name] != attrs[name]]
        if (run.contact is None) != (before.contact is None):
            others.append("contact")
        # air and plane must have numbers of the same names; their values may differ
        there = run.tables, before.tables
        around = [n for n in TABLES if len({(*one.get(n, {}),) for one in there}) > 1]
        others += around
        if not around and not set(run.variables.names) <= set(before.variables.names):
            others.append("run.orientation")
    if others:
        words = f"must be that of `{path}`, whose end is the start, but is another."
        raise InputError([f"`{name}` {words}" for name in others])
    joint = hexfloat.decode(end["end"].get("joint", {}))
    if any(resolved.get(name) != attrs.get(name) for name in TAKEN):  # another phase may follow
        joint.pop("next", None)
    origin = {
        "from": str(initial["from"]),
        "digest": hashlib.sha256(json.dumps(end, sort_keys=True).encode()).hexdigest(),
        "t_end": attrs["report"]["t_end"],
        "form": attrs["form"],
        "joint": joint,
        "state": dict(zip(before.variables.names, parts, strict=True)),
    }
    return build.problem(tables | {"initial": dict(run.initial)}, known, origin)


def _ended(path: Path) -> PlainData:
    """Return the root attributes of the store of a run that ended ordinarily. Raises StoreError."""
    attrs = root.attributes(path)
    if "content" in attrs or "replay" in attrs:
        raise StoreError(f"`{path}` must be the store of a run to start from, but is another.")
    if attrs["status"] not in [status.value for status in Status if status.ordinary]:
        raise StoreError(
            f"`{path}` must have come to its end to start from, but: {attrs['reason']}."
        )
    return attrs


def _rounded(before: Problem, state: np.ndarray) -> dict[str, float]:
    """Return the initial data, SI by name, that a state (1, variables) of a run rounds to.

    Only for people to read: the run starts from the exact state.
    """
    # initial data are those of the sphere, while the state may be that of the stem
    if before.contact is not None and before.contact.stem:
        state = state.copy()
        names = before.variables.names
        for name, value in (("radius", before.internal_body.R), ("offset", before.internal_body.c)):
            if name in names:
                state[0, names.index(name)] = value
    columns = Observables(before).columns(np.zeros(1), state)
    others = {alternative.name for alternative in before.system.alternatives}
    known = [name for name in before.system.initial if name in columns and name not in others]
    values = {name: float(columns[name].values[0]) for name in known}
    if "gap" in values:
        values["gap"] = max(values["gap"], 0.0)  # a contact is under the plane by rounding
    return {name: value for name, value in values.items() if np.isfinite(value)}
