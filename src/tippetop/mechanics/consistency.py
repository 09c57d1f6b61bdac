"""Checks that the records of a system do not contradict one another."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from types import MappingProxyType
from typing import Any

from .events import Event
from .form import CLOCK, unchanged
from .number import rules_faults
from .system import Exit, Form, Landscape, Phase, Quantity, System
from .units import Unit


ONCE = {
    "sense": "turns of theta",
    "lasting": "what a motion settles into",
    "extremes": "the quantity whose least and greatest values are reported",
}
"""Fields of an event that one event of a phase at most may have, and what it is then the event of.
"""


def inconsistencies(system: System) -> list[str]:
    """What a system contradicts itself in: one sentence each; none of a sound one."""
    if faults := _shapeless(system):
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
        faults += [
            f"{where} must call the form {form.name!r} by its name, but calls it {key!r}."
            for key, form in phase.forms.items()
            if key != form.name
        ]
        if "auto" in phase.forms:
            faults.append(
                f"{where} must not call a form 'auto': that leaves the choice to the system."
            )
        for form in phase.forms.values():
            turning = form.orientation.integrals if form.orientation else ()
            variables = [
                *form.units._fields,
                *(integral.name for integral in (*form.integrals, *turning)),
            ]
            faults += _twice(f"{where}, form `{form.name}`: variable", variables)
        events = [event.name for event in phase.events]
        detected = [CLOCK, *(event.name for event in phase.events if event.formula)]
        lost = (
            [] if system.is_hybrid else [event.name for event in phase.events if not event.formula]
        )
        faults += [
            f"the event `{event}` of {where} must have a formula: no jump can log it."
            for event in lost
        ]
        faults += _twice(f"{where}: event", events)
        faults += rivals(phase.events)
        faults += _twice(f"{where}: quantity", [quantity.name for quantity in phase.quantities])
        faults += _twice(f"{where}: exit by the event", [way.event for way in phase.exits])
        for way in phase.exits:
            if way.event not in (*events, CLOCK):
                faults.append(
                    f"{where} must end in an event of its own, but has an exit by {way.event!r}."
                )
            elif way.event not in detected:
                faults.append(
                    f"{where} must end by an event with a formula, but `{way.event}` has none."
                )
            if not way.to:
                faults.append(f"{where} must lead somewhere by {way.event!r}, but leads nowhere.")
            faults += [
                f"{where} must lead to phases of the system, but leads to {to!r}."
                for to in way.to
                if to not in system.phases
            ]
    quantities = {quantity.name for quantity in system.quantities}
    faults += [
        f"`{system.name}` must have the quantity {n!r}, but has not."
        for n in system.integrals
        if n not in quantities
    ]
    return faults


def unmet_requirements(system: System) -> list[str]:
    """Return what a run needs and a consistent system lacks: one message each."""
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


KINDS = (
    ("title", str, "a text"),
    ("source", str, "a text"),
    ("phases", Mapping, "Phase records by name"),
    ("laws", MappingProxyType, "a dict of laws by name"),
    ("normalised_to", Mapping, "numbers by name"),
    ("long_names", Mapping, "texts by name"),
    ("integrals", (tuple, list), "a tuple of names"),
    ("alternatives", (tuple, list), "a tuple of Alternative records"),
    ("landscape", (Landscape, type(None)), "a Landscape or None"),
    ("vectors", Mapping, "names of variables by name"),
    ("on_request", (tuple, list), "a tuple of Quantity records"),
    ("contact", type(None), "None"),
)
"""Fields of a system, what they must be, and that in words."""

CALLED = ("potential", "theta_inertia", "outlook", "motion", "borders")
"""Fields of a system that must be functions where they are given."""

FORMULAS = ("body", "body_units", "scales", "start", "checks")
"""Fields of a system that must be functions."""


def _shapeless(system: System) -> list[str]:
    """Sentences on fields of a system that are not what they must be."""
    faults = [
        f"`{name}` of `{system.name}` must be a function, but is {getattr(system, name)!r:.60}."
        for name in FORMULAS
        if not callable(getattr(system, name))
    ]
    if not hasattr(system.angles, "_fields"):
        faults.append(
            f"`angles` of `{system.name}` must be a NamedTuple filled with units, but is "
            f"{system.angles!r:.60}."
        )
    for name in ("parameters", "initial"):
        faults += rules_faults(f"`{name}` of `{system.name}`", getattr(system, name))
    for name, kind, words in KINDS:
        if not isinstance(getattr(system, name), kind):
            faults.append(
                f"`{name}` of `{system.name}` must be {words}, but is "
                f"{getattr(system, name)!r:.60}."
            )
    normal: dict[str, Any] = {}
    normal |= system.normalised_to if isinstance(system.normalised_to, Mapping) else {}
    faults += [
        f"`normalised_to` of `{system.name}` must hold finite numbers, but `{name}` is "
        f"{value!r:.60}."
        for name, value in normal.items()
        if not (isinstance(value, int | float) and isfinite(value))
    ]
    for name in CALLED:
        value = getattr(system, name)
        if value is not None and not callable(value):
            faults.append(
                f"`{name}` of `{system.name}` must be a function or None, but is {value!r}."
            )
    return faults or _phaseless(system)


def _phaseless(system: System) -> list[str]:
    """Sentences on phases that are not what they must be."""
    if not system.phases:
        return [f"`phases` of `{system.name}` must have a Phase, but has none."]
    faults, phases = [], dict[str, Any](system.phases)
    for name, phase in phases.items():
        if not isinstance(phase, Phase):
            faults.append(
                f"`phases` of `{system.name}` must be Phase records by name, but has {phase!r:.60}."
            )
            continue
        where = f"phase `{name}` of `{system.name}`"
        forms: Any = phase.forms.values() if isinstance(phase.forms, Mapping) else [phase.forms]
        held: list[tuple[str, Any, type]] = [
            ("forms", forms, Form),
            ("events", phase.events, Event),
            ("quantities", phase.quantities, Quantity),
            ("exits", phase.exits, Exit),
        ]
        for what, records, kind in held:
            listed = (
                [records]
                if isinstance(records, str) or not isinstance(records, Iterable)
                else records
            )
            faults += [
                f"`{what}` of {where} must be {kind.__name__} records, but has {record!r:.50}."
                for record in listed
                if not isinstance(record, kind)
            ]
    return faults


def rivals(events: Sequence[Event]) -> list[str]:
    """Sentences on events of one phase that a run can follow only one of, and on one that can never
    hold.
    """
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
