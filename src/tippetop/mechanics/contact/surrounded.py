"""Systems in surroundings: air, and a plane that is tilted, vibrates or turns.

A system goes in, and comes out with a body in surroundings, without the theory of a level plane at
rest, and in rolling with further integrals. Where the equations depend on an integral of the run
(time on a shaker, place on a turntable), the state ends with a copy of it: see `joined`.

Symbols
    around    names of the groups of surroundings, see `surroundings.GROUPS`
    q         the state of a form; carried: the record of integrals; e: record of angles
    b         the body; b.around: its record of surroundings
    x         the common state, a `body.Moving`
    s         in (s, b): record of scalars; in (e, s, z, b): sin(theta), and z: cos(theta)
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

from ..form import Form, Integral, Phase
from ..system import Outlook, System
from ..units import JELLETT, JOULE, ONE
from . import rolling
from .body import FRAME, axis_rate, filled, kinematics
from .contact_phases import without_slip
from .framed import form_of
from .gliding import angles_by
from .outline import Ball
from .outlined import outlined_form
from .surroundings import (
    COPY,
    at_present,
    joined_names,
    joined_values,
    rules_of,
    surrounded_body,
    surrounded_units,
)


NO_OUTLOOK = "theory is that of a level plane at rest in still air: it predicts nothing here"


LOSSES = {
    "work": "energy taken by friction and surroundings since the start",
    "jellett_lost": "Jellett's integral taken by torques since the start",
}
"""Words for the integrals that surroundings change."""


def disturbed(b: Any, start: Any, rules: Any = None) -> Outlook:
    """Return no predictions: the theory of the package does not apply in surroundings."""
    return Outlook(NO_OUTLOOK)


def in_surroundings(system: System, around: tuple[str, ...]) -> System:
    """Return a system whose body is in surroundings of these tables, without its theory."""
    return replace(
        system,
        body=surrounded_body(system.body),
        body_units=surrounded_units(system.body_units, around),
        surroundings=rules_of(around),
        landscape=None,
        potential=None,
        momenta=(),
        outlook=disturbed,
        borders=None,
        motion=None,
    )


def rolls(system: System) -> bool:
    """Return whether a system is that of a body in space in pure rolling."""
    return [*system.phases] == ["roll"] and bool(system.vectors)


def clock(rate_of: Callable, name: str, first: int) -> Integral:
    """Return the integral for the cosine or the sine of the phase of the vibration.

    Its rate is rate_of(integrals, 2 pi f), its value at the start `first`.
    """
    rate = lambda q, carried, b: rate_of(carried, b.around.shake.rate)  # noqa: E731
    return Integral(name, ONE, "phase of the vibration", rate, lambda data, s, z: first + 0 * z)


CLOCK = (
    clock(lambda carried, rate: -(rate * carried.clock_sin), "clock_cos", 1),
    clock(lambda carried, rate: rate * carried.clock_cos, "clock_sin", 0),
)


def added_integrals(around: tuple[str, ...]) -> tuple[Integral, ...]:
    """Return the integrals that surroundings of these groups add: the phase of a vibration."""
    return CLOCK if "vibration" in around else ()


def copied_integrals(q: Any, names: tuple[str, ...]) -> Any:
    """Return the copies of integrals in a state, of which they are the last variables, by name."""
    return SimpleNamespace(**dict(zip(names, q[-len(names) :], strict=True)))


def in_copies(units: Any, names: tuple[str, ...]) -> Callable:
    """Return an adapter of functions(q, .., b) to states that end with copies of integrals.

    An adapted function gets the state without the copies (it has these units), and the body with
    gravity and place as the copies determine them.
    """

    def seen(function: Callable) -> Callable:
        """Return the adapted function."""

        def of_copies(q: Any, *more: Any) -> Any:
            """Call the function without copies, and with the body at their time and place."""
            b = at_present(more[-1], copied_integrals(q, names))
            return function(type(units)(*q[: len(units)]), *more[:-1], b)

        return of_copies

    return seen


def joined(form: Form, around: tuple[str, ...]) -> Form:
    """Return a form whose equations depend on integrals of the run, such as the time on a shaker.

    Equations of motion cannot read integrals: the state of the form ends with copies of them.
    """
    names = joined_names(around)
    every = (*form.integrals, *added_integrals(around))
    integrals = {one.name: one for one in every}
    copied = [integrals[name] for name in names]
    units = filled(**form.units._asdict(), **{COPY + one.name: one.unit for one in copied})
    seen = in_copies(form.units, names)

    def rates(q: Any, b: Any) -> Any:
        """Return the rates of the state and of the copies."""
        moves = [seen(one.rate)(q, copied_integrals(q, names), b) for one in copied]
        return type(units)(*seen(form.rates)(q, b), *moves)

    def of_angles(e: Any, s: Any, z: Any, b: Any) -> Any:
        """Return the state of angles e, with the start of the copies."""
        starts = [one.start({}, s, z) if one.start else getattr(e, one.name) for one in copied]
        return type(units)(*form.of_angles(e, s, z, b), *starts)

    return replace(
        form,
        units=units,
        rates=rates,
        scalars=seen(form.scalars),
        of_angles=of_angles,
        to_angles=seen(form.to_angles),
        integrals=tuple(replace(one, rate=seen(one.rate)) for one in every),
    )


def joined_phase(phase: Phase, around: tuple[str, ...]) -> Phase:
    """Return a phase in the form `joined`, which enters and leaves it with copies of integrals."""
    form = joined(phase.form, around)
    seen = in_copies(phase.form.units, joined_names(around))

    def enter(x: Any, b: Any) -> Any:
        """Return the state of the common state x, with copies of its integrals."""
        q = phase.enter(x, at_present(b, x.carried))
        return type(form.units)(*q, *joined_values(form.units, x.carried))

    leave = seen(phase.leave)
    return replace(phase, forms=form, enter=enter, leave=leave, reaction=seen(phase.reaction))


def joined_jump(jump: Callable) -> Callable:
    """Return a jump that is made with gravity and place of the body at its time."""

    def at_once(x: Any, world: Any) -> Any:
        """Make the jump with the body at the time and place of the state."""
        return jump(x, world._replace(body=tuple(at_present(b, x.carried) for b in world.body)))

    return at_once


Scalars = type(filled(**dict.fromkeys((*rolling.FIELDS, "force"))))
"""Those of a body in pure rolling, and the normal force."""


def rolling_form(angles: Any) -> Form:
    """Return the form of a body with an axis in pure rolling, in surroundings."""
    phase = without_slip(())

    def scalars(q: Any, b: Any) -> Any:
        """Return the `Scalars` of a state q."""
        x = phase.leave(q, b)
        F = phase.reaction(q, b).force
        v = x.velocity
        seen = kinematics(x, axis_rate(x, b), b)
        return Scalars(*seen, v.x**2 + v.y**2, F.x**2 + F.y**2, F.z)

    return replace(
        phase.form,
        scalars=scalars,
        of_angles=rolling.vector_of_angles,
        to_angles=angles_by(angles, scalars),
    )


NEEDED: dict[str, Callable] = {
    "normal_force": lambda s, b: s.force,
    "friction_needed": lambda s, b: rolling.horizontal_force(s, b) / s.force,
    "liftoff": lambda s, b: s.force,
}
"""Formulas that differ from those on a level plane in still air, by name."""


@cache
def surrounded_rolling(system: System, around: tuple[str, ...]) -> System:
    """Return a system in pure rolling, in surroundings of these tables."""
    form = system.forms["vector"]
    outline = getattr(system.body_units(()), "outline", Ball())
    angles = filled(**system.angles._asdict(), work=JOULE)
    if "ix" in form.units._fields:
        known = form_of(without_slip((), lies=FRAME), "roll", angles)
    else:
        angles = filled(**angles._asdict(), jellett_lost=JELLETT)
        known = rolling_form(angles)
        if not isinstance(outline, Ball):
            known = outlined_form(known)
    if joined_names(around):
        known = joined(known, around)

    def changed(records: Any) -> Any:
        """Return records of quantities or events with the formulas NEEDED in surroundings."""
        return tuple(
            replace(one, formula=NEEDED[one.name]) if one.name in NEEDED else one for one in records
        )

    (phase,) = system.phases.values()
    form = replace(known, domains=form.domains)
    phase = replace(phase, forms={"vector": form})
    phase = replace(phase, quantities=changed(phase.quantities), events=changed(phase.events))
    start = system.start

    def started(data: dict[str, Any], s: Any, z: Any, b: Any) -> Any:
        """Return the record of angles of a start, whose further integrals are zero."""
        e: Any = start(data, s, z, b)
        return angles._make((*e, *(0 * z,) * (len(angles) - len(e)))) if hasattr(e, "phi") else e

    return replace(
        in_surroundings(system, around),
        phases={"roll": phase},
        angles=angles,
        start=started,
        long_names=system.long_names | LOSSES,
        integrals=tuple(name for name in system.integrals if name == "jellett"),
    )
