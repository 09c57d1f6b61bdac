"""Formulas of a ball as formulas of a body with an outline, whose ball changes with its axis.

Forms, phases and jumps of a `Touch` go in; out come the same records, whose functions first replace
b by the ball that touches at the present inclination (`body.touching_ball`). So no equation of
motion is written for outlines. `opening` and `systems.revolution` use it.

Symbols
    q, s      the state of a form, its record of scalars; but s, z in (e, s, z, b): sin(theta), cos
    b         the body, a `body.Bent`
    x, world  the arguments of a jump: the common state, and `world.body` with the balls
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from ..form import Domain, Form, Phase
from ..operand import cos, sin
from .body import Moving, Touch, axis, by_axis, by_scalars, touching_ball


def by_state(q: Any, b: Touch) -> Touch:
    """Return the touching ball of a body in a state q, which has 3hat or theta."""
    if hasattr(q, "uz"):
        return by_axis(axis(q), b)
    s = sin(q.theta)
    return touching_ball(cos(q.theta), s * s, b)


def in_states(function: Callable) -> Callable:
    """Return function(q, ..., b) of a ball as a function of bodies with an outline."""
    return lambda q, *more: function(q, *more[:-1], by_state(q, more[-1]))


def in_scalars(record: Any) -> Any:
    """Return an event, quantity or domain with its formula(s, b) for bodies with an outline."""
    formula = record.formula
    changed = record._replace if isinstance(record, Domain) else partial(replace, record)
    return changed(formula=lambda s, b: formula(s, by_scalars(s, b)))


def outlined_form(form: Form) -> Form:
    """Return a form of a ball as one of bodies with an outline."""
    return replace(
        form,
        rates=in_states(form.rates),
        scalars=in_states(form.scalars),
        of_angles=lambda e, s, z, b: form.of_angles(e, s, z, touching_ball(z, s * s, b)),
        to_angles=in_states(form.to_angles),
        integrals=tuple(replace(one, rate=in_states(one.rate)) for one in form.integrals),
        domains=tuple(map(in_scalars, form.domains)),
    )


def outlined_phase(phase: Phase) -> Phase:
    """Return a phase of a ball as one of bodies with an outline."""
    return replace(
        phase,
        forms=outlined_form(phase.form),
        events=tuple(map(in_scalars, phase.events)),
        enter=lambda x, b: phase.enter(x, by_axis(x.u, b)),
        leave=in_states(phase.leave),
        reaction=in_states(phase.reaction),
    )


def outlined_jump(jump: Callable) -> Callable:
    """Return a jump of balls as one of bodies with an outline.

    The touching ball is fixed for the jump: the axis stays in it, or moves within a phase.
    """

    def outlined(x: Moving, world: Any) -> Any:
        """Make the jump with the touching balls of the present axis."""
        return jump(x, world._replace(body=tuple(by_axis(x.u, b) for b in world.body)))

    return outlined
