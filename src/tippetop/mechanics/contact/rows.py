"""The rows of a run in any phase, and the columns that are functions of their `Scalars`.

`row` converts the state of a phase to a `Row`, which is the same record in all phases: the common
state with the force of the plane, the ball in contact (or last in contact) and the phase. Columns,
and events of the user, are functions of the `Scalars` of a row, so that a column has one formula.
ROW, DISC_ROW and PLANAR_ROW are the forms of rows; `opening` chooses one.

Symbols
    q         a `Row`, or the state of a phase in `row`; carried: the record of integrals
    b         the body, a `body.Touch` seen from its first ball, the sphere
    x         the common state, a `body.Moving`: axis u, momentum L, velocity, height
    s         in (s, b): record of `Scalars`; in (e, s, z, b): sin(theta), and z: cos(theta)
    e         record of angles, ANGLES
    v, v_A    velocity of the contact point, or of the lowest point in flight
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..form import Form, Integral, Phase, Quantity
from ..operand import Vector, dot, sqrt
from ..units import (
    ANGULAR_MOMENTUM,
    JELLETT,
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    ONE,
    WATT,
)
from . import body as contact
from . import gliding, rolling
from .body import (
    BALLS,
    FRAME,
    VELOCITY,
    Moving,
    filled,
    kinematics,
    of_azimuth,
    slip_scalars,
    state,
)
from .body_axes import by_angles, carried_along
from .contact_phases import PHASES, moving
from .frame import Asymmetric
from .gliding import EULER_UNITS, angles_by, axis_and_momentum, axis_rate
from .integrals import integral
from .rolling import spin


NUMBERS = {
    "height": METRE,  # of the centre of mass
    "Fx": NEWTON,
    "Fy": NEWTON,
    "force": NEWTON,  # normal
    "radius": METRE,  # of the ball in contact, or last in contact
    "offset": METRE,  # c of that ball
    "stem_gap": METRE,  # of the stem's ball; 0 without a stem
    "phase": ONE,  # number in PHASES
    "ball": ONE,  # number in BALLS
    "jellett_taken": JELLETT,  # the reference: see `exits.first_touch`
    "drilled": WATT,  # power that torques of the contact take
}
"""Further numbers of a row. `height` comes first, as in a `Moving`: see `filled_row`."""

ROW_UNITS = state(**VELOCITY, **NUMBERS)
Row = type(ROW_UNITS)
"""A common state as one record of numbers, with the other numbers of a row."""

FRAME_UNITS = state(FRAME, **VELOCITY, **NUMBERS)
"""Of a body without an axis of symmetry; the numbers of a ball are 0."""


def filled_row(units: Any, x: Moving, **numbers: Any) -> Any:
    """Return a common state as a row with these units; numbers that are not given are 0.

    `units` are ROW_UNITS or FRAME_UNITS, and are filled by position.
    """
    numbers["height"] = x.height
    values = (numbers.get(name, 0 * x.height) for name in NUMBERS)
    return type(units)(*x.u, *x.L, *x.velocity, *values)


def row(phase: Phase, q: Any, carried: Any, b: Any) -> tuple[Any, Any]:
    """Return a state of a phase as a `Row`, the record that all phases share, and the body.

    It is `System.read`: the engine computes columns and user-defined events from the result.

    Parameters
    ----------
    phase
        The phase.
    q, carried
        Its state and its integrals: numbers, arrays or expressions.
    b
        The body seen from the ball of the phase; the returned one is seen from the first ball.
    """
    x = phase.leave(q, b)
    by = phase.reaction(q, b)
    numbers = dict(zip(("Fx", "Fy", "force"), by.force, strict=True)) | {
        "drilled": by.drilled,
        "phase": PHASES.index(phase.label),
        "ball": phase.ball,
    }
    if isinstance(b, Asymmetric):
        return filled_row(FRAME_UNITS, x, **numbers), b
    b = contact.by_axis(x.u, b)
    reference = getattr(carried, "jellett_reference", 0 * x.height)
    if phase.label == "both" and not hasattr(carried, "jellett_lost"):  # nothing is conserved
        reference = contact.jellett_of(x.L.z, dot(x.L, x.u), b)
    gap = contact.gap(x, b)
    first = b
    if phase.ball == 0:
        gap = gap + b.clearance + b.lever * x.u.z  # `contact_phases.other_gap`, in flight too
    else:
        first = contact.seen_from_other(b)
    numbers |= {"radius": b.R, "offset": b.c, "stem_gap": gap, "jellett_taken": reference}
    return filled_row(ROW_UNITS, x, **numbers), first


# --- scalars ------------------------------------------------------------------------------------

FIELDS = (
    *contact.Kinematics._fields,
    "v_u",  # v_A.3hat of the horizontal part
    "v_n",  # (3hat x v_A).zhat
    "v2",  # |v_A|^2 of the horizontal part
    "rise",  # v_A.zhat
    "speed2",  # |s'|^2 of the centre of mass, all three components
    "power",  # that friction takes
    "gap",  # of the ball that is in contact, or was last
    *NUMBERS,
)
Scalars = type(filled(**dict.fromkeys(FIELDS)))
"""The scalars of a gliding body, with the other numbers of a row."""


def ball_of(q, b):
    """Return the body as a `Touch` of the ball that touches, by R and c of a row."""
    return contact.as_ball(b)._replace(R=q.radius, c=q.offset)


def lowest_velocity(q, b):
    """Return v_A of a row, (3,) [m/s]: the velocity of the lowest point."""
    return contact.contact_velocity(moving(q), b if "ix" in q._fields else ball_of(q, b))


def row_scalars(q, b):
    """Return the `Scalars` of a row q, filled by position; numbers of a ball are 0 without one.

    The gap of a ball is `body.gap` by the numbers of the row, and power as in
    `contact_phases.on_ball`, without surroundings; a change of one is a change of both.
    """
    x = moving(q)
    v = lowest_velocity(q, b)
    moves = kinematics(x, contact.axis_rate(x, b), b)
    power = q.drilled - (q.Fx * v.x + q.Fy * v.y)
    gap = contact.gap(x, b) if "ix" in q._fields else q.height - q.radius + q.offset * q.uz
    numbers = (getattr(q, name) for name in NUMBERS)
    speed2 = dot(x.velocity, x.velocity)
    return Scalars(*moves, *slip_scalars(x.u, v), v.z, speed2, power, gap, *numbers)


# --- angles -------------------------------------------------------------------------------------


LOWEST = {"nu_z": METRE_PER_SECOND, "gap": METRE}
ANGLES = filled(**(EULER_UNITS._asdict() | LOWEST | gliding.ANGLES._asdict()))
"""Public variables: those of a gliding body, and velocity and height of the lowest point."""

DISC_ANGLES = filled(**ANGLES._asdict(), jellett_lost=JELLETT)
ACROSS = ("phi_dot", "omega3", "nu_y", "phi", "y")
PLANAR_ANGLES = filled(**{n: unit for n, unit in ANGLES._asdict().items() if n not in ACROSS})
"""Of a motion in a plane, where theta is not wrapped."""


def row_of_angles(e, s, z, b):
    """Return the row of angles e; the force of the plane in it is zero, not yet known.

    e may lack fields of ANGLES, as PLANAR_ANGLES do: they are zero. s, z are sin(theta),
    cos(theta), exact at the poles. `framed.start` has the same velocity and height.
    """
    none = 0 * z
    e = type(ANGLES)(*(getattr(e, name, none) for name in ANGLES._fields))
    b = contact.touching_ball(z, s * s, b)
    x = axis_and_momentum(e, s, z, b.I1, b.I3)
    v = contact.arm_velocity(x, b)
    along_x, along_y = of_azimuth(e.nu_x, e.nu_y, e.phi)
    velocity = Vector(along_x - v.x, along_y - v.y, e.nu_z - v.z)
    return filled_row(
        ROW_UNITS,
        Moving(x.u, x.L, velocity, e.gap + b.R - b.c * z),
        radius=b.R + none,
        offset=b.c + none,
        jellett_taken=contact.jellett_of(x.L.z, b.I3 * e.omega3, b),
    )


def planar_angles_of_row(q, carried, b):
    """Return the record PLANAR_ANGLES of a row of a motion in a plane.

    `carried` begins with the integrals that PLANAR_ROW names, in this order.
    """
    v = lowest_velocity(q, b)
    c = planar_scalars(q, b)
    theta, *others = carried[:4]  # others: x, work, impulse
    return type(PLANAR_ANGLES)(theta, c.theta_dot, v.x, c.rise, c.gap, *others)


def planar_theta_dot(q, b):
    """Return theta' = L_y/I1 [rad/s] of an axis in the x-z plane."""
    return q.Ly / b.I1


PlanarScalars = type(filled(**dict.fromkeys((*FIELDS, "theta_dot"))))


def planar_scalars(q, b):
    """Return the scalars of a row of a motion in a plane."""
    return PlanarScalars(*row_scalars(q, b), planar_theta_dot(q, b))


# --- the forms of rows --------------------------------------------------------------------------


def row_integrals(*names: str) -> tuple[Integral, ...]:
    """Return integrals of these names without rates: those that rows have.

    A phase integrates some of them; the others keep their values in it. No phase integrates
    `jellett_reference`, which `exits.first_touch` sets.
    """
    return tuple(integral(name, None) for name in (*names, "jellett_reference"))


ROW = Form(
    "vector",
    ROW_UNITS,
    None,
    row_scalars,
    row_of_angles,
    angles_by(ANGLES, row_scalars),
    integrals=row_integrals("x", "y", "work", "impulse"),
    orientation=carried_along(axis_rate, spin),
)
DISC_ROW = replace(
    ROW,
    to_angles=angles_by(DISC_ANGLES, row_scalars),
    integrals=row_integrals("x", "y", "work", "impulse", "jellett_lost"),
)
PLANAR_ROW = replace(
    ROW,
    name="angle",
    scalars=planar_scalars,
    to_angles=planar_angles_of_row,
    integrals=row_integrals("theta", "x", "work", "impulse"),
    orientation=by_angles(lambda q: (q.ux, q.uz)),
)


def form_of(phase: Phase, label: str, angles: Any, of_rows: Form) -> Form:
    """Return the form of a body that stays in a phase, for `framed` and rolling in surroundings.

    `label` is one of `PHASES`, which numbers the phase in rows, and `of_rows` the form of these.
    `angles` are the fields of the angles with their units: those that the scalars do not determine
    are integrals, and other integrals of the phase are left out.
    """
    phase = replace(phase, label=label)

    def scalars(q: Any, b: Any) -> Any:
        """Return the scalars of a state q of the phase, those of its row."""
        (alone,) = contact.seen_from_balls(b, ())  # no stem, as `row` reads `clearance`
        return of_rows.scalars(row(phase, q, (), alone)[0], b)

    def of_angles(e: Any, s: Any, z: Any, b: Any) -> Any:
        """Return the state of the phase at angles."""
        return phase.enter(moving(of_rows.of_angles(e, s, z, b)), b)

    return replace(
        phase.form,
        scalars=scalars,
        of_angles=of_angles,
        to_angles=angles_by(angles, scalars),
        integrals=tuple(one for one in phase.form.integrals if one.name in angles._fields),
    )


# --- columns ------------------------------------------------------------------------------------


def of_ball(function: Callable) -> Callable:
    """Return a formula(s, b) of a gliding body as one for rows: b becomes the ball in contact."""
    return lambda s, b: function(s, ball_of(s, b))


def energy(s, b):
    """Return the energy E = m |s'|^2/2 + omega.L/2 + m g s_z [J]; E' = F.v_A.

    It is `body.energy` of a row, whose speed2 has the vertical velocity too.
    """
    return b.m * s.speed2 / 2 + contact.rotation_energy(s, b) + b.m * (b.g * s.height)


ENERGY, MODIFIED_ENERGY, NORMAL_FORCE, FRICTION_POWER = map(
    lambda one, formula: replace(one, formula=formula),
    gliding.QUANTITIES,
    (energy, of_ball(contact.modified_energy), lambda s, b: s.force, lambda s, b: s.power),
)


HORIZONTAL = replace(rolling.HORIZONTAL, formula=lambda s, b: sqrt(s.Fx * s.Fx + s.Fy * s.Fy))
FRICTION_NEEDED = replace(
    rolling.FRICTION_NEEDED, formula=lambda s, b: HORIZONTAL.formula(s, b) / s.force
)
LIFTOFF = replace(gliding.LIFTOFF, formula=NORMAL_FORCE.formula)


def columns(jellett: bool, routh: Callable | None, stem: bool) -> tuple[Quantity, ...]:
    """Return the columns of rows.

    `jellett`: whether Jellett's integral is conserved on a ball; `routh`: Routh's function of a
    gliding body, if its system has one.
    """
    quantities = [ENERGY, MODIFIED_ENERGY, NORMAL_FORCE, FRICTION_POWER]
    if routh is not None:
        text = "Routh's function of the ball in contact"
        quantities.insert(0, Quantity("routh", "D", ANGULAR_MOMENTUM, text, of_ball(routh)))
    if stem:
        text = "height of the stem's ball"
        gap = Quantity("gap_stem", "gap of the stem", METRE, text, lambda s, b: s.stem_gap)
        quantities.append(gap)
    return (*(JELLETT_COLUMNS if jellett else ()), *quantities, *PLACE_COLUMNS)


JELLETT_COLUMNS = (
    Quantity(
        "jellett",
        "lambda",
        JELLETT,
        "Jellett's integral of the ball in contact",
        of_ball(contact.jellett),
    ),
    Quantity(
        "jellett_taken",
        "",
        JELLETT,
        "Jellett's integral when its ball was taken",
        lambda s, b: s.jellett_taken,
        is_column=False,
    ),
)
"""`engine.invariants` measures the drift of the first from the second, by their names."""

PLACE_COLUMNS = (
    Quantity("z", "s_z", METRE, "height of the centre of mass", lambda s, b: s.height),
    Quantity("phase", "phase", ONE, "phase of the contact", lambda s, b: s.phase, PHASES),
    Quantity(
        "ball", "ball", ONE, "what touches the plane, or did last", lambda s, b: s.ball, BALLS
    ),
)
