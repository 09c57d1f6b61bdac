"""The common state of a body whose contact may open, and the rows in which a run of any phase is
written.

A jump from one phase to another takes and gives a `Moving`; a row adds the reaction of the plane,
the ball in contact, or last in contact, and the phase. Columns and user-defined events are
functions of the `Scalars` of a row.
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ..form import Form, Integral, Phase, Quantity
from ..operand import Operand, Vector, cos, dot, formula, sin, sqrt
from ..units import (
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
from . import body as contact
from .gliding.chart import axis_and_momentum, axis_angles
from .gliding.vector import axis, axis_rate, momentum
from .integrals import NAMED
from .orientation import carried_along, planar
from .rolling.reaction import kinematics
from .rolling.vector import spin


PHASES = ("slip", "roll", "flight", "both")
"""Labels of phases; the place of a label is its number in a store."""

BALLS = ("body", "stem")
"""What touches the plane; the place of a name is its number in a store."""

REFERENCE = ("jellett_reference", JELLETT, "Jellett's integral when its ball first touched")
"""An integral that only jumps change: the drift of Jellett's integral is relative to it."""

LOST = (
    "jellett_lost",
    JELLETT,
    "Jellett's integral taken by the torque of the contact since the start",
)


class Moving(NamedTuple):
    """The common state: how a body lies and moves."""

    u: Vector  # 3hat
    L: Vector  # about the centre of mass
    velocity: Vector  # of the centre of mass
    height: Operand  # of the centre of mass
    carried: Any = ()  # the record of the integrals of the run


class Reaction(NamedTuple):
    """What the plane does to a body."""

    force: Vector
    drilled: Operand = 0  # power that torques of the contact take


class Row(NamedTuple):
    """A common state as one record of numbers, and what else a row contains."""

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
    radius: Operand  # of the ball in contact, or last in contact
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
    *(ONE,) * 2,
    JELLETT,
    WATT,
)


def moving(row: Row, carried: Any) -> Moving:
    """Return the common state of a row."""
    return Moving(Vector(*row[:3]), Vector(*row[3:6]), Vector(*row[6:9]), row.height, carried)


def row(phase: Phase, q: Any, carried: Any, bodies: tuple[contact.Touch, ...]) -> Row:
    """Return the row of a state of a phase, of numbers or arrays; `bodies`: the body seen from each
    ball."""
    b, stem = bodies[phase.ball], bodies[-1]
    x, by = phase.leave(q, b), phase.reaction(q, b)
    reference = carried.jellett_reference
    if phase.label == "both" and not hasattr(carried, LOST[0]):  # nothing is conserved
        reference = contact.jellett_of(x.L.z, dot(x.L, x.u), b)
    gap = x.height - stem.R + stem.c * x.u.z if len(bodies) > 1 else 0
    number = PHASES.index(phase.label)
    contact_of = b.R, b.c, gap, number, phase.ball, reference, by.drilled
    return Row._make((*x.u, *x.L, *x.velocity, x.height, *by.force, *contact_of))


def gained(x: Moving, **integrals: Any) -> Moving:
    """Return the state with more of some integrals."""
    more = {name: getattr(x.carried, name) + value for name, value in integrals.items()}
    return x._replace(carried=x.carried._replace(**more))


# --- scalars --------------------------------------------------------------------------------------


class Scalars(NamedTuple):
    """The scalars of a gliding body, and what else a row contains."""

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
def lowest_velocity(q, b):
    """Velocity of the lowest point of the ball of a row, (3,) [m/s]."""
    V, b = Vector(q.rx_dot, q.ry_dot, q.rz_dot), b._replace(R=q.radius, c=q.offset)
    return contact.contact_velocity(axis(q), momentum(q), V, b)


@formula
def row_scalars(q, b):
    """The scalars of a row."""
    u, v = axis(q), lowest_velocity(q, b)
    return Scalars(
        **kinematics(u, momentum(q), axis_rate(q, b), b)._asdict(),
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


# --- angles ---------------------------------------------------------------------------------------


class Angles(NamedTuple):
    """What users give and read: as of a gliding body, and velocity and height of the lowest
    point."""

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
DiscAngles: Any = namedtuple("DiscAngles", (*Angles._fields, LOST[0]))  # type: ignore[misc]
DISC_ANGLES = DiscAngles._make((*ANGLES, JELLETT))


class PlanarAngles(NamedTuple):
    """The same of a motion in a plane, where theta is not wrapped."""

    theta: Operand
    theta_dot: Operand
    nu_x: Operand
    nu_z: Operand
    gap: Operand
    x: Operand
    work: Operand
    impulse: Operand


PLANAR_ANGLES = PlanarAngles(*(getattr(ANGLES, name) for name in PlanarAngles._fields))


@formula
def row_of_angles(e, s, z, b):
    """The row of the angles, its reaction not yet known; s, z are sin(theta), cos(theta), exact at
    the poles."""
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    none = 0 * z
    b = b._replace(R=b.R + none, c=b.c + none)
    at_rest = contact.contact_velocity(u, L, Vector(none, none, none), b)
    ex, ey = cos(e.phi), sin(e.phi)
    along_x, along_y = e.nu_x * ex - e.nu_y * ey, e.nu_x * ey + e.nu_y * ex
    velocity = along_x - at_rest.x, along_y - at_rest.y, e.nu_z - at_rest.z
    height, jellett = e.gap + b.R - b.c * z, contact.jellett_of(L.z, b.I3 * e.omega3, b)
    zeros = (none,) * 3
    return Row._make((*u, *L, *velocity, height, *zeros, b.R, b.c, *zeros, jellett, none))


@formula
def angles_of_row(q, carried, b):
    """The angles of a row; 0/0 exactly at a pole, where phi and what is taken along it are
    undefined."""
    c = row_scalars(q, b)
    theta, theta_dot, phi_dot, phi = axis_angles(c, axis(q))
    s = sqrt(c.s2)
    place_and_integrals = (carried.x, carried.y, carried.work, carried.impulse)
    return Angles(
        theta,
        theta_dot,
        phi_dot,
        c.L3 / b.I3,
        c.v_u / s,
        c.v_n / s,
        c.rise,
        c.gap,
        phi,
        *place_and_integrals,
    )


@formula
def disc_angles_of_row(q, carried, b):
    """The same where torques of the contact take Jellett's integral."""
    return DiscAngles._make((*angles_of_row(q, carried, b), carried.jellett_lost))


@formula
def row_of_planar_angles(e, s, z, b):
    """The row of the angles of a motion in a plane."""
    none = 0 * z
    return row_of_angles(Angles(**{**dict.fromkeys(Angles._fields, none), **e._asdict()}), s, z, b)


@formula
def planar_angles_of_row(q, carried, b):
    """The angles of a row of a motion in a plane."""
    v, gap = lowest_velocity(q, b), row_scalars(q, b).gap
    return PlanarAngles(
        carried.theta,
        planar_theta_dot(q, b),
        v.x,
        v.z,
        gap,
        carried.x,
        carried.work,
        carried.impulse,
    )


@formula
def planar_theta_dot(q, b):
    """theta' [rad/s] of an axis in the x-z plane."""
    u_dot = axis_rate(q, b)
    return q.uz * u_dot.x - q.ux * u_dot.z


# --- the forms of rows ----------------------------------------------------------------------------


def carried(*names: str) -> tuple[Integral, ...]:
    """Return the integrals of rows; a phase integrates some of them, the others stay."""
    return (
        *(Integral(name, *NAMED[name], rate=None) for name in names),
        Integral(*REFERENCE, rate=None),
    )


ROW = Form(
    "vector",
    ROW_UNITS,
    None,
    row_scalars,
    row_of_angles,
    angles_of_row,
    integrals=carried("x", "y", "work", "impulse"),
    orientation=carried_along(axis, axis_rate, spin),
)
DISC_ROW = replace(
    ROW,
    to_angles=disc_angles_of_row,
    integrals=(*ROW.integrals, Integral(*LOST, rate=None)),
)
PLANAR_ROW = replace(
    ROW,
    name="angle",
    of_angles=row_of_planar_angles,
    to_angles=planar_angles_of_row,
    integrals=carried("theta", "x", "work", "impulse"),
    orientation=planar(lambda q: (q.ux, q.uz)),
)


# --- columns --------------------------------------------------------------------------------------


def of_ball(function: Callable) -> Callable:
    """Return a formula of a gliding body for the ball in contact: its R and c are those of the
    row."""
    return formula(lambda s, b: function(s, b._replace(R=s.radius, c=s.offset)))


@formula
def energy(s, b):
    """Energy E = m |s'|^2/2 + omega.L/2 + m g s_z [J]; E' = F.v_A."""
    return b.m * s.speed2 / 2 + contact.rotation_energy(s, b) + b.m * (b.g * s.height)


def _field(name: str) -> Any:
    return formula(lambda s, b: getattr(s, name))


def columns(planar: bool, routh: Callable | None, stem: bool) -> tuple[Quantity, ...]:
    """Return the columns of rows; `routh`: Routh's function of a gliding body, if its system has
    one."""
    found = [
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
        found.insert(0, Quantity("routh", "D", ANGULAR_MOMENTUM, text, of_ball(routh)))
    if not planar:
        text = "Jellett's integral when its ball was taken"
        found[:0] = (
            Quantity("jellett", "lambda", JELLETT, "Jellett's integral of the ball in contact",
                     of_ball(contact.jellett)),
            Quantity("jellett_taken", "", JELLETT, text, _field("jellett_taken"), is_column=False),
        )  # fmt: skip
    if stem:
        found.append(
            Quantity(
                "gap_stem",
                "gap of the stem",
                METRE,
                "height of the stem's ball",
                _field("stem_gap"),
            )
        )
    return tuple(found)
