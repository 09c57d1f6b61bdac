"""User-defined events and columns, checked, and the system with them.

The arguments `events` and `columns` go in; a checked system comes out.
"""

import dataclasses
import re
from collections.abc import Iterable, Mapping
from typing import Any

from ..engine.status import Status
from ..ensembles.outcomes import LYAPUNOV, ORIENTATION, columns_of
from ..errors import InputError
from ..mechanics.event import NUMBERED, Event
from ..mechanics.system import Quantity, System
from ..mechanics.systems.consistency import rivals
from ..scenario import build
from ..scenario.sentences import type_faults


NAME = r"[A-Za-z_][A-Za-z0-9_]*"
ALWAYS = (
    "time",
    "event",
    "top",
    "t",
    "xyz",
    "wxyz",
    "psi",
    "orientation",
    "kind",
    "theta_dot_sign",
    "amplitude",
    "significant",
    "phase",
    "ball",
)
"""Names that no system lists: dimensions, the orientation, columns of events."""
BUILT_IN = ("status", "class", "top", "turning", "equators", "inversions")
"""Columns of ensembles that `columns_of` does not list."""
RESERVED = tuple(s.value for s in Status if s not in (Status.LIFTOFF, Status.FALLEN, Status.ENDED))
"""Statuses that no event may give."""


def given_records(argument: str, given: Any, kind: type[Event] | type[Quantity]) -> list[Any]:
    """Return the argument `events` or `columns`, one or several, as a list of names and records.

    A record must be of the type `kind`. Raises InputError.
    """
    if given is None:
        return []
    if isinstance(given, str | kind):
        return [given]
    is_list = isinstance(given, Iterable) and not isinstance(given, bytes | Mapping)
    if not is_list or getattr(given, "ndim", 1) != 1:
        raise InputError(f"`{argument}` must be a list, but is {given!r:.60}.")
    listed = list(given)
    if wrong := [item for item in listed if not isinstance(item, str | kind)]:
        words = f"names of {argument} or {kind.__name__} records"
        raise InputError([f"`{argument}` must be {words}, but has {item!r:.60}." for item in wrong])
    return listed


def of_stored(attrs: dict[str, Any], events: Any = None, columns: Any = None) -> System | None:
    """Return the system of a stored run with the user's events and columns; None without any.

    `attrs` are the root attributes of the store, which has no formulas: `open` and `resume` get the
    records again. Raises InputError.
    """
    events = given_records("events", events, Event)
    columns = given_records("columns", columns, Quantity)
    for each in (*events, *columns):
        if isinstance(each, str):
            raise InputError(
                f"the records that a stored run was made with must be given, but `{each}` is a "
                "name."
            )
    if not events and not columns:
        return None
    if "content" in attrs:
        raise InputError(
            f"`events` and `columns` must be those of a run, but the store is a {attrs['content']}."
        )
    return extended(build.system_of(attrs), tuple(events), tuple(columns))


def extended(system: System, events: tuple[Event, ...], columns: tuple[Quantity, ...]) -> System:
    """Return the system with more events and columns: the same record for the same ones.

    So it is compiled once: `System.with_records` caches by their values, hence the tuples of
    `kept`. Raises InputError.
    """
    if not events and not columns:
        return system
    if faults := _faults(system, events, columns):
        raise InputError(faults)
    own = tuple(dataclasses.replace(event, kept=tuple(event.kept)) for event in events)
    return system.with_records(own, columns)


def _faults(system: System, events: tuple[Event, ...], columns: tuple[Quantity, ...]) -> list[str]:
    """Return a sentence for each fault of user-defined events and columns of a system.

    Names are compared only where all fields have the right types.
    """
    faults = [fault for column in columns for fault in type_faults("column", column)]
    for event in events:
        faults += type_faults("event", event) or _kept_faults(event) or _event_faults(event)
    if faults:
        return faults
    known = {*ALWAYS, *NUMBERED, *system.angles._fields, *system.vectors, *system.record_names}
    names = [event.name for event in events]
    faults = _names("the name of an event", names, system, known)
    faults += _names("the name of a column", [c.name for c in columns], system, known, names)
    faults += [] if faults else rivals([*system.events, *events])
    numbers = {*columns_of(system), *ORIENTATION, LYAPUNOV, *BUILT_IN, "mu", "until"}
    numbers.update(system.parameters, system.initial)
    numbers.update(*(law.parameters for law in system.laws.values()))
    numbers.update(f"{column.name}_end" for column in columns)
    kept = [k.name for event in events for k in event.kept]
    return faults + _names("the name of a Kept", kept, system, numbers)


def _names(
    subject: str, names: list[str], system: System, known: set[str], others: Iterable[str] = ()
) -> list[str]:
    """Return a sentence for each name that is invalid or already taken.

    `known` are names of the system, `others` those of other records of the user. Rows and
    tables of sweeps have columns state_..., final_..., drift_... and ..._lo.
    """
    faults = []
    seen = set(others)
    for name in names:
        must = ""
        if not re.fullmatch(NAME, name):
            must = f"be letters, digits and _, and begin with no digit, but is {name!r:.60}."
        elif name in known:
            faults.append(f"`{name}` must be a new name, but `{system.name}` has it.")
        elif re.fullmatch(r"state_.*|final_.*|drift_.*|.*_lo", name):
            must = f"not be one of state_..., final_..., drift_... or ..._lo, but is `{name}`."
        elif name in seen:
            must = f"be given once, but `{name}` is given twice."
        else:
            seen.add(name)
        faults += [f"{subject} must {must}"] if must else []
    return faults


def _kept_faults(event: Event) -> list[str]:
    """Return a sentence for each field of a wrong type in the numbers that an event keeps."""
    return [fault for kept in event.kept for fault in type_faults("number", kept)]


def _event_faults(event: Event) -> list[str]:
    """Return a sentence for each fault of an event whose fields have the right types."""
    of = f"of the event `{event.name}`"
    faults = []
    if not callable(event.formula):
        faults.append(f"`formula` {of} must be a function, but is {event.formula!r:.60}.")
    if event.sampled:
        faults.append(f"`sampled` {of} must be False: only an exit of a phase may be sampled.")
    if event.ends in ("", *RESERVED):
        must = f"a word other than {', '.join(RESERVED)}, or None"
        faults.append(f"`ends` {of} must be {must}, but is {event.ends!r:.60}.")
    records: list[Any] = [event, *event.kept]
    return faults + [
        f"`direction` of `{each.name}` must be -1, 0 or 1, but is {each.direction}."
        for each in records
        if each.direction not in (-1, 0, 1)
    ]
