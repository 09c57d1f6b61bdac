"""Python arguments become the tables of a scenario, and a checked Problem."""

import contextlib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..arguments import instance, measured_values, plain, takes
from ..errors import InputError
from ..mechanics.contact.body import Top
from ..mechanics.event import Event
from ..mechanics.friction import LAWS, FrictionLaw, named
from ..mechanics.system import Quantity, System
from ..mechanics.systems import check, laws_of, load_entry_points, systems_of_laws
from ..mechanics.units import SECOND
from ..problem import Problem
from ..problem.options import run_options
from ..runs import starting
from ..scenario import build, reading
from .extensions import extended, given_records


@takes(run_options)
def problem_of(
    source: Any,
    friction: Any = None,
    *,
    start: Mapping[str, Any] | str | Path | None = None,
    initial: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    system: str | System | None = None,
    form: str | None = None,
    contact: Mapping[str, Any] | None = None,
    stem: Mapping[str, float] | None = None,
    **options: Any,
) -> Problem:
    """Return the checked Problem of what `run` takes. Raises InputError."""
    if isinstance(source, Problem):
        beside = {
            "friction": friction,
            "start": start,
            "initial": initial,
            "parameters": parameters,
            "system": system,
            "form": form,
            "contact": contact,
            "stem": stem,
            **options,
        }
        if surplus := [f"`{key}`" for key, value in beside.items() if value is not None]:
            words = ", ".join(surplus)
            raise InputError(
                f"a Problem must stand alone, but is given beside {words}: change it in `load`."
            )
        return checked(source)
    named, own = _named("events", options.pop("events", None), Event)
    named_columns, own_columns = _named("columns", options.pop("columns", None), Quantity)
    if named_columns and len(own_columns) == len(named_columns):  # they are added to all columns
        named_columns = None
    with _in_python():
        tables, record = _tables(source, system, friction)
        chosen = record or build.system_of(tables)
        if isinstance(friction, list | tuple) and not hasattr(friction, "_fields"):
            tables = _assigned(tables, friction)
        elif isinstance(friction, Mapping):
            _merge_dotted(tables, plain(friction))
        elif friction is not None:
            tables["friction"] = plain(table_of(friction))
        for name, numbers in (("parameters", parameters), ("contact", contact), ("stem", stem)):
            _merge(tables, name, numbers)
        if start is not None and initial is not None:
            raise InputError(
                "`start` and `initial` are the same argument: one of them must be given, but "
                "both are."
            )
        starts: dict[str, Any] = {"start": start, "initial": initial}
        for name, given in starts.items():
            if isinstance(given, str | os.PathLike):
                given = {"from": os.fspath(given)}
            if given is not None:
                instance(
                    name, given, Mapping, "a mapping such as dict(theta=0.1), or the store of a run"
                )
            _start(tables, given or {}, chosen)
        if form is not None:
            tables["form"] = form
        if isinstance(source, Top) and chosen.frictional and "friction" not in tables:
            raise InputError(_needs_law(source))
        _options(tables, options | {"events": named, "columns": named_columns})
        chosen = extended(chosen, own, own_columns)
        if own_columns and named_columns is None and "columns" in tables.get("run", {}):
            tables["run"]["columns"] = [*tables["run"]["columns"], *(q.name for q in own_columns)]
        return starting.problem(tables, source, chosen)


def checked(problem: Problem) -> Problem:
    """A problem that was checked, or is now. Raises InputError."""
    with _in_python():
        return build.checked(problem)


def _tables(
    source: Any, system: str | System | None, friction: Any
) -> tuple[dict[str, Any], System | None]:
    """The tables that the source gives, and the record of its system where that need not be the
    registered one.
    """
    record = system if isinstance(system, System) else None
    for each in (record, source):
        if isinstance(each, System):
            check(each)
    if isinstance(source, Top):
        glides = friction is not None or source.gliding == "tippe-top"
        tables: dict[str, Any] = {
            "system": source.gliding if glides else source.resting,
            "parameters": source._asdict(),
        }
    elif isinstance(source, System):
        record, tables = record or source, {"system": source.name}
    elif isinstance(source, Mapping):
        tables = plain(source)
    elif isinstance(source, str | os.PathLike):
        tables = reading.read(os.fspath(source))
    else:
        raise InputError(
            "the first argument must be a body (TippeTop, HeavyTop, Cylinder), the name of a "
            "preset, a TOML file, "
            f"the tables of a scenario or a System, but is {source!r:.60}."
        )
    if system is not None and not isinstance(source, System):
        tables["system"] = record.name if record else system
        chosen = record or build.system_of(tables)
        if not chosen.frictional:
            tables.pop("friction", None)  # of the base: what is given beside it, is added later
        if tables.get("form") not in chosen.forms:
            tables.pop("form", None)
    return tables, record


def _named(argument: str, given: Any, kind: Any) -> tuple[list[str] | None, tuple[Any, ...]]:
    """Return the names of the events to log or the columns to keep, None for all, and the user's
    records of them.
    """
    if given is None:
        return None, ()
    records = given_records(argument, given, kind)
    own = tuple(each for each in records if isinstance(each, kind))
    return [each if isinstance(each, str) else each.name for each in records], own


def _assigned(tables: dict[str, Any], assignments: Any) -> dict[str, Any]:
    """The tables with `table.key=value` texts applied."""
    for assignment in assignments:
        if not isinstance(assignment, str):
            raise InputError(
                f"the assignments must be texts `table.key=value`, but have {assignment!r:.60}."
            )
    try:
        return reading.override(tables, list(assignments))
    except InputError as error:
        words = (
            s.replace("--set must", "an assignment must").replace("--set ", "")
            for s in error.sentences
        )
        raise InputError(list(words)) from None


def _merge_dotted(tables: dict[str, Any], given: dict[str, Any]) -> None:
    """Applies numbers of the friction law; keys with a dot name other tables."""
    own = {key: value for key, value in given.items() if "." not in key}
    for key in given.keys() - own.keys():
        table, _, name = key.partition(".")
        if not isinstance(tables.get(table, {}), dict):
            raise InputError(f"`{key}` must name a key of a table, but `{table}` is not a table.")
        tables[table] = {**tables.get(table, {}), name: given[key]}
    base = tables.get("friction", {})
    keep = isinstance(base, dict) and own.get("law", base.get("law")) == base.get("law")
    if own:
        tables["friction"] = {**base, **own} if keep else own


def _merge(tables: dict[str, Any], name: str, given: Any) -> None:
    if given is None:
        return
    if isinstance(given, Top):
        given = given._asdict()
    instance(name, given, Mapping, "a mapping of names to numbers")
    base = tables.get(name, {})
    if isinstance(base, dict):  # else the check of the scenario says so
        tables[name] = {**base, **plain(given)}


def _start(tables: dict[str, Any], given: Mapping[str, Any], system: System) -> None:
    """Applies initial data; what says the same in another way in the base goes."""
    base = tables.get("initial", {})
    if not isinstance(base, dict):  # the check of the scenario says so
        return
    if "from" in given:  # where another run ended: nothing that the base says of the start
        tables["initial"] = dict(given)
    elif given or base:
        tables["initial"] = system.replaced(base, plain(given))


def _options(tables: dict[str, Any], run: dict[str, Any]) -> None:
    """Applies options of the run; those that are None are not given."""
    given = {key: plain(value) for key, value in run.items() if value is not None}
    if "output_times" in given:
        given["output_times"] = measured_values("output_times", given["output_times"], SECOND)
    if isinstance(given.get("sensitivities"), str):
        given["sensitivities"] = [given["sensitivities"]]
    base = tables.get("run", {})
    if not isinstance(base, dict):  # the check of the scenario says so
        return
    tables["run"] = {**reading.without_output(base, given), **given}
    until, times = given.get("until"), base.get("output_times")
    if (
        isinstance(times, list)
        and isinstance(until, int | float)
        and "output_times" in tables["run"]
    ):
        tables["run"]["output_times"] = reading.times_until(times, until)


def table_of(law: Any) -> dict[str, Any]:
    """Return the table [friction] of the record of a law that is known. Raises InputError."""
    if isinstance(law, FrictionLaw):
        if named(type(law)) is None:
            load_entry_points()
            if (
                named(type(law), {name: known for name, (known, _) in systems_of_laws().items()})
                is None
            ):
                kind = type(law).__name__
                raise InputError(
                    f"the friction law {kind} must be registered: "
                    f"tippetop.extending.register({kind})."
                )
        return {"law": law.key, **law._asdict()}
    such, value = "Viscous(mu=0.3)", f"{law!r:.60}"
    if isinstance(law, str):
        load_entry_points()
        such = f"{LAWS[law].__name__ if law in LAWS else 'Viscous'}(...)"
    elif isinstance(law, type):
        such, value = f"{law.__name__}(...)", "the class itself"
    raise InputError(f"the friction law must be a record such as {such}, but is {value}.")


def record_of(law: Any, system: System) -> Any:
    """Return the record of a law, checked, if a system takes it. Raises InputError."""
    known = laws_of(system)
    if (name := table_of(law)["law"]) not in known:
        raise InputError(f"`{system.name}` must have a law of {', '.join(known)}, but has {name}.")
    return law._make(law.checked(law._asdict()).values())


def _needs_law(top: Top) -> str:
    kind = type(top).__name__
    return (
        f"a {kind} that glides must have a friction law, such as Viscous(mu=0.3), but has none; "
        f'system="{top.resting}" needs none.'
    )


@contextlib.contextmanager
def _in_python() -> Iterator[None]:
    """A block whose InputErrors are in the words of a call: options of the run are arguments, hints
    for the command line go.
    """
    try:
        yield
    except InputError as error:
        without_hints = [re.sub(r" \(--set [^)]*\)", "", sentence) for sentence in error.sentences]
        words = [
            re.sub(r"`run\.(\w+)", r"`\1", s.replace("run.until =", "until ="))
            for s in without_hints
        ]
        raise InputError(words) from error.__cause__
