"""Formulas of a ball on a plane at rest as formulas of any body in any surroundings.

The body that they take depends on the state: an outline touches with a ball that changes with the
axis; a plane that vibrates changes gravity, and a turntable turns about a place. Equations of
motion cannot read integrals: their state ends with copies of those that determine the body.

Forms, phases and jumps of a ball go in; `opening`, `surrounded` and `systems.revolution` take what
comes out. `around` names groups of surroundings, such as "vibration" and "turntable".

Symbols
    q         the state of a form: a record, in SI
    carried   its integrals
    x         the common state of all phases, a `body.Moving`
    e, s, z   in (e, s, z, b): record of angles and their rates, sin(theta), cos(theta)
    s         in (s, b): the record of scalars of a state, see `body.Kinematics`
    b         the body, a `body.Touch`, in SI
    around    in arguments: names of groups of surroundings; b.around: the record of their numbers
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..form import Form, Integral, Phase
from ..units import ONE
from .body import filled, touching, touching_ball
from .surroundings import COPY, at_present, joined_values


def clock(rate_of: Callable, name: str, first: int) -> Integral:
    """Return the integral for the cosine or the sine of the phase of the vibration, no unit.

    `name` is "clock_cos" or "clock_sin"; its rate is rate_of(q, 2 pi f) [1/s], its value at the
    start `first`. The state q has copies of both, `at_clock_cos` and `at_clock_sin`. The phase
    itself would grow, and with it the step, which heyoka chooses by the largest variable: energies
    then drift by 1e-10 in ten seconds.
    """
    rate = lambda q, carried, b: rate_of(q, b.around.shake.rate)  # noqa: E731
    return Integral(name, ONE, "phase of the vibration", rate, lambda data, s, z: first + 0 * z)


VIBRATION_PHASE = (
    clock(lambda q, rate: -(rate * q.at_clock_sin), "clock_cos", 1),
    clock(lambda q, rate: rate * q.at_clock_cos, "clock_sin", 0),
)
"""`surroundings.at_present` reads both by name."""


def added_integrals(around: tuple[str, ...]) -> tuple[Integral, ...]:
    """Return the integrals that surroundings of these groups add: the phase of a vibration."""
    return VIBRATION_PHASE if "vibration" in around else ()


def present(known: Any, b: Any) -> Any:
    """Return the body as it is now: its touching ball, and gravity and place of a moving plane.

    `known` is a common state, or the state of a form.
    """
    return touching(known, at_present(b, getattr(known, "carried", known)))


def by_states(function: Callable) -> Callable:
    """Return function(known, ..., b) with the last argument b replaced by `present(known, b)`."""
    return lambda known, *more: function(known, *more[:-1], present(known, more[-1]))


def in_scalars(record: Any) -> Any:
    """Return a record whose formula(s, b) gets the body with its touching ball instead of b.

    `record` is an Event, a Quantity or a Domain, s the record of scalars of the state.
    """
    return replace(record, formula=lambda s, b: record.formula(s, touching(s, b)))


def form_by_states(form: Form, around: tuple[str, ...] = ()) -> Form:
    """Return a form whose functions get the body in its state, in surroundings of these groups.

    Its state gets further variables at the end, named `COPY` + the name of an integral, because
    rates cannot read integrals: the rates of these integrals get () as `carried`. `joined_values`
    returns the copies in this order.
    """
    clock = added_integrals(around)
    place = [one for one in form.integrals if one.name in ("x", "y") and "turntable" in around]
    copied = (*clock, *place)
    units = filled(**form.units._asdict(), **{COPY + one.name: one.unit for one in copied})

    def rates(q: Any, b: Any) -> Any:
        """Return d state/dt, that of the copies of integrals included."""
        moves = (one.rate(q, (), b) for one in copied)
        return type(units)(*form.rates(q, b), *moves)

    def of_angles(e: Any, s: Any, z: Any, b: Any) -> Any:
        """Return the state at angles, with the copies of integrals at their start."""
        starts = (one.start({}, s, z) if one.start else getattr(e, one.name) for one in copied)
        return type(units)(*form.of_angles(e, s, z, touching_ball(z, s * s, b)), *starts)

    return replace(
        form,
        units=units,
        rates=by_states(rates),
        scalars=by_states(form.scalars),
        of_angles=of_angles,
        to_angles=by_states(form.to_angles),
        integrals=tuple(
            replace(one, rate=by_states(one.rate)) for one in (*form.integrals, *clock)
        ),
        domains=tuple(map(in_scalars, form.domains)),
    )


def phase_by_states(phase: Phase, around: tuple[str, ...]) -> Phase:
    """Return a phase whose functions get the body in its state, as in `form_by_states`."""
    form = form_by_states(phase.form, around)

    def enter(x: Any, b: Any) -> Any:
        """Return the state of the phase that begins in the common state x."""
        copies = joined_values(form.units, x.carried)
        return type(form.units)(*phase.enter(x, present(x, b)), *copies)

    return replace(
        phase,
        forms=form,
        events=tuple(map(in_scalars, phase.events)),
        enter=enter,
        leave=by_states(phase.leave),
        reaction=by_states(phase.reaction),
    )


def jump_by_states(jump: Callable) -> Callable:
    """Return a jump(x, world) whose `world.body` are the balls as they are in the state x.

    They are taken once, before the jump: the axis does not turn during a jump, or only in a phase
    that the jump begins.
    """
    return lambda x, world: jump(x, world._replace(body=tuple(present(x, b) for b in world.body)))
