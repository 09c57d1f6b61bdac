"""Formulas of a ball as formulas of a body with an outline, whose ball changes with its axis."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from ..form import Domain, Form, Phase
from ..operand import cos, sin
from .body import Moving, Touch, axis, by_axis, by_scalars, touching_ball


def by_state(q: Any, b: Touch) -> Touch:
    """Return the touching ball of a body in a state, by its axis or by theta."""
    if hasattr(q, "uz"):
        return by_axis(axis(q), b)
    s = sin(q.theta)
    return touching_ball(cos(q.theta), s * s, b)


def in_states(function: Callable) -> Callable:
    """Return a function (q, .., b) of states for bodies with an outline."""
    return lambda q, *more: function(q, *more[:-1], by_state(q, more[-1]))


def in_scalars(record: Any) -> Any:
    """Return a record with a formula(s, b), such as an event, for bodies with an outline."""
    formula = record.formula
    changed = record._replace if isinstance(record, Domain) else partial(replace, record)
    return changed(formula=lambda s, b: formula(s, by_scalars(s, b)))


def outlined_form(form: Form) -> Form:
    """Return a form for bodies with an outline."""
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
    """Return a phase of the contact for bodies with an outline."""
    return replace(
        phase,
        forms=outlined_form(phase.form),
        events=tuple(map(in_scalars, phase.events)),
        enter=lambda x, b: phase.enter(x, by_axis(x.u, b)),
        leave=in_states(phase.leave),
        reaction=in_states(phase.reaction),
    )


def outlined_jump(jump: Callable) -> Callable:
    """Return a jump for bodies with an outline; the axis stays in it, or moves within a phase."""

    def outlined(x: Moving, world: Any) -> Any:
        return jump(x, world._replace(body=tuple(by_axis(x.u, b) for b in world.body)))

    return outlined
