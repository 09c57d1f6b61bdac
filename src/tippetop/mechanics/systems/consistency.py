"""Checks of a user-defined system: its records fit together, and its functions work.

`systems.add` calls `check` when a system is registered, and `library.scenarios` for each run that
is given a `System`. A `System` goes in; InputError has a sentence for each fault.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import InputError
from .. import friction
from ..event import Event
from ..form import CLOCK, STALL, Form, Phase
from ..number import Number
from ..operand import leaves
from ..system import System
from ..units import Unit


KEEPS = 1e-9
"""Relative error with which a phase must keep the common state."""

ONCE = {
    "sense": "turns of theta",
    "lasting": "what a motion settles into",
    "extremes": "the quantity whose least and greatest values are reported",
}
"""Fields that at most one event of a phase may have, and what that event then describes."""


def check(system: System) -> None:
    """Raise InputError for a system whose records contradict one another, or that cannot be run.

    There are three stages: contradictions, unmet requirements, and functions that fail. The error
    has the faults of the first stage with any, since later stages rely on the earlier ones; of
    functions it has the first fault only.
    """
    try:
        if faults := inconsistencies(system) or unmet_requirements(system):
            raise InputError(faults)
        check_answers(system)
    except (AttributeError, TypeError) as error:
        raise InputError(
            f"the records of `{system.name}` must be of the kinds that `System` has, but: {error}."
        ) from error


def named(faults: dict[str, Iterable[str]]) -> list[str]:
    """Return a sentence for each requirement that is not met: the requirement, then the names.

    `faults` maps the beginning of a sentence ("... must ..., but has") to the names of the records
    that do not meet it; a requirement without names is met.
    """
    listed = {must: ", ".join(names) for must, names in faults.items()}
    return [f"{must} {names}." for must, names in listed.items() if names]


def inconsistencies(system: System) -> list[str]:
    """Return one message for each contradiction among the records of a system; calls no formula.

    The events of a phase are compared with those of all phases before it. Faults of Python, where a
    record is of the wrong kind, become an InputError in `check`.
    """
    faults: list[str] = []
    directions: dict[str, int] = {}
    integrals = {integral.name for integral in system.phase.form.integrals}
    common = list(system.phase.form.units._asdict().items())
    for name, phase in system.phases.items():
        where = f"phase `{name}` of `{system.name}`"
        variables = list(phase.form.units._asdict().items())
        events = phase.events
        left = [way.event for way in phase.exits]
        words = [name, *(event.name for event in events)]
        logged = {*left, *(one.name for one in system.events)}
        detected = [CLOCK, STALL, *(event.name for event in events if event.formula)]
        names = [
            *(f"event `{event.name}`" for event in events),
            *(f"quantity `{quantity.name}`" for quantity in phase.quantities),
            *(f"exit by `{way.event}`" for way in phase.exits),
        ]
        faults += rivals(events) + named(
            {
                f"{where} must have each name once, but has twice":
                    [name for name, count in Counter(names).items() if count > 1],
                f"{where} must have names of one word, but has":
                    [repr(word) for word in words if str(word).split() != [word]],
                f"{where} must have quantities with other names than the variables, but has":
                    [one.name for one in phase.quantities if one.name in system.angles._fields],
                f"{where} must have events with a function as `formula` and a `direction` of -1, "
                "0 or 1, but has": [
                    event.name
                    for event in events
                    # `len`: no formula is no fault here; jumps may log the event
                    if event.direction not in (-1, 0, 1) or not callable(event.formula or len)
                ],
                f"{where} must have events with the directions of the phases before, but has": [
                    event.name
                    for event in events
                    if directions.setdefault(event.name, event.direction) != event.direction
                ],
                f"{where} must have events with a formula, as no jump logs them, but has":
                    [one.name for one in events if not (one.formula or system.is_hybrid)],
                f"{where} must end in each event that the system does not log, but has no exit by":
                    [one.name for one in events if one.name not in logged],
                f"{where} must end in its events that have a formula, but has exits by":
                    [name for name in left if name not in detected],
                f"{where} must end in events with a `direction`, but has exits by": [
                    event.name
                    for event in events
                    if not event.direction and event.name in left
                ],
                f"{where} must integrate what the first phase does, but integrates": [
                    one.name
                    for one in phase.form.integrals
                    if one.name not in integrals and not system.common
                ],
                f"{where} must lead to phases of the system by a tuple of names, but leads to": [
                    repr(way.to)
                    for way in phase.exits
                    if not (type(way.to) is tuple and way.to and {*way.to} <= {*system.phases})
                ],
                f"{where} must have exits with a function `jump`, but has exits by":
                    [way.event for way in phase.exits if not callable(way.jump)],
                f"{where} must have the variables and units of the first phase, or `enter` and "
                "`leave`, but has": [
                    f"{name} [{unit.symbol}]"
                    for name, unit in variables
                    # the same function only if both are the default, `form.unchanged`
                    if phase.enter is phase.leave and variables != common
                ],
            }
        )  # fmt: skip
    return faults


def unmet_requirements(system: System) -> list[str]:
    """Return what a run needs and a consistent system lacks: one message each; calls no formula.

    It relies on `inconsistencies`, which `check` calls first.
    """
    of = f"of `{system.name}`"
    phase = system.phase
    angles = system.angles._fields
    forms = phase.forms.values()
    quantities = [*phase.quantities, *system.on_request]
    works = any(integral.name == "work" for form in forms for integral in form.integrals)
    needed = ([] if system.is_hybrid else ["theta", "theta_dot"]) + ["work"] * works
    energy = ["energy"] if "work" in angles or not system.is_hybrid else []
    components = {name for names in system.vectors.values() for name in names}
    known = phase.forms["vector"].units._fields if "vector" in phase.forms else ()
    described = [*angles, *system.vectors]
    lifting = [event for event in phase.events if event.ends == "liftoff"]
    return named(
        {
            f"`parameters` {of} must have other names than the law of friction, but have":
                {"friction"} & {*system.parameters},
            f"`tables` {of} must have `phases` if they are given, but have":
                [] if "phases" in system.tables else system.tables,
            f"`tables` {of} must have a dict of columns for each name, but have none for":
                [name for name, kinds in system.tables.items() if not isinstance(kinds, Mapping)],
            f"`angles` {of} must have the fields `theta` and `theta_dot`, unless a phase has exits,"
            " and `work` where a form integrates it, but lacks":
                [name for name in needed if name not in angles],
            f"`long_names` {of} must describe each field of `angles` and `vectors`, but lacks":
                [name for name in described if name not in system.long_names],
            f"`quantities` {of} must have `energy`, which the energy balance reads, and each name "
            "in `integrals`, but lack":
                {*energy, *system.integrals} - {quantity.name for quantity in quantities},
            f"states {of} must be numbers, each filled with its Unit, and each component of a "
            "vector a field of its own, but these are not:": [
                f"`{name}` of the form `{form.name}` is {type(unit).__name__}"
                for form in forms
                for name, unit in form.units._asdict().items()
                if not isinstance(unit, Unit)
            ],
            f"`undefined_at_poles` {of} must name fields of `angles`, but has":
                [name for name in system.undefined_at_poles if name not in angles],
            f"`vectors` {of} must be variables of a form `vector`, but it lacks":
                sorted(components.difference(known)),
            f"`kept` {of} must have a Kept of the name `lifted_at` in events that end runs as "
            "`liftoff`, but has none in": [
                event.name
                for event in lifting
                if "lifted_at" not in [kept.name for kept in event.kept]
            ],
        }
    )  # fmt: skip


def rivals(events: Sequence[Event]) -> list[str]:
    """Return messages on events of one phase that exclude each other, or never happen.

    `library.extensions` calls it too, for the events of a system with those of a user.
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


# --- functions, called once with numbers that are allowed ---------------------------------------


def allowed(rule: Number) -> float:
    """Return one number that a parameter may be, SI: its default, or one within its bounds.

    A default that is a text, arithmetic of other numbers, is not used.
    """
    if isinstance(rule.default, float | int):
        return rule.default
    low = [bound for bound in (rule.above, rule.least) if bound is not None]
    high = [bound for bound in (rule.below, rule.most) if bound is not None]
    if low and high:
        middle = (max(low) + min(high)) / 2
        return (middle + min(high)) / 2 if rule.nonzero and not middle else middle
    return max(1.0, 2 * max(low)) if low else min(1.0, min(high) - 1.0) if high else 1.0


def answer(must: str, function: Callable, holds: Callable = lambda found: True) -> Any:
    """Return the result of a user's function if it passes a test. Raises InputError.

    Parameters
    ----------
    must
        The beginning of the message, such as "`scales` of `x` must give a mass and a length".
    function
        Called without arguments; any exception that it raises becomes the InputError.
    holds
        The test: holds(result) -> whether the result is right.
    """
    try:
        found = function()
        is_right = holds(found)
    except Exception as error:
        raise InputError(f"{must}, but fails: {type(error).__name__}: {error}.") from None
    if not is_right:
        raise InputError(f"{must}, but gives {found!r:.60}.")
    return found


def check_answers(system: System) -> None:
    """Raise InputError for a system whose functions fail or return wrong results.

    Each function is called once, with numbers that its rules allow. `answer` raises at the first
    one that fails; its results are used only as arguments of further functions, so most are
    dropped.
    """
    of = f"of `{system.name}`"
    names = ", ".join(system.parameters) or "none"
    law = next(iter(system.laws.values()), friction.LAWS["none"])
    numbers = {name: allowed(rule) for name, rule in system.parameters.items()}
    flags = {alternative.name for alternative in system.alternatives}
    data = {name: allowed(rule) for name, rule in system.initial.items() if name not in flags}
    theta = data.get("theta", 0.0)

    body = answer(
        f"`body` {of} must take its parameters ({names}) and give a NamedTuple",
        lambda: system.body_of(numbers, law._make(map(allowed, law.parameters.values()))),
        lambda body: hasattr(body, "_fields"),
    )
    answer(
        f"`body_units` {of} must give a NamedTuple of the type of `body`",
        lambda: system.body_units(law.units()),
        lambda units: type(units) is type(body),
    )
    answer(
        f"`scales` {of} must give a mass and a length, finite and greater than 0",
        lambda: system.scales(body),
        lambda scales: len(scales) == 2 and all(0 < float(one) < math.inf for one in scales),
    )
    answer(
        f"`checks` {of} must give a list of sentences",
        lambda: system.checks(numbers),
        lambda faults: isinstance(faults, list | tuple),
    )
    answer(
        f"`start` {of} must give a record as `angles` is",
        lambda: system.start(data, math.sin(theta), math.cos(theta), body),
        lambda angles: getattr(angles, "_fields", ()) == system.angles._fields,
    )
    common: Any = None
    for name, phase in system.phases.items():
        for form in phase.forms.values():
            answer(
                f"`rates` of the form `{form.name}` of phase `{name}` {of} must give its "
                f"{len(form.units)} rates as a {type(form.units).__name__}",
                lambda form=form, phase=phase: form.rates(sample(form), phase.parameters(body)),
                lambda rates, form=form: type(rates) is type(form.units),
            )
        common, _ = answer(
            f"`enter` and `leave` of phase `{name}` {of} must keep the common state",
            lambda phase=phase: common_states(phase, body),
            lambda found, common=common: (
                type(common or found[0]) is type(found[0])
                and all(
                    math.isclose(*pair, rel_tol=KEEPS)
                    for pair in zip(*map(leaves, found), strict=True)
                )
            ),
        )
        answer(
            f"`leave` of phase `{name}` {of} must take arrays, of rows",
            lambda phase=phase: phase.leave(sample(phase.form, np.ones(2)), phase.parameters(body)),
        )
    for form in system.forms.values() if system.undefined_at_poles else ():
        answer(
            f"`scalars` of the form `{form.name}` {of} must have `s2` and `axis_speed2`, which the "
            "angles of `undefined_at_poles` need",
            lambda form=form: form.scalars(sample(form), body),
            lambda scalars: hasattr(scalars, "s2") and hasattr(scalars, "axis_speed2"),
        )


def common_states(phase: Phase, body: Any) -> tuple[Any, Any]:
    """Return a common state x of a phase, and leave(enter(x)), which must be x.

    `body` is the body of the system, of which the phase takes its part.
    """
    b = phase.parameters(body)
    x = phase.leave(sample(phase.form), b)
    return x, phase.leave(phase.enter(x, b), b)


def sample(form: Form, factor: Any = 1.0) -> Any:
    """Return a state of a form in which no variable is 0: `factor` times 0.5, 0.516, 0.531, ...

    The numbers differ, so that exchanged variables are noticed, and no angle is at a pole
    (sin(theta) = 0). An array of ones as `factor` makes the variables arrays of its shape.
    """
    return type(form.units)(*(factor * (0.5 + k / 64) for k in range(len(form.units))))
