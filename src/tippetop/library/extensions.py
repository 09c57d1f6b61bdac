"""Events and columns of one's own, checked, and the system with them."""

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from ..engine.status import Status
from ..ensembles.outcomes import columns_of
from ..errors import InputError
from ..mechanics.consistency import rivals
from ..mechanics.event import NUMBERED, Event, Kept
from ..mechanics.system import Quantity, System
from ..mechanics.units import Unit
from ..scenario import build


NAME = r"[A-Za-z_][A-Za-z0-9_]*"
ALWAYS = (
    "time",
    "event",
    "top",
    "xyz",
    "wxyz",
    "psi",
    "orientation",
    "kind",
    "theta_dot_sign",
    "amplitude",
    "significant",
)
"""Names in tables that no system lists: dimensions, the orientation, and columns of the event log.
"""
BUILT_IN = ("status", "class", "top", "turning", "equators", "inversions")
"""Columns of ensembles that `columns_of` does not list."""
WHAT = ("first", "last", "count")
RESERVED = tuple(s.value for s in Status if s not in (Status.LIFTOFF, Status.FALLEN, Status.ENDED))
"""Statuses that are no event's to give."""


def given_records(argument: str, given: Any, kind: type[Event] | type[Quantity]) -> list[Any]:
    """Return the argument `events` or `columns` as a list of names and records.

    Raises InputError.
    """
    words = f"names of {argument} or {kind.__name__} records"
    if isinstance(given, str | kind):
        return [given]
    if (
        not isinstance(given, Iterable)
        or isinstance(given, bytes | Mapping)
        or getattr(given, "ndim", 1) != 1
    ):
        raise InputError(f"`{argument}` must be a list, but is {given!r:.60}.")
    listed = list(given)
    if wrong := [item for item in listed if not isinstance(item, str | kind)]:
        raise InputError([f"`{argument}` must be {words}, but has {item!r:.60}." for item in wrong])
    return listed


def of_stored(
    attrs: dict[str, Any],
    events: Iterable[Event] | Event | None = None,
    columns: Iterable[Quantity] | Quantity | None = None,
) -> System | None:
    """The system of a stored run with the events and columns that are its maker's own; None where
    none are given.

    Raises InputError."""
    own_events = [] if events is None else given_records("events", events, Event)
    own_columns = [] if columns is None else given_records("columns", columns, Quantity)
    if named := [each for each in (*own_events, *own_columns) if isinstance(each, str)]:
        raise InputError(
            f"the records that a stored run was made with must be given, but `{named[0]}` is a "
            "name."
        )
    if not own_events and not own_columns:
        return None
    if "content" in attrs:
        raise InputError(
            f"`events` and `columns` must be those of a run, but the store is a {attrs['content']}."
        )
    return extended(build.system_of(attrs), tuple(own_events), tuple(own_columns))


def extended(system: System, events: tuple[Event, ...], columns: tuple[Quantity, ...]) -> System:
    """The system with more events and columns; the same record for the same ones, so that it is
    compiled once.

    Raises InputError."""
    if not events and not columns:
        return system
    if faults := _faults(system, events, columns):
        raise InputError(faults)
    own = tuple(Event(**{**vars(event), "kept": tuple(event.kept)}) for event in events)
    return _extended(system, own, columns)


@lru_cache(maxsize=64)
def _extended(system: System, events: tuple[Event, ...], columns: tuple[Quantity, ...]) -> System:
    return system.replace(
        events=(*system.events, *events), quantities=(*system.quantities, *columns)
    )


def _faults(system: System, events: tuple[Event, ...], columns: tuple[Quantity, ...]) -> list[str]:
    """What is wrong with events and columns of one's own, in sentences."""
    known = {
        *ALWAYS,
        *NUMBERED,
        *(event.name for event in system.events),
        *(quantity.name for quantity in system.quantities),
        *system.angles._fields,
        *system.vectors,
    }
    faults = [f for event in events for f in _event_faults(event)] + [
        f for q in columns for f in _column_faults(q)
    ]
    faults += _names("the name of an event", [event.name for event in events], system, known)
    names = {event.name for event in events if isinstance(event.name, str)}
    faults += _names(
        "the name of a column", [quantity.name for quantity in columns], system, known, names
    )
    kept = [
        k
        for event in events
        if isinstance(event.kept, list | tuple)
        for k in event.kept
        if isinstance(k, Kept)
    ]
    numbers = {*columns_of(system), *BUILT_IN, *system.parameters, *system.initial, "mu", "until"}
    for law in system.laws.values():
        numbers |= set(law.parameters)
    faults += [] if faults else rivals([*system.events, *events])
    return faults + _names("the name of a Kept", [k.name for k in kept], system, numbers)


def _names(
    subject: str, names: list[Any], system: System, known: set[str], others: Iterable[str] = ()
) -> list[str]:
    """Sentences on names that cannot be, or are not new."""
    faults, seen = [], set(others)
    for name in names:
        if not isinstance(name, str) or not re.fullmatch(NAME, name):
            faults.append(
                f"{subject} must be letters, digits and _, and begin with no digit, but is "
                f"{name!r:.60}."
            )
        elif name in known:
            faults.append(f"`{name}` must be a new name, but `{system.name}` has it.")
        elif name in ("phase", "ball"):
            faults.append(
                f"{subject} must not be phase or ball, which say where the contact is, but is "
                f"`{name}`."
            )
        elif re.fullmatch(r"state_.*|final_.*|drift_.*|.*_lo", name):
            faults.append(
                f"{subject} must not be one of state_..., final_..., drift_... or ..._lo, but "
                f"is `{name}`."
            )
        elif name in seen:
            faults.append(f"{subject} must be given once, but `{name}` is given twice.")
        else:
            seen.add(name)
    return faults


def _event_faults(event: Any) -> list[str]:
    """What is wrong with an event by itself, in sentences."""
    of, faults = (
        f"of the event `{event.name}`",
        _formula_faults(f"of the event `{event.name}`", event.formula),
    )
    faults += _text_faults(of, event, "long_name")
    if event.direction not in (-1, 0, 1):
        faults.append(f"`direction` {of} must be -1, 0 or 1, but is {event.direction!r:.60}.")
    if event.ends is not None and (
        not isinstance(event.ends, str) or not event.ends or event.ends in RESERVED
    ):
        faults.append(
            f"`ends` {of} must be a word other than {', '.join(RESERVED)}, or None, but is "
            f"{event.ends!r:.60}."
        )
    if event.sampled:
        faults.append(f"`sampled` {of} must be False: only an exit of a phase may be sampled.")
    if not isinstance(event.kept, list | tuple) or not all(
        isinstance(kept, Kept) for kept in event.kept
    ):
        return [*faults, f"`kept` {of} must be Kept records, but is {event.kept!r:.60}."]
    for kept in event.kept:
        if kept.what not in WHAT:
            faults.append(
                f"`what` of the Kept `{kept.name}` must be one of {', '.join(WHAT)}, but is "
                f"{kept.what!r:.60}."
            )
        if kept.direction not in (-1, 0, 1):
            faults.append(
                f"`direction` of the Kept `{kept.name}` must be -1, 0 or 1, but is "
                f"{kept.direction!r:.60}."
            )
    return faults


def _column_faults(quantity: Any) -> list[str]:
    """What is wrong with a column by itself, in sentences."""
    of = f"of the column `{quantity.name}`"
    faults = _formula_faults(of, quantity.formula) + _text_faults(
        of, quantity, "symbol", "long_name"
    )
    if not isinstance(quantity.unit, Unit):
        faults.append(
            f"`unit` of the column `{quantity.name}` must be a Unit, but is {quantity.unit!r:.60}."
        )
    return faults


def _formula_faults(of: str, formula: Any) -> list[str]:
    return (
        [] if callable(formula) else [f"`formula` {of} must be a function, but is {formula!r:.60}."]
    )


def _text_faults(of: str, record: Any, *names: str) -> list[str]:
    return [
        f"`{name}` {of} must be a text, but is {getattr(record, name)!r:.60}."
        for name in names
        if not isinstance(getattr(record, name), str)
    ]
