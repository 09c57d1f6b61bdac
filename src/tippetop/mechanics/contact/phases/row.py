"""The state of a body in any phase of its contact: what a row of a run says, whichever equations moved it.

The velocity of the centre of mass has three components, and so has the reaction; the ball that is in contact, or was
last, has the radius and the offset along 3hat that every formula of a gliding body calls R and c.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from ...form import Form, Integral, Quantity
from ...operand import Operand, Vector, cos, formula, sin, sqrt
from ...units import (
    ANGULAR_MOMENTUM,
    JELLETT,
    JOULE,
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    NEWTON_SECOND,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    WATT,
)
from .. import body as contact
from ..gliding.chart import axis_and_momentum, axis_angles
from ..gliding.vector import axis, axis_rate, momentum
from ..integrals import NAMED
from ..orientation import carried_along
from ..rolling.reaction import kinematics
from ..rolling.vector import spin


PHASES = ("slip", "roll", "flight", "both")
"""Phases of the contact; the place of a name is its number in a store."""

BALLS = ("body", "stem")
"""What touches the plane; the place of a name is its number in a store."""


TAKEN = "jellett_taken"
"""Jellett's integral as it was when its ball touched the plane first: what its drift is relative to."""


class Row(NamedTuple):
    """3hat, L about the centre of mass, its velocity, its height; the reaction; radius and offset of the ball in
    contact; height of the stem's ball above the plane; numbers of phase and ball; Jellett's integral as it was when
    the ball was taken; power that a torque of the contact takes."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    rx_dot: Operand
    ry_dot: Operand
    rz_dot: Operand
    height: Operand
    Fx: Operand
    Fy: Operand
    Fz: Operand
    radius: Operand
    offset: Operand
    stem_gap: Operand
    phase: Operand
    ball: Operand
    jellett_taken: Operand
    drilled: Operand


ROW_UNITS = Row(
    *(ONE,) * 3,
    *(ANGULAR_MOMENTUM,) * 3,
    *(METRE_PER_SECOND,) * 3,
    METRE,
    *(NEWTON,) * 3,
    *(METRE,) * 3,
    ONE,
    ONE,
    JELLETT,
    WATT,
)


class Angles(NamedTuple):
    """What users give and read: as of a gliding body, and the vertical velocity of the lowest point and its height."""

    theta: Operand
    theta_dot: Operand
    phi_dot: Operand
    omega3: Operand
    nu_x: Operand
    nu_y: Operand
    nu_z: Operand
    gap: Operand
    phi: Operand
    x: Operand
    y: Operand
    work: Operand
    impulse: Operand


ANGLES = Angles(
    RADIAN,
    *(RADIAN_PER_SECOND,) * 3,
    *(METRE_PER_SECOND,) * 3,
    METRE,
    RADIAN,
    METRE,
    METRE,
    JOULE,
    NEWTON_SECOND,
)


class Scalars(NamedTuple):
    """The scalars of a gliding body, and what else a row says."""

    z: Operand  # cos(theta)
    s2: Operand  # sin(theta)^2
    z_dot: Operand  # -theta' sin(theta)
    z_ddot_free: Operand
    phi_dot_s2: Operand  # phi' sin(theta)^2
    axis_speed2: Operand  # |3hat'|^2
    L3: Operand
    Lz: Operand
    v_u: Operand  # v_A.3hat of the horizontal part
    v_n: Operand  # (3hat x v_A).zhat
    v2: Operand  # |v_A|^2 of the horizontal part
    rise: Operand  # v_A.zhat
    speed2: Operand  # |s'|^2 of the centre of mass, all three components
    height: Operand  # of the centre of mass
    power: Operand  # that friction takes
    force: Operand  # normal force
    radius: Operand
    offset: Operand
    gap: Operand  # of the ball that is in contact, or was last
    stem_gap: Operand
    phase: Operand
    ball: Operand
    jellett_taken: Operand


@formula
def point_velocity(u, L, v, radius, offset, b):
    """Velocity of the lowest point of a ball, (3,) [m/s]; v is that of the centre of mass."""
    return contact.contact_velocity(u, L, v, b._replace(R=radius, c=offset))


@formula
def row_scalars(q, b):
    """The scalars of a row."""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    k = kinematics(u, L, u_dot, b)
    v = point_velocity(u, L, Vector(q.rx_dot, q.ry_dot, q.rz_dot), q.radius, q.offset, b)
    return Scalars(
        **k._asdict(),
        v_u=u.x * v.x + u.y * v.y,
        v_n=u.x * v.y - u.y * v.x,
        v2=v.x * v.x + v.y * v.y,
        rise=v.z,
        speed2=q.rx_dot**2 + q.ry_dot**2 + q.rz_dot**2,
        height=q.height,
        power=q.drilled - (q.Fx * v.x + q.Fy * v.y),
        force=q.Fz,
        radius=q.radius,
        offset=q.offset,
        gap=q.height - q.radius + q.offset * u.z,
        stem_gap=q.stem_gap,
        phase=q.phase,
        ball=q.ball,
        jellett_taken=q.jellett_taken,
    )


@formula
def free_rates(q, b):
    """The motion in free flight: L stays, s'' = -g zhat. The contact's numbers change by jumps alone."""
    u_dot, none = axis_rate(q, b), 0 * q.uz
    kept = [none] * (len(Row._fields) - 10)
    return Row._make((*u_dot, none, none, none, none, none, none - b.g, q.rz_dot, *kept))


@formula
def row_of_angles(e, s, z, b):
    """The row of the angles, its reaction not yet known; s, z are sin(theta), cos(theta), exact at the poles."""
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    none = 0 * z
    radius, offset = b.R + none, b.c + none
    at_rest = point_velocity(u, L, Vector(none, none, none), radius, offset, b)
    ex, ey = cos(e.phi), sin(e.phi)
    lam = radius * L.z - offset * (b.I3 * e.omega3)
    return Row(
        u.x,
        u.y,
        u.z,
        L.x,
        L.y,
        L.z,
        e.nu_x * ex - e.nu_y * ey - at_rest.x,
        e.nu_x * ey + e.nu_y * ex - at_rest.y,
        e.nu_z - at_rest.z,
        e.gap + radius - offset * z,
        none,
        none,
        none,
        radius,
        offset,
        none,
        none,
        none,
        lam,
        none,
    )


@formula
def angles_of_row(q, carried, b):
    """The angles of a row; 0/0 exactly at a pole, where phi and what is taken along it mean nothing."""
    c, u = row_scalars(q, b), axis(q)
    theta, theta_dot, phi_dot, phi = axis_angles(c, u)
    s = sqrt(c.s2)
    place_and_integrals = (carried.x, carried.y, carried.work, carried.impulse)
    return Angles(
        theta, theta_dot, phi_dot, c.L3 / b.I3, c.v_u / s, c.v_n / s, c.rise, c.gap, phi, *place_and_integrals
    )


def constant(name: str) -> Integral:
    """What is carried from phase to phase under this name: here it does not change."""
    unit, long_name = NAMED[name]
    return Integral(name, unit, long_name, formula(lambda q, carried, b: 0 * q.uz))


ROW = Form(
    "vector",
    ROW_UNITS,
    free_rates,
    row_scalars,
    row_of_angles,
    angles_of_row,
    integrals=(
        Integral("x", *NAMED["x"], formula(lambda q, carried, b: q.rx_dot)),
        Integral("y", *NAMED["y"], formula(lambda q, carried, b: q.ry_dot)),
        constant("work"),
        constant("impulse"),
    ),
    orientation=carried_along(axis, axis_rate, spin),
)
"""The motion as rows have it; as equations of motion it is that of free flight."""


def of_ball(function: Callable) -> Callable:
    """A formula of a gliding body, of the ball in contact: its R and c are those of the row."""
    return formula(lambda s, b: function(s, b._replace(R=s.radius, c=s.offset)))


@formula
def energy(s, b):
    """Energy E = m |s'|^2/2 + omega.L/2 + m g s_z [J]; E' = F.v_A."""
    return b.m * s.speed2 / 2 + contact.rotation_energy(s, b) + b.m * (b.g * s.height)


def _field(name: str) -> Any:
    return formula(lambda s, b: getattr(s, name))


JELLETTS = (
    Quantity("jellett", "lambda", JELLETT, "Jellett's integral of the ball in contact", of_ball(contact.jellett)),
    Quantity(TAKEN, "", JELLETT, "Jellett's integral when its ball was taken", _field(TAKEN), is_column=False),
)


def quantities(routh: Callable | None, stem: bool) -> tuple[Quantity, ...]:
    """What can be read of a row, as columns; `routh` is Routh's function of a gliding body, if its system has one."""
    columns = [
        Quantity("energy", "E", JOULE, "energy", energy),
        Quantity(
            "modified_energy", "E~", JOULE, "modified (rolling) energy of the ball in contact",
            of_ball(contact.modified_energy),
        ),
        Quantity("normal_force", "g_n", NEWTON, "normal force", _field("force")),
        Quantity("friction_power", "-E'", WATT, "power dissipated by friction", _field("power")),
        Quantity("z", "s_z", METRE, "height of the centre of mass", _field("height")),
        Quantity("phase", "phase", ONE, "phase of the contact", _field("phase"), PHASES),
        Quantity("ball", "ball", ONE, "what touches the plane, or did last", _field("ball"), BALLS),
    ]  # fmt: skip
    if routh is not None:
        text = "Routh's function of the ball in contact"
        columns.insert(0, Quantity("routh", "D", ANGULAR_MOMENTUM, text, of_ball(routh)))
    if stem:
        columns.append(Quantity("gap_stem", "gap of the stem", METRE, "height of the stem's ball", _field("stem_gap")))
    return tuple(columns)
