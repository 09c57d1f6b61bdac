"""Bodies without an axis of symmetry: starts, scalars, columns, events and rows.

Their phases and jumps are those of other bodies: a state has axes 1 and 3 of the body, so that
their orientation needs no integral.
"""

from collections import namedtuple
from dataclasses import replace
from typing import Any

from ..event import Event, Kept
from ..form import Domain, Form, Phase, Quantity
from ..friction import Frictionless
from ..number import Alternative, Number
from ..operand import Vector, atan2, cos, cross, dot, minus, plus, sin, sqrt, times
from ..units import JOULE, NEWTON, RADIAN, RADIAN_PER_SECOND, WATT
from . import body as contact
from . import frame, gliding, rolling, rows
from .body import FRAME, VELOCITY, Moving, Reaction, Turning, filled, state
from .body_axes import axes_of_angles
from .contact_phases import OF_FRAME, PHASES, slip_under, smooth_friction, without_slip
from .frame import Asymmetric, Frame
from .response import gains
from .rows import LOWEST, ROW, moving


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
ALTERNATIVES = (
    *gliding.ALTERNATIVES,
    *(Alternative(n, ("theta", "phi", "psi", "theta_dot", "nu_x", "nu_y")) for n in LYING),
    Alternative("spin", ("theta_dot", "phi_dot", "omega3", "psi_dot")),
)
ROLLING = {name: rule for name, rule in INITIAL.items() if not name.startswith("nu_")}
ROLLING_ALTERNATIVES = (
    gliding.BY_PSI_DOT,
    *(Alternative(n, ("theta", "phi", "psi", "theta_dot")) for n in LYING),
    ALTERNATIVES[-1],
)

Begin: Any = namedtuple("Begin", "u omega v x y gap")
"""A start: how the body lies, its angular velocity, and v_A."""


def start(data: dict[str, Any], s: Any, z: Any, b: Asymmetric) -> Any:
    """Return the start by the numbers that the user gave; s, z are sin(theta), cos(theta)."""
    none = 0 * z
    known = {name: none + data.get(name, 0) for name in (*INITIAL, "gap", "nu_z")}
    phi, tilt, roll, heading = (known[name] for name in ("phi", *LYING))
    ex = cos(phi)
    ey = sin(phi)
    along = Vector(ex, ey, none)
    node = Vector(-ey, ex, none)
    if any(name in data for name in LYING):
        one = Vector(cos(tilt) * cos(heading), cos(tilt) * sin(heading), sin(tilt))
        across = Vector(-sin(heading), cos(heading), none)
        above = cross(one, across)
        two = plus(times(cos(roll), across), times(sin(roll), above))
        third = cross(one, two)
        first = minus(times(b.outline.cos, one), times(b.outline.sin, two))
    else:
        first, third = axes_of_angles(s, z, phi, known["psi"])
    u = Frame(*third, *first)
    if "spin" in data:
        omega = Vector(none, none, known["spin"])
    else:
        omega3 = known["omega3"]
        if "psi_dot" in data:
            omega3 = known["psi_dot"] + known["phi_dot"] * u.z
        swing = Vector(-u.z * u.x, -u.z * u.y, u.x * u.x + u.y * u.y)  # zhat - z 3hat
        omega = plus(times(known["theta_dot"], node), times(known["phi_dot"], swing))
        omega = plus(omega, times(omega3, third))
    v = plus(times(known["nu_x"], along), times(known["nu_y"], node))
    if data.get("centre_at_rest"):
        v = cross(omega, contact.arm(u, b))
    return Begin(u, omega, v._replace(z=known["nu_z"]), known["x"], known["y"], known["gap"])


def begun(e: Any, s: Any, z: Any, b: Asymmetric) -> tuple[Any, Turning]:
    """Return the start, or that of angles, and how the body lies and turns there."""
    x = e if isinstance(e, Begin) else start(e._asdict(), s, z, b)
    axes = x.u.axes
    omega = frame.parts(x.omega, axes)
    L = Vector(*(I * w for I, w in zip(frame.moments(b), omega, strict=True)))
    return x, Turning(x.u, frame.whole(L, axes))


# --- scalars ------------------------------------------------------------------------------------


Scalars: Any = namedtuple(
    "Scalars",
    "z s2 z_dot phi_dot_s2 axis_speed2 L3 v v_u v_n v2 rise speed2 gap power height Fx Fy force "
    "phase ball u up turns spin rotation",
)
"""As of other rows; v_A, how the body lies, zhat along its axes and its rate there, omega_z, energy
of rotation.
"""


def scalars_of(x: Moving, by: Any, b: Asymmetric, phase: Any = 0, ball: Any = 0) -> Any:
    """Return the scalars of a moving body on which the plane acts."""
    u = x.u
    u_dot = contact.axis_rate(x, b)
    up = frame.up(u.axes)
    omega = frame.turns(x, b)
    v = contact.contact_velocity(x, b)
    values = (
        u.z,
        u.x * u.x + u.y * u.y,
        u_dot.z,
        u.x * u_dot.y - u.y * u_dot.x,
        dot(u_dot, u_dot),
        dot(x.L, u),
        v,
        *contact.slip_scalars(u, v),
        v.z,
        dot(x.velocity, x.velocity),
        contact.gap(x, b),
        0 - dot(by.force, v) + by.drilled,
        x.height,
        *by.force,
        phase,
        ball,
        u,
        up,
        cross(up, omega),
        dot(up, omega),
        dot(omega, frame.parts(x.L, u.axes)) / 2,
    )
    return Scalars._make(values)


ANGLES = filled(**gliding.ANGLES._asdict(), psi=RADIAN)
"""Public variables: those of other bodies, with psi."""

UNDEFINED_AT_POLES = (*gliding.UNDEFINED_AT_POLES, "psi")
VECTORS = gliding.VECTORS
LONG_NAMES = gliding.LONG_NAMES | {
    "psi": "turn psi of the body about its axis, from 1hat; undefined (NaN) exactly at a pole"
}


# --- the forms of one phase ---------------------------------------------------------------------


def contact_mobility(s: Any, b: Asymmetric) -> Any:
    """Return the upward acceleration of the contact point per normal force [1/kg]."""
    force, torque = smooth_friction(Vector(0, 0, 0), s.v, s.z, b)
    return gains(s.u, force, torque, b)[0].z


def form_of(phase: Phase, angles: Any, *domains: Domain) -> Form:
    """Return the form of a body that stays in a phase."""

    def scalars(q: Any, b: Asymmetric) -> Any:
        return scalars_of(phase.leave(q, b), phase.reaction(q, b), b)

    def of_angles(e: Any, s: Any, z: Any, b: Asymmetric) -> Any:
        x, turns = begun(e, s, z, b)
        size = len(phase.form.units) - len(FRAME) - 3
        return type(phase.form.units)(*turns.u, *turns.L, *x.v[:size])

    return replace(
        phase.form,
        scalars=scalars,
        of_angles=of_angles,
        to_angles=gliding.angles_by(angles, scalars),
        integrals=tuple(one for one in phase.form.integrals if one.name in angles._fields),
        domains=domains,
    )


NOT_JAMMED = gliding.NOT_JAMMED._replace(formula=contact_mobility)
SLIDES = form_of(slip_under(Frictionless, lies=FRAME), ANGLES, NOT_JAMMED)
"""Under any law that is smooth in the velocity."""

ROLLING_ANGLES = filled(
    **{n: u for n, u in ANGLES._asdict().items() if n not in ("nu_x", "nu_y", "work")}
)
ROLLS = form_of(without_slip((), lies=FRAME), ROLLING_ANGLES)


# --- rows ---------------------------------------------------------------------------------------


ROW_ANGLES = filled(**ANGLES._asdict(), **LOWEST)
NUMBERS = ("height", "Fx", "Fy", "force", "drilled", "phase", "ball")
ROW_UNITS = state(FRAME, **VELOCITY, **{name: rows.NUMBERS[name] for name in NUMBERS})
Row = type(ROW_UNITS)


def row(phase: Phase, q: Any, carried: Any, b: Asymmetric) -> tuple[Any, Asymmetric]:
    """Return the row of a state of a phase, and the body."""
    x = phase.leave(q, b)
    by = phase.reaction(q, b)
    numbers = x.height, *by.force, by.drilled, PHASES.index(phase.label), phase.ball
    return Row(*x.u, *x.L, *x.velocity, *numbers), b


def row_scalars(q: Any, b: Asymmetric) -> Any:
    """Return the scalars of a row."""
    by = Reaction(Vector(q.Fx, q.Fy, q.force), q.drilled)
    return scalars_of(moving(q, ()), by, b, q.phase, q.ball)


def row_of_angles(e: Any, s: Any, z: Any, b: Asymmetric) -> Any:
    """Return the row of a start, its reaction not yet known."""
    x, turns = begun(e, s, z, b)
    velocity = contact.centre_velocity(turns, x.v, b)
    height = x.gap + contact.height_of(x.u, b)
    return Row(*turns.u, *turns.L, *velocity, height, *(0 * z,) * 6)


OF_ROW = replace(
    ROW,
    units=ROW_UNITS,
    scalars=row_scalars,
    of_angles=row_of_angles,
    to_angles=gliding.angles_by(ROW_ANGLES, row_scalars),
    orientation=OF_FRAME,
)


# --- columns and events -------------------------------------------------------------------------


def heading(s: Any, b: Asymmetric) -> Any:
    """Return the azimuth of half axis a."""
    one, two, _ = s.u.axes
    along = plus(times(b.outline.cos, one), times(b.outline.sin, two))
    return atan2(along.y, along.x)


def tilt(s: Any, b: Asymmetric) -> Any:
    """Return the elevation of half axis a."""
    rises = b.outline.half_axes(s.up)
    return atan2(rises.x, sqrt(rises.y * rises.y + rises.z * rises.z))


def roll(s: Any, b: Asymmetric) -> Any:
    """Return the turn about half axis a, zero where half axis b is horizontal."""
    rises = b.outline.half_axes(s.up)
    return atan2(rises.y, rises.z)


def tilts(s: Any, b: Asymmetric) -> Any:
    """Return the rate at which the end of half axis a rises."""
    return b.outline.half_axes(s.turns).x


def rolls(s: Any, b: Asymmetric) -> Any:
    """Return the rate of `roll` times a positive number."""
    rates = b.outline.half_axes(s.turns)
    return rates.y * s.up.z - b.outline.half_axes(s.up).y * rates.z


def energy(s: Any, b: Asymmetric) -> Any:
    """Return the energy E [J]; E' = F.v_A."""
    return b.m * s.speed2 / 2 + s.rotation + b.m * (b.g * s.height)


COMMON = (
    Quantity("energy", "E", JOULE, "energy", energy),
    Quantity("normal_force", "g_n", NEWTON, "normal force", lambda s, b: s.force),
    Quantity(
        "spin",
        "omega_z",
        RADIAN_PER_SECOND,
        "angular velocity about the vertical",
        lambda s, b: s.spin,
    ),
    Quantity("heading", "", RADIAN, "azimuth of half axis a, in (-pi, pi]", heading),
    Quantity("tilt", "", RADIAN, "elevation of half axis a", tilt),
    Quantity("roll", "", RADIAN, "turn about half axis a, in (-pi, pi]", roll),
)
QUANTITIES = (
    *COMMON,
    Quantity("friction_power", "-E'", WATT, "power dissipated by friction", lambda s, b: s.power),
)
_, HORIZONTAL, NEEDED = rolling.REACTION
ROLLING_QUANTITIES = (
    *COMMON,
    replace(HORIZONTAL, formula=lambda s, b: sqrt(s.Fx * s.Fx + s.Fy * s.Fy)),
    replace(NEEDED, formula=lambda s, b: sqrt(s.Fx * s.Fx + s.Fy * s.Fy) / s.force),
)

REVERSAL = Event(
    "spin_reversal",
    "the angular velocity about the vertical changes its sign",
    lambda s, b: s.spin,
    kept=(
        Kept("reversed_at", "first", "the spin first changes its sign; NaN: never"),
        Kept("last_reversed_at", "last", "the spin last changes its sign; NaN: never"),
        Kept("spin_reversals", "count", "changes of the sign of the spin"),
    ),
)
OF_AXES = (
    REVERSAL,
    Event("tilt_peak", "the tilt (pitch) of half axis a is greatest or least", tilts),
    Event("roll_peak", "the roll about half axis a is greatest or least", rolls),
    gliding.EQUATOR,
    gliding.INVERTED,
)
EVENTS = (
    *OF_AXES,
    replace(gliding.LIFTOFF, formula=lambda s, b: s.force),
    gliding.SETTLED,
)
ROLLING_EVENTS = (*OF_AXES, replace(rolling.LIFTOFF, formula=lambda s, b: s.force))
