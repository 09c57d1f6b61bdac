"""The body, and functions of its motion that are the same in every form. [T 3.3, 4.1, 5.1]

In go a body and its motion, as numbers, arrays or heyoka expressions; out come velocities, forces
and energies, for equations of motion, events and columns. Any consistent units may be used; the
docstrings give those of SI. Vectors are in the frame fixed in space, z up, and so regular where
theta = 0 or pi. [T 3.16] is an equation of the thesis that the README cites.

Symbols
    b         the body, a `Touch`: a ball of radius R, its centre at c 3hat from the centre of mass
    u, 3hat   unit vector along its axis; theta: angle from zhat to it, phi: its azimuth
    e, 2hat   horizontal unit vectors (cos(phi), sin(phi), 0), and zhat x e
    z         cos(theta); s in (e, s, z, b): sin(theta), and e the record of angles and rates
    s         in (s, b): a record of scalars, see `Kinematics` and `Scalars`
    x         a motion in vectors: `Turning` (u, L) or `Moving`; q: the state of a form
    L         angular momentum about the centre of mass; L3 = L.3hat, Lz = L.zhat
    A, a      the contact point; the arm, c 3hat - R zhat, from the centre of mass to A
    v_A       velocity of A, nu_x along e and nu_y along 2hat
    F, g_n    force of the plane at A; its normal part; friction is -k g_n v_A, k(|v_A|^2, z) >= 0
"""

import math
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import update_wrapper
from typing import Any, ClassVar, NamedTuple

from ...errors import InputError
from ..friction import Frictionless, slip_coefficient
from ..number import Record
from ..operand import Operand, Vector, cos, cross, dot, formula, minus, plus, select, sin, times
from ..units import (
    ANGULAR_MOMENTUM,
    METRE_PER_SECOND,
    ONE,
)
from . import frame
from .frame import Asymmetric, Frame
from .outline import at


class Touch(NamedTuple):
    """A body seen from one of its balls: the argument `b` of formulas. The arm is c 3hat - R zhat.

    `Top.seen` makes it, or `seen_from_balls` for a body with a stem. R, c, bend and height of a
    body with an outline are () until `touching_ball` fills them in. The first seven fields are
    given by position (`Top.seen`, `engine.impacts`).
    """

    m: Operand  # [kg]
    R: Operand  # radius of the ball [m]
    c: Operand  # from the centre of mass to the centre of the ball, along 3hat; any sign [m]
    I1: Operand  # across 3hat, about the centre of mass [kg m^2]
    I3: Operand  # about 3hat [kg m^2]
    g: Operand  # [m/s^2]
    friction: Any  # record of a law
    clearance: Operand = ()  # [m]; other ball touches where this + lever cos(theta) = 0; (): none
    lever: Operand = ()  # [m]; (): none
    outline: Any = ()  # shape of a body that is no ball, see `outline`; (): a ball
    bend: Operand = ()  # c'(z) of an outline [m]
    height: Operand = ()  # R - c z of an outline [m]: as a difference it would lose digits
    around: Any = ()  # a `surroundings.Surroundings`; (): none


def seen_from_balls(b: Touch, stem: tuple) -> tuple[Touch, ...]:
    """Return the body as a `Touch` of its sphere and, if it has a stem, of the stem's ball.

    `stem` is (), or (r, h): the radius of the stem's ball, and how far along 3hat its centre lies
    from that of the sphere. Each Touch has the other ball as `clearance` and `lever`: their
    difference is taken here, because the difference of two offsets from the centre of mass would be
    rounded. The result has the order of BALLS.
    """
    if not stem:
        return (b._replace(clearance=1.0, lever=0.0),)  # no other ball ever touches
    r, h = stem
    return b._replace(clearance=b.R - r, lever=h), b._replace(
        R=r, c=b.c + h, clearance=r - b.R, lever=-h
    )


def seen_from_other(b: Touch) -> Touch:
    """Return the same body as a `Touch` of its other ball; b has `clearance` and `lever`.

    From the sphere it is the second Touch of `seen_from_balls`, but for rounding, and from the
    stem's ball the first; a change of one is a change of both.
    """
    return b._replace(R=b.R - b.clearance, c=b.c + b.lever, clearance=-b.clearance, lever=-b.lever)


def touching_ball(z: Any, s2: Any, b: Touch) -> Touch:
    """Return the body with R and c of the ball by which it touches the plane at z = cos(theta).

    The ball has the curvature of the outline there; other bodies are returned as they are. s2 is
    sin(theta)^2, of which 1 - z^2 would lose digits.
    """
    if not (isinstance(b, Touch) and b.outline):
        return b
    f, first, second, _ = at(z, s2, b.outline.height).parts
    return b._replace(R=f - z * first, c=-first, bend=-second, height=f)


def by_axis(u: Any, b: Touch) -> Touch:
    """Return `touching_ball` of a body whose axis is u = 3hat."""
    return touching_ball(u.z, u.x * u.x + u.y * u.y, b)


def touching(known: Any, b: Touch) -> Touch:
    """Return `touching_ball` of a body in a motion: scalars, a common state or the state of a form.

    The body is returned as it is if the record lacks its inclination, as `Contact` and `Free`, the
    scalars of phases, do: the events of these phases do not read R or c.
    """
    if not getattr(b, "outline", ()):  # of which the inclination is not needed
        return b
    if hasattr(known, "s2"):  # scalars
        return touching_ball(known.z, known.s2, b)
    if hasattr(known, "u"):  # a common state
        return by_axis(known.u, b)
    if hasattr(known, "ux"):  # a state of the vector form, or a row
        return by_axis(axis(known), b)
    if hasattr(known, "theta"):  # a state in Euler angles
        s = sin(known.theta)
        return touching_ball(cos(known.theta), s * s, b)
    return b


def by_body(*, of_outline: Any = None, of_frame: Any = None) -> Callable:
    """Return a decorator: the formula of a sphere, which other bodies replace by their own.

    The decorated formula is used for a sphere, `of_outline` for a `Touch` with an outline (whose
    touching ball is filled in), `of_frame` for an `Asymmetric` body; one that is missing is the
    same as of a sphere. All have the same arguments, the last of which is the body.
    """

    def chosen(of_sphere: Callable) -> Any:
        """Return the function that chooses among the three."""

        def choose(b: Any) -> Callable:
            """Return the formula for a body; an `Asymmetric` always has an outline."""
            if not getattr(b, "outline", ()):
                return of_sphere
            return (of_outline if isinstance(b, Touch) else of_frame) or of_sphere

        return update_wrapper(select(choose), formula(of_sphere))

    return chosen


def as_ball(b: Touch) -> Touch:
    """Return a body with an outline as the ball by which it touches.

    R and c of b are those of `touching_ball`, or the caller replaces them (`rows.ball_of`).
    """
    return b._replace(outline=(), bend=(), height=())


def alone(b: Any) -> Any:
    """Return the body as impacts take it: without its other ball, its outline and surroundings.

    Its touching ball is filled in: `engine.impacts` keeps this ball throughout an impact, as the
    axis stays.
    """
    b = b._replace(clearance=(), lever=(), around=())
    return b if isinstance(b, Asymmetric) else as_ball(b)


def size(b: Any) -> Any:
    """Return the length of a body [m] by which small and large distances are measured.

    Of a ball it is max(R, |c|), so that a tip, R = 0, has one too.
    """
    return b.outline.size if b.outline else max(b.R, abs(b.c))


class Top(Record, abstract=True):
    """A body, by the numbers that the user gives.

    `gliding` and `resting` name its systems, with and without a law.
    """

    table = "parameters"
    gliding: ClassVar[str]
    resting: ClassVar[str]

    def seen(self, friction: Any) -> Any:
        """Return the body as the `b` of formulas: a `Touch` or `Asymmetric`.

        `friction` is the record of a friction law.
        """
        raise NotImplementedError

    def body(self, law: Any = None) -> Any:
        """Return the body that formulas take; `law`: the record of a friction law.

        Raises InputError.
        """
        if law is not None and not hasattr(law, "_fields"):
            raise InputError([f"`law` must be the record of a friction law, but is {law!r:.60}."])
        return self.seen(Frictionless() if law is None else law)

    @classmethod
    def body_of(cls, parameters: Mapping[str, Any], friction: Any) -> Any:
        """Return the body of parameters by name, unchecked, with the record of a friction law."""
        return cls._make(parameters[name] for name in cls._fields).seen(friction)


def filled(**units: Any) -> Any:
    """Return a record of a new type filled with units: the `units` of a form or of angles."""
    return namedtuple("State", units)(**units)


AXIS = ("ux", "uy", "uz")
FRAME = (*AXIS, "ix", "iy", "iz")
"""Variables that describe how a body lies, in the order of the fields of a `frame.Frame`: states
are filled by position (`*x.u`)."""


def state(lies: tuple[str, ...] = AXIS, /, **units: Any) -> Any:
    """Return the `units` of a state: orientation, L, and the further variables that `units` name.

    `lies` are the names of the variables of the orientation, AXIS or FRAME. `on_ball`, `flight` and
    `filled_row` fill states by position, in this order.
    """
    turning = dict.fromkeys(("Lx", "Ly", "Lz"), ANGULAR_MOMENTUM)
    return filled(**dict.fromkeys(lies, ONE), **turning, **units)


VELOCITY = dict.fromkeys(("rx_dot", "ry_dot", "rz_dot"), METRE_PER_SECOND)
"""Variables of the velocity of the centre of mass, in a flight and in rows: filled by position from
a Vector, and read by `contact_phases.moving`."""


BALLS = ("body", "stem")
"""Parts that touch the plane; the position of a name is its number in a store."""


class Turning(NamedTuple):
    """The orientation and the angular momentum of a body, which most formulas take as `x`."""

    u: Any  # 3hat, or a Frame
    L: Vector  # about the centre of mass


@formula
def axis_of(q):
    """Return 3hat of a state q that has it as ux, uy, uz, (3,)."""
    return Vector(q.ux, q.uy, q.uz)


def frame_of(q):
    """Return the Frame, axes 3 and 1, of a state q of a body without an axis of symmetry."""
    return Frame(q.ux, q.uy, q.uz, q.ix, q.iy, q.iz)


axis = select(lambda state: frame_of if "ix" in state._fields else axis_of)
"""axis(q) -> how the body lies: its axis, or a Frame."""


@formula
def turning(q):
    """Return orientation and momentum of a state q as a `Turning`.

    L is about the centre of mass [kg m^2/s].
    """
    return Turning(axis(q), Vector(q.Lx, q.Ly, q.Lz))


class Moving(NamedTuple):
    """The common state of all phases, the `x` of jumps: orientation, momentum, velocity and height.

    `Phase.leave` makes it from the state of a phase, `Phase.enter` converts it back. It begins with
    the fields of a `Turning`, and can take the place of one.
    """

    u: Any  # 3hat, or a Frame
    L: Vector  # about the centre of mass
    velocity: Vector  # of the centre of mass [m/s]
    height: Operand  # of the centre of mass [m]
    carried: Any = ()  # the record of the integrals of the run; (): not filled in


class Reaction(NamedTuple):
    """Action of the plane on a body, which `Phase.reaction` returns and `rows.row` reads."""

    force: Vector  # (3,) [N]
    drilled: Operand = 0  # power that torques of the contact take from the body [W]


def gained(x: Moving, **integrals: Any) -> Moving:
    """Return the state x with amounts added to the integrals of the run, such as work=..., by name.

    Integrals that the run does not have are ignored; `x.carried` must be filled in. Impulses use
    this function, for they take no time.
    """
    known = x.carried._fields
    more = {name: getattr(x.carried, name) + integrals[name] for name in integrals if name in known}
    return x._replace(carried=x.carried._replace(**more))


# --- geometry and velocities --------------------------------------------------------------------


@by_body(of_outline=lambda z, b: b.height)
def height(z, b):
    """Return the height of the centre of mass of a body on the plane, s_z = R - c z [m].

    z is cos(theta), of the inclination of its axis.
    """
    return b.R - b.c * z


@by_body(of_outline=lambda u, b: Vector(b.c * u.x, b.c * u.y, -b.height), of_frame=frame.arm)
def arm(u, b):
    """Return a = c 3hat - R zhat, (3,) [m], from the centre of mass to the contact point.

    u is 3hat.
    """
    return Vector(b.c * u.x, b.c * u.y, b.c * u.z - b.R)


@formula
def height_of(u, b):
    """Return the height of the centre of mass of a body on the plane [m]; u is 3hat, or a Frame."""
    return -arm(u, b).z


@formula
def gap(x, b):
    """Return the gap between the lowest point of a body and the plane [m], negative below it.

    x is a `Moving`; b a `Touch`, of which it is the gap of that ball (of an outline, R and c are
    those of `touching_ball`), or an `Asymmetric`. `rows.row_scalars` has the same for a ball.
    """
    return x.height - height_of(x.u, b)


@formula
def arm2(z, b):
    """Return |a|^2 = R^2 + c^2 - 2 c R z [m^2], the square of the arm's length."""
    return b.R**2 + b.c**2 - 2 * (b.c * b.R * z)


@by_body(of_frame=frame.axis_rate)
def axis_rate(x, b):
    """Return 3hat' = L x 3hat/I1, (3,) [1/s]; x is a `Turning` or `Moving`. [T 3.17]"""
    return times(1 / b.I1, cross(x.L, x.u))


@by_body(of_frame=frame.angular_velocity)
def angular_velocity(x, b):
    """Return omega = I^-1 L, (3,) [rad/s]; x is a `Turning` or `Moving`."""
    return angular_velocity_of(x, dot(x.L, x.u), b)


@by_body(of_frame=frame.momentum)
def momentum_of(omega, u, b):
    """Return L = I omega, (3,) [kg m^2/s], about the centre of mass; u is 3hat."""
    return plus(times(b.I1, omega), times((b.I3 - b.I1) * dot(omega, u), u))


@formula
def angular_velocity_of(x, L3, b):
    """Return omega = L/I1 + (1/I3 - 1/I1) L3 3hat, (3,) [rad/s], where L3 = L.3hat is known."""
    return plus(times(1 / b.I1, x.L), times((1 / b.I3 - 1 / b.I1) * L3, x.u))


@by_body(
    of_outline=lambda x, b: cross(angular_velocity(x, b), arm(x.u, b)),
    of_frame=frame.arm_velocity,
)
def arm_velocity(x, b):
    """Return omega x a, (3,) [m/s]: the velocity of A relative to the centre of mass.

    Of a sphere it is c 3hat' - R omega x zhat, which is equal.
    """
    u_dot = axis_rate(x, b)
    w = angular_velocity(x, b)
    return Vector(b.c * u_dot.x - b.R * w.y, b.c * u_dot.y + b.R * w.x, b.c * u_dot.z)


@formula
def contact_velocity(x, b):
    """Return v_A = x.velocity + omega x a, (3,) [m/s]; x is a `Moving`, in contact or in flight.

    `gliding.sliding_velocity` is the same, summed in another order: the bits differ.
    """
    return plus(x.velocity, arm_velocity(x, b))


@formula
def slip_scalars(u, v):
    """Return v.3hat, (3hat x v).zhat and v.v of the horizontal part of v.

    u is 3hat, v the velocity of the contact point; they are v_u, v_n and v2 of `Scalars`.
    """
    return u.x * v.x + u.y * v.y, u.x * v.y - u.y * v.x, v.x * v.x + v.y * v.y


@formula
def velocities(x, b):
    """Return v_A and omega, (3,) each; x is a `Moving`."""
    return contact_velocity(x, b), angular_velocity(x, b)


@formula
def centre_velocity(x, v, b):
    """Return the velocity of the centre of mass, v - omega x a, (3,) [m/s], if A has v."""
    return minus(v, arm_velocity(x, b))


@formula
def of_azimuth(along_e, along_2, phi):
    """Return x and y of a horizontal vector from its components along e and 2hat."""
    ex = cos(phi)
    ey = sin(phi)
    return along_e * ex - along_2 * ey, along_e * ey + along_2 * ex


@formula
def moment(u, F, b):
    """Return a x F, (3,) [N m]: the torque about the centre of mass of a force F at A.

    b has an axis of symmetry, u = 3hat; it is equal to cross(arm(u, b), F).
    """
    h = height(u.z, b)
    return Vector(
        b.c * (u.y * F.z) + h * F.y,
        -(b.c * (u.x * F.z)) - h * F.x,
        b.c * (u.x * F.y - u.y * F.x),
    )


@formula
def rolling_velocity(e, s, z, b):
    """Return -(omega x a) along e and 2hat [m/s]: the velocity of the centre of mass if v_A = 0.

    e: record with theta_dot, phi_dot, omega3; s, z: sin(theta), cos(theta). It is -`arm_velocity`
    in angles; a change of one is a change of both.
    """
    return e.theta_dot * height(z, b), -(s * (b.R * e.omega3 + e.phi_dot * (b.c - b.R * z)))


# --- functions of the scalars -------------------------------------------------------------------


def inertia_faults(parameters: Mapping[str, float]) -> list[str]:
    """Return a sentence, in a list, if a moment of inertia exceeds the sum of the others.

    `parameters`: I1, I3, and I2 of a body without an axis of symmetry [kg m^2], by name. This
    function is `System.checks` of a system, or a part of it.
    """
    moments = {name: parameters.get(name, parameters["I1"]) for name in ("I1", "I2", "I3")}
    name = max(moments, key=moments.__getitem__)
    others = sum(moments.values()) - moments[name]
    if moments[name] <= others * (1 + 1e-12):  # rounded numbers of a flat body pass
        return []
    words = "the sum of the other moments" if "I2" in parameters else "2*I1"
    return [
        f"`parameters.{name}` must be at most {words} = {others:.6g} (no rigid body has more), but "
        f"is {moments[name]:.6g}."
    ]


def outside_faults(*centre: float) -> list[str]:
    """Return a sentence, in a list, if the centre of mass lies outside of an ellipsoid.

    `centre` is the vector from the centre of mass to the middle of the body, in units of its half
    axes.
    """
    if (distance := math.hypot(*centre)) < 1:
        return []
    return [
        "the centre of mass must lie inside of the body, less than 1 half axis from its middle, "
        f"but is {distance:.6g} half axes away."
    ]


Kinematics: Any = namedtuple("Kinematics", "z s2 z_dot z_ddot_free phi_dot_s2 axis_speed2 L3 Lz")
"""How the axis moves, and L: functions of the state that do not depend on the form; all are smooth
at the poles.

z is cos(theta), s2 is sin(theta)^2, z_dot is -theta' sin(theta) [1/s], z_ddot_free is z'' of the
axis if no torque about the centre of mass acted [1/s^2], phi_dot_s2 is phi' sin(theta)^2 [rad/s],
axis_speed2 is |3hat'|^2 = theta'^2 + phi'^2 sin(theta)^2 [1/s^2], L3 is L.3hat, and Lz is L.zhat,
about the centre of mass [kg m^2/s]. The `Scalars` here, of `rolling` and of `rows` begin with these
fields, and are filled by position.
"""

Scalars = type(filled(**dict.fromkeys((*Kinematics._fields, "v_u", "v_n", "v2", "speed2"))))
"""The kinematics of a body that glides, v_u = v_A.3hat = nu_x sin(theta) [m/s], v_n =
(3hat x v_A).zhat = nu_y sin(theta) [m/s], v2 = |v_A|^2 [m^2/s^2], and speed2 = |r'|^2 of the
horizontal velocity of the centre of mass [m^2/s^2].
"""


@formula
def kinematics(x, u_dot, b):
    """Return the `Kinematics` of a motion x, whose axis has the rate u_dot = 3hat', (3,) [1/s]."""
    u = x.u
    L = x.L
    return Kinematics(
        u.z,
        u.x * u.x + u.y * u.y,
        u_dot.z,
        (L.x * u_dot.y - L.y * u_dot.x) / b.I1,
        u.x * u_dot.y - u.y * u_dot.x,
        dot(u_dot, u_dot),
        dot(L, u),
        L.z,
    )


@formula
def kinematics_of_angles(e, s, z, b):
    """Return the `Kinematics` of e, a record with theta_dot, phi_dot, omega3.

    s, z: sin and cos of theta. Equal to `kinematics` of the same motion in vectors.
    """
    L3 = b.I3 * e.omega3
    phi_dot_s2 = e.phi_dot * s**2
    axis_speed2 = e.theta_dot**2 + (e.phi_dot * s) ** 2
    free = torque_free(L3, phi_dot_s2, axis_speed2, z, b)
    Lz = b.I1 * phi_dot_s2 + L3 * z
    return Kinematics(z, s**2, -(e.theta_dot * s), free, phi_dot_s2, axis_speed2, L3, Lz)


@formula
def torque_free(L3, phi_dot_s2, axis_speed2, z, b):
    """Return z'' if no torque acted [1/s^2]: L3 phi' sin(theta)^2/I1 - z |3hat'|^2."""
    return L3 / b.I1 * phi_dot_s2 - z * axis_speed2


@by_body(of_outline=lambda s, b: s.s2)
def sine2(s, b):
    """Return sin(theta)^2 from the scalars s."""
    return 1 - s.z * s.z


@formula
def contact_mobility(s, b):
    """Return the upward acceleration of A per unit of g_n/m, a number without a unit.

    It must be positive; otherwise the contact jams. [denominator of T 3.16] Divided by m it is the
    vertical part of `response.gains` per normal force; `framed.NOT_JAMMED` has that unit.
    """
    slip = slip_coefficient(s.v2, s.z, b.friction) * s.v_u
    return 1 + b.m * b.c / b.I1 * (b.c * sine2(s, b) - height(s.z, b) * slip)


@by_body(of_outline=lambda z_dot, b: b.g - b.bend * (z_dot * z_dot))
def pull(z_dot, b):
    """Return g - c' z'^2 [m/s^2]: gravity, less that by which an outline's ball changes."""
    return b.g


@formula
def g_n(s, b):
    """Return the normal force g_n [N] of a gliding body, from zhat.(dv_A/dt) = 0.

    [T 3.16, 3.34, 5.6]

    It is `pull` and the free swing of the axis, divided by `contact_mobility`; s are `Scalars`. The
    vertical force of `response.sliding` under `smooth_friction` without torques is equal.
    """
    return b.m * (pull(s.z_dot, b) - b.c * s.z_ddot_free) / contact_mobility(s, b)


@formula
def drag(s, b):
    """Return -k g_n [kg/s], k being the coefficient of the law: friction is this times v_A."""
    return -(slip_coefficient(s.v2, s.z, b.friction) * g_n(s, b))


@formula
def twist(s, b):
    """Return (3hat x F).zhat of the friction [N]: L3' = R twist, Lz' = c twist. [T 3.11, 3.26]"""
    return drag(s, b) * s.v_n


@formula
def push_u(s, b):
    """Return 3hat.(dv_A/dt) [m/s^2], the acceleration of the contact point along the axis.

    [T 3.32, corrected]
    """
    h = height(s.z, b)
    turn = s.L3 / b.I3 * s.phi_dot_s2  # omega_3 phi' sin(theta)^2
    swing = turn * (b.I3 * h - b.I1 * b.R) + b.c * s.s2 * (h * g_n(s, b) - b.I1 * s.axis_speed2)
    return swing / b.I1 + drag(s, b) * s.v_u * (1 / b.m + h**2 / b.I1)


def bent_bias_n(s, b):
    """Return `bias_n` of a body with an outline: that of a sphere, and more by the bend c'(z).

    It is the part of `response.bent_bias` along zhat x 3hat; a change of one is a change of both.
    """
    turn = s.phi_dot_s2 + s.L3 / b.I3 * s.z  # omega_z
    return bias_n(s, as_ball(b)) + b.bend * (s.z_dot * s.s2 * turn)


@by_body(of_outline=bent_bias_n)
def bias_n(s, b):
    """Return the part of `push_n` that does not depend on friction [m/s^2].

    It is equal to (zhat x 3hat).`response.own_bias`.
    """
    turn = s.L3 / b.I3 * s.z_dot  # -omega_3 theta' sin(theta)
    return -(turn * (b.I3 * (b.c - b.R * s.z) + b.I1 * b.R * s.z) / b.I1)


@formula
def mobility_n(s, b):
    """Return the acceleration of A along zhat x 3hat per force in that direction [1/kg].

    It is equal to that of `response.gains`, whose docstring defines K.
    """
    return 1 / b.m + (b.c - b.R * s.z) ** 2 / b.I1 + b.R**2 * s.s2 / b.I3


@formula
def push_n(s, b):
    """Return (zhat x 3hat).(dv_A/dt) [m/s^2], the acceleration of A across the lean.

    [T 3.33]
    """
    return bias_n(s, b) + mobility_n(s, b) * twist(s, b)


@formula
def friction_loss(s, b):
    """Return the friction power per unit of normal force, k |v_A|^2 [m/s]."""
    return slip_coefficient(s.v2, s.z, b.friction) * s.v2


@formula
def friction_power(s, b):
    """Return the rate at which friction takes energy, k g_n |v_A|^2 = -E' [W]. [T 3.8]"""
    return friction_loss(s, b) * g_n(s, b)


@formula
def jellett(s, b):
    """Return Jellett's integral lambda = -L.a = R Lz - c L3 [kg m^3/s]; s are any scalars. [T 3.18]

    It is constant for any force at A.
    """
    return jellett_of(s.Lz, s.L3, b)


@formula
def jellett_of(Lz, L3, b):
    """Return Jellett's integral R Lz - c L3 [kg m^3/s] from Lz = L.zhat and L3 = L.3hat."""
    return b.R * Lz - b.c * L3


@by_body(of_frame=lambda s, b: s.rotation)
def rotation_energy(s, b):
    """Return the energy of rotation about the centre of mass, omega.L/2 [J]."""
    return (b.I1 * s.axis_speed2 + s.L3**2 / b.I3) / 2


@formula
def height_energy(z, b):
    """Return the potential energy m g (R - c z) [J]; z = cos(theta)."""
    return b.m * b.g * height(z, b)


@formula
def energy(s, b):
    """Return the energy E [J]; E' = -k g_n |v_A|^2. [T 3.7]

    s.speed2 is horizontal, and the vertical velocity is -c z'. `rows.energy` is the same of a row.
    """
    return (
        b.m * (s.speed2 + (b.c * s.z_dot) ** 2) / 2 + rotation_energy(s, b) + height_energy(s.z, b)
    )


@formula
def tip_inertia(b):
    """Return I1* = I1 + m l^2 of a heavy top (R = 0, c = -l) [kg m^2].

    It is the transverse moment of inertia about the tip.
    """
    return b.I1 + b.m * b.c**2


@formula
def arm_speed2(s, b):
    """Return |omega x a|^2 [m^2/s^2], the square of the speed of the centre in rolling.

    s are any scalars; the result is the square of `arm_velocity`, a change of which changes this.
    """
    w3 = s.L3 / b.I3
    q = b.c - b.R * s.z
    return (
        q**2 * s.axis_speed2
        + b.R**2 * (s.z_dot**2 + s.s2 * w3**2)
        + 2 * b.R * w3 * q * s.phi_dot_s2
    )


@formula
def modified_energy(s, b):
    """Return E~ = m|omega x a|^2/2 + omega.L/2 + m g s_z [J], the energy in rolling.

    [T 4.15, 5.23]
    """
    return b.m * arm_speed2(s, b) / 2 + rotation_energy(s, b) + height_energy(s.z, b)


@formula
def modified_energy_rate(push_u, push_n, s, b):
    """Return E~' = m (omega x a).(dv_A/dt) [W].

    push_u = 3hat.(dv_A/dt), push_n = (zhat x 3hat).(dv_A/dt).

    [T 4.18, 4.22]
    """
    turn = (b.c - b.R * s.z) * s.phi_dot_s2 + b.R * (s.L3 / b.I3) * s.s2
    return b.m * (height(s.z, b) * (s.z_dot * push_u) + turn * push_n) / s.s2
