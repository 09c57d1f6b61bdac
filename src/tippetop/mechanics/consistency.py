"""Checks that the records of a system do not contradict one another."""

from collections.abc import Callable, Sequence
from types import MappingProxyType, NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from .event import Event
from .form import CLOCK, unchanged
from .system import System
from .units import Unit


ONCE = {
    "sense": "turns of theta",
    "lasting": "what a motion settles into",
    "extremes": "the quantity whose least and greatest values are reported",
}
"""Fields that at most one event of a phase may have, and the meaning of that event."""


def inconsistencies(system: System) -> list[str]:
    """Return one message for each contradiction among the records of a system."""
    if faults := _wrong_types(system):
        return faults
    known: dict[str, Event] = {}
    for name, phase in system.phases.items():
        where = f"phase `{name}` of `{system.name}`"
        faults += [
            f"{where} must have Event `{event.name}` with the direction of the phases before, "
            "but has another one."
            for event in phase.events
            if known.setdefault(event.name, event).direction != event.direction
        ]
        if (phase.enter is unchanged) != (phase.leave is unchanged):
            faults.append(f"{where} must have both `enter` and `leave`, or neither, but has one.")
        if not phase.forms:
            faults.append(f"{where} must have a form, but has none.")
        for form in phase.forms.values():
            turning = form.orientation.integrals if form.orientation else ()
            integrals = [integral.name for integral in (*form.integrals, *turning)]
            variables = [*form.units._fields, *integrals]
            faults += _twice(f"{where}, form `{form.name}`: variable", variables)
        faults += [
            f"the event `{event.name}` of {where} must have a formula: no jump can log it."
            for event in phase.events
            if not (event.formula or system.is_hybrid)
        ]
        faults += _twice(f"{where}: event", [event.name for event in phase.events])
        faults += rivals(phase.events)
        faults += _twice(f"{where}: quantity", [quantity.name for quantity in phase.quantities])
        faults += _twice(f"{where}: exit by the event", [way.event for way in phase.exits])
        detected = [CLOCK, *(event.name for event in phase.events if event.formula)]
        for way in phase.exits:
            if way.event not in detected:
                faults.append(
                    f"{where} must end in one of its events that has a formula, but has an exit "
                    f"by {way.event!r}."
                )
            if not way.to:
                faults.append(f"{where} must lead somewhere by {way.event!r}, but leads nowhere.")
            faults += [
                f"{where} must lead to phases of the system, but leads to {to!r}."
                for to in way.to
                if to not in system.phases
            ]
    quantities = {quantity.name for quantity in system.quantities}
    return faults + [
        f"`{system.name}` must have the quantity {n!r}, but has not."
        for n in system.integrals
        if n not in quantities
    ]


def unmet_requirements(system: System) -> list[str]:
    """Return one message for each thing that a run needs and the system lacks."""
    of, phase, named = f"of `{system.name}`", system.phase, system.angles._fields
    faults = [
        f"`angles` {of} must have the field `{name}`, which the event log reads, but has "
        f"{', '.join(named)}."
        for name in ("theta", "theta_dot")
        if name not in named and not system.is_hybrid
    ]
    lacking = [name for name in (*named, *system.vectors) if name not in system.long_names]
    if lacking:
        faults.append(
            f"`long_names` {of} must describe each field of `angles` and `vectors`, but lacks "
            f"{', '.join(lacking)}."
        )
    balanced = "work" in named or not system.is_hybrid
    if balanced and "energy" not in {quantity.name for quantity in phase.quantities}:
        faults.append(
            f"`quantities` {of} must have `energy`, which the energy balance reads, but have not."
        )
    for form in phase.forms.values():
        faults += [
            f"the state of the form `{form.name}` {of} must be numbers, each filled with its Unit, "
            f"but `{name}` is {type(unit).__name__}: give each component of a vector its own field."
            for name, unit in form.units._asdict().items()
            if not isinstance(unit, Unit)
        ]
        if "work" not in named and any(integral.name == "work" for integral in form.integrals):
            faults.append(
                f"`angles` {of} must have the field `work`, which the energy balance reads, for "
                "the form "
                f"`{form.name}` integrates it."
            )
    if unknown := [f"`{name}`" for name in system.undefined_at_poles if name not in named]:
        faults.append(
            f"`undefined_at_poles` {of} must name fields of `angles`, but has {', '.join(unknown)}."
        )
    components = {name for names in system.vectors.values() for name in names}
    known = phase.forms["vector"].units._fields if "vector" in phase.forms else ()
    missing = ", ".join(sorted(components.difference(known)))
    if missing:
        faults.append(
            f"`vectors` {of} must be variables of a form `vector`, but it lacks {missing}."
        )
    return faults + [
        f"`kept` of the event `{event.name}` {of} must have a Kept of the name `lifted_at`, for it "
        "ends runs as liftoff."
        for event in phase.events
        if event.ends == "liftoff" and "lifted_at" not in [kept.name for kept in event.kept]
    ]


WORDS = {
    "Callable": "a function",
    "str": "a text",
    "NoneType": "None",
    "Mapping": "a mapping",
    "mappingproxy": "a dict of laws by name",
}
"""Types in words."""

HINTS: dict[str, Any] = {
    **get_type_hints(System),
    **dict.fromkeys(("body", "body_units", "start"), Callable),
    "contact": NoneType,
    "laws": MappingProxyType,
}


def _wrong_types(system: System) -> list[str]:
    """Return one message for each field that has the wrong type."""
    of = f"of `{system.name}`"
    faults = []
    for name, hint in HINTS.items():
        given = get_args(hint) if get_origin(hint) in (UnionType, Union) else (hint,)
        kinds = tuple(get_origin(kind) or kind for kind in given)
        if Any not in kinds and not isinstance(value := getattr(system, name), kinds):
            words = " or ".join(WORDS.get(k.__name__, f"a {k.__name__}") for k in kinds)
            faults.append(f"`{name}` {of} must be {words}, but is {value!r:.60}.")
    if not faults and not system.phases:
        faults.append(f"`phases` {of} must have a Phase, but has none.")
    return faults


def rivals(events: Sequence[Event]) -> list[str]:
    """Return messages on events of one phase that exclude each other, or never happen."""
    faults = []
    for field, what in ONCE.items():
        names = [f"`{event.name}`" for event in events if getattr(event, field)]
        if len(names) > 1:
            faults.append(
                f"`{field}` ({what}) must be that of one event, but is given in "
                f"{' and '.join(names)}."
            )
    return faults + [
        f"`direction` of the event `{event.name}` must be -1 or 1, for it is `lasting`, but is 0."
        for event in events
        if event.lasting and event.direction == 0
    ]


def _twice(what: str, names: list[str]) -> list[str]:
    return [
        f"{what} {name!r} must be there once, but is there {names.count(name)} times."
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
