"""Bodies without an axis of symmetry: starts, rows, forms, columns and events.

In go the user's numbers and states of phases; out come the common state at the start, rows, and the
scalars of columns and events. Phases and jumps are those of other bodies (`contact_phases`,
`exits`); a state has axes 1 and 3 of the body, so that their orientation needs no integral.
`systems.ellipsoid` makes its systems of these constants.

Symbols
    b         the body, a `frame.Asymmetric`; b.outline: its shape, with half axes a, b, c
    u         how it lies, a `frame.Frame`: axes 3 and 1; up: zhat along its axes
    x         the common state, a `body.Moving`: u, momentum L, velocity, height
    q         the state of a phase, or a row; carried: the record of integrals; e: record of angles
    s         in (s, b): record of `Scalars`; in (e, s, z, b): sin(theta), and z: cos(theta)
    omega     angular velocity; spin: its vertical part; v: velocity of the contact point
"""

from collections import namedtuple
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from ..event import Event, Kept
from ..form import Quantity
from ..friction import Frictionless
from ..number import Alternative, Number
from ..operand import Vector, atan2, cos, cross, dot, minus, plus, sin, sqrt, times
from ..system import Opening
from ..units import RADIAN, RADIAN_PER_SECOND
from . import body as contact
from . import frame, gliding, rolling, rows
from .body import FRAME, Moving, Turning, filled
from .body_axes import PSI, axes_of_angles
from .contact_phases import OF_FRAME, moving, slip_under, without_slip
from .frame import Asymmetric, Frame
from .response import bias_vector


# --- the start ----------------------------------------------------------------------------------


LYING = ("tilt", "roll", "heading")
INITIAL = gliding.INITIAL | {
    "heading": Number(RADIAN, "azimuth of half axis a, instead of theta, phi and psi"),
    "tilt": Number(RADIAN, "elevation of half axis a, instead of theta, phi and psi"),
    "roll": Number(RADIAN, "turn about half axis a, instead of theta, phi and psi"),
    "spin": Number(
        RADIAN_PER_SECOND, "angular velocity, which is vertical, instead of other rates"
    ),
}
Begin: Any = namedtuple("Begin", "moving x y")
"""A start: the common state of the body, and its place x, y [m], which integrals read by name."""


def start(data: dict[str, Any], s: Any, z: Any, b: Asymmetric) -> Any:
    """Return the `Begin` of a start, from the numbers of the user in `data`: `System.start`.

    s, z are sin(theta), cos(theta). The orientation is given by theta, phi and psi, or by tilt,
    roll and heading; missing numbers are zero. psi_dot and centre_at_rest replace others as in
    `gliding.start_of`; a change of one is a change of both.
    """
    none = 0 * z
    given = SimpleNamespace(**{name: none + data.get(name, 0) for name in (*INITIAL, *rows.LOWEST)})
    first, third = axes_of_angles(s, z, given.phi, given.psi)
    if any(name in data for name in LYING):
        # half axis a has this tilt and azimuth; half axis c is 1hat of it, turned by -roll
        below, one = axes_of_angles(cos(given.tilt), sin(given.tilt), given.heading, given.roll)
        third = times(-1, below)
        first = minus(times(b.outline.cos, one), times(b.outline.sin, cross(third, one)))
    u = Frame(*third, *first)
    if "psi_dot" not in data:
        given.psi_dot = given.omega3 - given.phi_dot * u.z
    turn_x, turn_y = contact.of_azimuth(none, given.theta_dot, given.phi)
    turn = Vector(turn_x, turn_y, given.phi_dot + given.spin)
    x = Turning(u, frame.momentum(plus(turn, times(given.psi_dot, third)), u, b))
    vx, vy = contact.of_azimuth(given.nu_x, given.nu_y, given.phi)
    velocity = contact.centre_velocity(x, Vector(vx, vy, given.nu_z), b)
    if data.get("centre_at_rest"):
        velocity = velocity._replace(x=none, y=none)
    height = given.gap + contact.height_of(u, b)
    return Begin(Moving(*x, velocity, height), given.x, given.y)


# --- rows and scalars ---------------------------------------------------------------------------


ANGLES = filled(**gliding.ANGLES._asdict(), psi=RADIAN)
ROLLING_ANGLES = filled(**rolling.ANGLES._asdict(), psi=RADIAN)
ROW_ANGLES = filled(**ANGLES._asdict(), **rows.LOWEST)
"""Public variables: those of other bodies, with psi."""

Scalars = type(filled(**dict.fromkeys((*rows.FIELDS, "motion", "up", "turns", "spin", "rotation"))))
"""The scalars of other rows; the common state; zhat and omega x zhat along the half axes, (3,);
omega_z [rad/s]; energy of rotation [J]. `row_scalars` fills the record by position; `angles_by` and
`rotation_energy` read `motion` and `rotation` by name.
"""


def row_scalars(q: Any, b: Asymmetric) -> Any:
    """Return the `Scalars` of a row q."""
    x = moving(q)
    up = frame.up(x.u)
    omega = frame.turns(x, b)
    return Scalars(
        *rows.row_scalars(q, b),
        x,
        b.outline.half_axes(up),
        b.outline.half_axes(cross(omega, up)),
        dot(up, omega),
        dot(omega, frame.along_axes(x.L, x.u)) / 2,
    )


def row_of_angles(e: Any, s: Any, z: Any, b: Asymmetric) -> Any:
    """Return the row of e, a `Begin` or a record of angles; the force in it is 0, not yet known."""
    start_of_body = e if isinstance(e, Begin) else start(e._asdict(), s, z, b)
    return rows.filled_row(rows.FRAME_UNITS, start_of_body.moving)


OF_ROW = replace(
    rows.ROW,
    units=rows.FRAME_UNITS,
    scalars=row_scalars,
    of_angles=row_of_angles,
    to_angles=gliding.angles_by(ROW_ANGLES, row_scalars),
    orientation=OF_FRAME,
)


# --- the forms of one phase ---------------------------------------------------------------------


NOT_JAMMED = replace(gliding.NOT_JAMMED, formula=lambda s, b: -bias_vector(s.motion, b).z / s.force)
"""The function is the acceleration, without a force, by which the contact point sinks, per normal
force [1/kg]; `body.contact_mobility` is the same times m."""
SLIDES = replace(
    rows.form_of(slip_under(Frictionless, lies=FRAME), "slip", ANGLES, OF_ROW),
    domains=(NOT_JAMMED,),
)
"""Under any law that is smooth in the velocity: `slip_under` reads only that `Frictionless` has no
regions, and the force is that of b.friction."""
ROLLS = rows.form_of(without_slip((), lies=FRAME), "roll", ROLLING_ANGLES, OF_ROW)


# --- columns and events -------------------------------------------------------------------------


def heading(s: Any, b: Asymmetric) -> Any:
    """Return the azimuth of half axis a [rad]."""
    along = frame.in_space(Vector(b.outline.cos, b.outline.sin, 0), s.motion.u)
    return atan2(along.y, along.x)


SPIN = "angular velocity about the vertical"
COMMON = (
    rows.ENERGY,
    rows.NORMAL_FORCE,
    Quantity("spin", "omega_z", RADIAN_PER_SECOND, SPIN, lambda s, b: s.spin),
    Quantity("heading", "", RADIAN, "azimuth of half axis a, in (-pi, pi]", heading),
    Quantity(
        "tilt",
        "",
        RADIAN,
        "elevation of half axis a",
        lambda s, b: atan2(s.up.x, sqrt(s.up.y * s.up.y + s.up.z * s.up.z)),
    ),
    Quantity(
        "roll",
        "",
        RADIAN,
        "turn about half axis a, in (-pi, pi]",
        lambda s, b: atan2(s.up.y, s.up.z),
    ),
)
OF_AXES = (
    Event(
        "spin_reversal",
        "the spin about the vertical changes its sign",
        lambda s, b: s.spin,
        kept=(
            Kept("reversed_at", "first", "the spin first changes its sign; NaN: never"),
            Kept("last_reversed_at", "last", "the spin last changes its sign; NaN: never"),
            Kept("spin_reversals", "count", "changes of the sign of the spin"),
        ),
    ),
    Event(
        "tilt_peak",
        "the tilt (pitch) of half axis a is greatest or least",
        lambda s, b: s.turns.x,
    ),
    Event(
        "roll_peak",
        "the roll about half axis a is greatest or least",
        lambda s, b: s.turns.y * s.up.z - s.up.y * s.turns.z,
    ),
    gliding.EQUATOR,
    gliding.INVERTED,
)


OF_SYSTEM = gliding.OF_SYSTEM | {
    "initial": INITIAL,
    "alternatives": (
        *gliding.ALTERNATIVES,
        *(Alternative(n, ("theta", "phi", "psi", "theta_dot", "nu_x", "nu_y")) for n in LYING),
        Alternative("spin", ("theta_dot", "phi_dot", "omega3", "psi_dot")),
    ),
    "start": start,
    "angles": ANGLES,
    "forms": {"vector": SLIDES},
    "quantities": (*COMMON, rows.FRICTION_POWER),
    "events": (*OF_AXES, rows.LIFTOFF, gliding.SETTLED),
    "undefined_at_poles": (*gliding.UNDEFINED_AT_POLES, "psi"),
    "long_names": gliding.LONG_NAMES | {"psi": PSI},
    "opening": Opening(framed=(ROW_ANGLES, OF_ROW)),
}
"""Fields of a System that glides."""

ROLLING = rolling.of_system_at_rest(OF_SYSTEM) | {
    "angles": ROLLING_ANGLES,
    "forms": {"vector": ROLLS},
    "quantities": (*COMMON, rows.HORIZONTAL, rows.FRICTION_NEEDED),
    "events": (*OF_AXES, rows.LIFTOFF),
    "opening": None,
}
"""Fields of a System in pure rolling."""
