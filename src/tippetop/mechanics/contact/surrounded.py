"""Systems in surroundings: gliding ones lose their theory, rolling ones get further integrals."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

from ..form import Form
from ..operand import dot
from ..system import Outlook, System
from ..units import JELLETT, JOULE
from . import rolling
from .body import FRAME, arm, filled
from .contact_phases import without_slip
from .framed import form_of
from .gliding import angles_by, axis, turning
from .integrals import integral
from .outline import Ball
from .outlined import outlined_form
from .response import air, angular_velocity
from .surroundings import rules_of, surrounded_body, surrounded_units, taken


NO_OUTLOOK = "theory is that of a level plane and still air: it predicts nothing here"


LOSSES = {
    "work": "energy taken by friction, the air and gravity along the plane since the start",
    "jellett_lost": "Jellett's integral taken by torques of contact and air since the start",
}
"""Words for the integrals that surroundings change."""


def disturbed(b: Any, start: Any, rules: Any = None) -> Outlook:
    """Predict nothing of a body in surroundings."""
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


Scalars = type(filled(**dict.fromkeys((*rolling.FIELDS, "force"))))
"""Those of a body in pure rolling, and the normal force."""


def scalars(q: Any, b: Any) -> Any:
    """Return the scalars of a body in pure rolling."""
    return Scalars(*rolling.vector_scalars(q, b), rolling.force(q, b).z)


def power(q: Any, carried: Any, b: Any) -> Any:
    """Return the power that is taken from a body in pure rolling."""
    return taken(angular_velocity(turning(q), b), rolling.velocity(q, carried, b), b)


def jellett_loss(q: Any, carried: Any, b: Any) -> Any:
    """Return the rate at which a body in pure rolling loses Jellett's integral."""
    return dot(air(turning(q), b), arm(axis(q), b))


def rolling_form(angles: Any) -> Form:
    """Return the form of a body with an axis in pure rolling, in surroundings."""
    losses = integral("work", power), integral("jellett_lost", jellett_loss)
    return replace(
        rolling.VECTOR,
        scalars=scalars,
        to_angles=angles_by(angles, scalars),
        integrals=(*rolling.VECTOR.integrals, *losses),
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

    def changed(records: Any) -> Any:
        return tuple(
            replace(one, formula=NEEDED[one.name]) if one.name in NEEDED else one for one in records
        )

    (phase,) = system.phases.values()
    form = replace(known, domains=form.domains)
    phase = replace(phase, forms={"vector": form})
    phase = replace(phase, quantities=changed(phase.quantities), events=changed(phase.events))
    start = system.start

    def started(data: dict[str, Any], s: Any, z: Any, b: Any) -> Any:
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
