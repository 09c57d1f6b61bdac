"""Checks that the records of a system do not contradict one another."""

from collections.abc import Mapping, Sequence

from .events import Event
from .system import Parameter, System


ONCE = {
    "sense": "turns of theta",
    "lasting": "what a motion settles into",
    "extremes": "the quantity whose least and greatest values are reported",
}
"""Fields of an event that one event of a phase at most may have, and what it is then the event of."""


def inconsistencies(system: System) -> list[str]:
    """What a system contradicts itself in: one sentence each; none of a sound one."""
    faults = _shapeless(system)
    for name, phase in system.phases.items():
        where = f"phase `{name}` of `{system.name}`"
        if not phase.forms:
            faults.append(f"{where} must have a form, but has none.")
        faults += [
            f"{where} must call the form {form.name!r} by its name, but calls it {key!r}."
            for key, form in phase.forms.items()
            if key != form.name
        ]
        if "auto" in phase.forms:
            faults.append(f"{where} must not call a form 'auto': that leaves the choice to the system.")
        for form in phase.forms.values():
            turning = form.orientation.integrals if form.orientation else ()
            variables = [*form.units._fields, *(integral.name for integral in (*form.integrals, *turning))]
            faults += _twice(f"{where}, form `{form.name}`: variable", variables)
        events = [event.name for event in phase.events]
        faults += _twice(f"{where}: event", events)
        faults += rivals(phase.events)
        faults += _twice(f"{where}: quantity", [quantity.name for quantity in phase.quantities])
        faults += _twice(f"{where}: exit by the event", [way.event for way in phase.exits])
        for way in phase.exits:
            if way.event not in events:
                faults.append(f"{where} must end in an event of its own, but has an exit by {way.event!r}.")
            if not way.to:
                faults.append(f"{where} must lead somewhere by {way.event!r}, but leads nowhere.")
            faults += [
                f"{where} must lead to phases of the system, but leads to {to!r}."
                for to in way.to
                if to not in system.phases
            ]
    quantities = {quantity.name for quantity in system.quantities}
    faults += [
        f"`{system.name}` must have the quantity {n!r}, but has not." for n in system.integrals if n not in quantities
    ]
    return faults


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
            f"`angles` of `{system.name}` must be a NamedTuple filled with units, but is {system.angles!r:.60}."
        )
    for name in ("parameters", "initial"):
        rules = getattr(system, name)
        if not isinstance(rules, Mapping) or not all(isinstance(rule, Parameter) for rule in rules.values()):
            faults.append(f"`{name}` of `{system.name}` must be Parameter records by name, but is {rules!r:.60}.")
    return faults


def rivals(events: Sequence[Event]) -> list[str]:
    """Sentences on events of one phase that a run can follow only one of, and on one that can never hold."""
    faults = []
    for field, what in ONCE.items():
        names = [f"`{event.name}`" for event in events if getattr(event, field)]
        if len(names) > 1:
            faults.append(f"`{field}` ({what}) must be that of one event, but is given in {' and '.join(names)}.")
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
