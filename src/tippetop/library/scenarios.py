"""Python arguments become the tables of a scenario, and a checked Problem.

`problem_of` has the arguments of `tippetop.run`; they replace values in the tables of the source,
which `scenario.build` checks.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..arguments import PlainData, in_python, instance, measured_values, plain, takes
from ..errors import InputError
from ..mechanics.contact.body import Top
from ..mechanics.event import Event
from ..mechanics.friction import FrictionLaw, is_known
from ..mechanics.system import Quantity, System
from ..mechanics.systems import check, laws_of, load_entry_points
from ..mechanics.units import SECOND
from ..problem import Problem
from ..problem.options import run_options
from ..runs import starting
from ..scenario import build, reading
from .extensions import extended, given_records
from .registering import LAWS


@takes(run_options)
def problem_of(
    source: Any,
    friction: Any = None,
    *,
    start: Mapping[str, Any] | str | Path | None = None,
    parameters: Mapping[str, Any] | None = None,
    system: str | System | None = None,
    form: str | None = None,
    contact: Mapping[str, Any] | None = None,
    stem: Mapping[str, float] | None = None,
    air: Mapping[str, Any] | None = None,
    plane: Mapping[str, Any] | None = None,
    **options: Any,
) -> Problem:
    """Return the checked Problem of the arguments of `run`. Raises InputError.

    `run`, `ensemble`, `sensitivities` and `lyapunov` take its keywords by `takes`: a new one here
    is an argument of all of them. A system is chosen before other tables are changed, because it
    determines which of those of the source are left.
    """
    about: dict[str, Any] = {"parameters": parameters, "contact": contact, "stem": stem}
    about |= {"air": air, "plane": plane}
    others = {"friction": friction, "start": start, "system": system, "form": form}
    given = [name for name, value in (others | about | options).items() if value is not None]
    if isinstance(source, Problem):
        if given:
            surplus = ", ".join(f"`{name}`" for name in given)
            raise InputError(
                f"a Problem must be the only argument, but {surplus} is given too: "
                "give the preset or file that it was loaded from instead."
            )
        with in_python():
            return build.checked(source)
    if not given and isinstance(source, str) and not os.path.isfile(source):
        return _preset(source)
    names, events = _named("events", options.pop("events", None), Event)
    kept, columns = _named("columns", options.pop("columns", None), Quantity)
    if kept and len(columns) == len(kept):  # only records: they are added to all columns
        kept = None
    with in_python():
        tables, chosen = _tables(source, system, friction)
        if isinstance(friction, Mapping):
            _merge(tables, "friction", plain(friction))
        elif friction is not None:
            tables["friction"] = plain(table_of(friction))
        for name, numbers in about.items():
            if numbers is not None:
                numbers = numbers._asdict() if isinstance(numbers, Top) else numbers
                instance(name, numbers, Mapping, "a mapping of names to numbers")
                _merge(tables, name, plain(numbers))
        _start(tables, start, chosen)
        if form is not None:
            tables["form"] = form
        if isinstance(source, Top) and chosen.frictional and "friction" not in tables:
            kind = type(source).__name__
            raise InputError(
                f"a {kind} that glides must have a friction law, such as Viscous(mu=0.3), but has "
                f'none; system="{source.resting}" needs none.'
            )
        _options(tables, run_options(**options, events=names, columns=kept))
        chosen = extended(chosen, events, columns)
        if columns and kept is None and "columns" in tables.get("run", {}):
            tables["run"]["columns"] = [*tables["run"]["columns"], *(q.name for q in columns)]
        return starting.problem_from_tables(tables, source, chosen)


@lru_cache(maxsize=64)
def _preset(name: str) -> Problem:
    """Return the Problem of a preset, or of another text that is no file, which is refused.

    Cached, as a Problem never changes and takes some milliseconds.
    """
    return starting.load(name)


def _tables(source: Any, system: str | System | None, friction: Any) -> tuple[PlainData, System]:
    """Return the tables of the source, and its system, as arguments of `run` determine them.

    The tables are a copy, which the caller may change. A user's System, which need not be
    registered, is checked for each run. Raises InputError.
    """
    record = next((each for each in (system, source) if isinstance(each, System)), None)
    if record is not None:
        check(record)
    if isinstance(source, Top):
        glides = friction is not None or source.gliding == "tippe-top"
        tables: PlainData = {
            "system": source.gliding if glides else source.resting,
            "parameters": source._asdict(),
        }
    elif isinstance(source, System):
        tables = {"system": source.name}
    elif isinstance(source, Mapping):
        tables = plain(source)
    elif isinstance(source, str | os.PathLike):
        tables = reading.read(os.fspath(source))
    else:
        raise InputError(
            "the first argument must be a body (TippeTop, HeavyTop, Cylinder, Spheroid, Disc, "
            "Ellipsoid), the name of a preset, a TOML file, the tables of a scenario or a System, "
            f"but is {source!r:.60}."
        )
    if system is not None:
        tables["system"] = record.name if record else system
    chosen = record or build.system_of(tables)
    if system is not None:
        if not chosen.frictional:
            tables.pop("friction", None)  # of the source; another one is added later
        if tables.get("form") not in chosen.forms:
            tables.pop("form", None)
    return tables, chosen


def _named(argument: str, given: Any, kind: Any) -> tuple[list[str] | None, tuple[Any, ...]]:
    """Return the names of the events to log or the columns to keep, and the user's records.

    `given` is the argument `events` or `columns`, with records of type `kind`. The names include
    those of the records, in the order of `given`; they are None if `given` is None: all are kept
    then. Raises InputError.
    """
    if given is None:
        return None, ()
    records = given_records(argument, given, kind)
    own = tuple(each for each in records if isinstance(each, kind))
    return [each if isinstance(each, str) else each.name for each in records], own


def _merge(tables: PlainData, name: str, given: PlainData) -> None:
    """Add values to the table `name` of a scenario, in place.

    A table that is no mapping is left: the check of the scenario reports it.
    """
    base = tables.get(name, {})
    if isinstance(base, dict):
        tables[name] = reading.merged(name, base, given)


def _start(tables: PlainData, given: Any, system: System) -> None:
    """Replace initial data in place, and those of the source that mean the same in another way.

    `given` is the argument `start`: a mapping, or the path of a store, which becomes
    `initial.from` and is read by `starting.problem_from_tables`. Raises InputError.
    """
    if isinstance(given, str | os.PathLike):
        given = {"from": os.fspath(given)}
    given = given if given is not None else {}
    base = tables.get("initial", {})
    instance("start", given, Mapping, "a mapping such as dict(theta=0.1), or the store of a run")
    if not isinstance(base, dict):  # the check of the scenario reports it
        return
    if "from" in given:  # where another run ended: it replaces the start of the source
        tables["initial"] = dict(given)
    elif given or base:
        tables["initial"] = system.replaced(base, plain(given))


def _options(tables: PlainData, run: PlainData) -> None:
    """Replace options in the table `run` in place; `run` are those that were given.

    Times of rows may be texts with units: the schema of a scenario takes numbers [s] only.
    """
    given = plain(run)
    if isinstance(times := given.get("output_times"), list):
        given["output_times"] = measured_values("output_times", times, SECOND).tolist()
    _merge(tables, "run", given)


def table_of(law: Any) -> PlainData:
    """Return the table [friction] of the record of a law that is known. Raises InputError."""
    if isinstance(law, FrictionLaw):
        kind = type(law)
        if not is_known(kind):
            load_entry_points()
            if not is_known(kind, LAWS):
                raise InputError(
                    f"the friction law {kind.__name__} must be registered: "
                    f"tippetop.extending.register({kind.__name__})."
                )
        return {"law": law.key, **law._asdict()}
    such = "Viscous(mu=0.3)"
    value = f"{law!r:.60}"
    if isinstance(law, str) and law in LAWS:
        such = f"{LAWS[law].__name__}(...)"
    elif isinstance(law, type):
        such = f"{law.__name__}(...)"
        value = "the class itself"
    raise InputError(f"the friction law must be a record such as {such}, but is {value}.")


def record_of(law: Any, system: System) -> Any:
    """Return the record of a law, checked, if a system takes it. Raises InputError.

    Numbers that were replaced by `_replace`, which checks nothing, are found here.
    """
    known = laws_of(system)
    if (name := table_of(law)["law"]) not in known:
        raise InputError(f"`{system.name}` must have a law of {', '.join(known)}, but has {name}.")
    return law._make(law.checked(law._asdict()).values())
