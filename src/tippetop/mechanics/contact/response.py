"""The response of a contact to forces and impulses, and the force of a contact that slides or
sticks.

In go the motion, a force or the acceleration that the contact point would have without one; out
come accelerations and velocities, or the force and torque that a law requires. `contact_phases`
makes the equations of motion of these functions, `exits` and `impact_motion` the jumps. Everything
is singular only where the contact jams (Painleve: K_zz - mu n_e K_ez = 0, which
`uniqueness.painleve_bound` excludes).

Of a disc at rest neither v_A nor Omega_z changes: a force F and a torque tau zhat see to that. With
k = I^-1 zhat, t = k x a and k_zz = k.zhat, tau is eliminated, and F is that of sticking with K - t
t/k_zz instead of K. Friction gives every (|F_h|/(mu N), |tau|/(mu N patch)) within the curve (f(x),
m(x)), and no other.

Symbols
    b         the body, a `Touch` or `Asymmetric`; b.friction: record of its law, with mu and patch
    x         the motion, a `Turning` or `Moving`; but x in K^-1 x is a vector (3,)
    u, 3hat   unit vector of the axis, or a Frame; L: angular momentum about the centre of mass
    a         the arm, from the centre of mass to the contact point A; v, v_A: velocity of A
    omega     angular velocity, Omega_z its vertical part; I: tensor of inertia
    K         acceleration of A per force there, or velocity per impulse [1/kg], (3, 3)
    F, N      force of the plane at A, (3,) [N]; its normal part; p, twist: impulses of F and torque
"""

import math
from typing import Any

from ..disc_friction import drag, rolling
from ..dual import Line, plain
from ..friction import load
from ..operand import (
    Vector,
    asin,
    cross,
    dot,
    formula,
    hypot,
    minus,
    plus,
    select,
    sin,
    sqrt,
    times,
)
from . import frame
from .body import (
    Moving,
    Touch,
    Turning,
    angular_velocity,
    arm,
    arm2,
    as_ball,
    axis_rate,
    by_body,
    gained,
    momentum_of,
    velocities,
)
from .frame import Asymmetric
from .surroundings import braking, mean_gravity, pushing, table_torque


@formula
def gains(u, F, torque, b):
    """Return what a force F at the contact and a torque add to dv_A/dt and to omega', (3,) each.

    They are K F + (I^-1 torque) x a [m/s^2], with K F = F/m + (I^-1 (a x F)) x a, and I^-1 (a x F +
    torque) [rad/s^2]. Impulses add to the velocities likewise.
    """
    turns = angular_velocity(Turning(u, plus(cross(arm(u, b), F), torque)), b)
    return plus(times(1 / b.m, F), cross(turns, arm(u, b))), turns


@by_body(of_outline=lambda u, b: dot(arm(u, b), arm(u, b)))
def arm_square(u, b):
    """Return |a|^2 [m^2]."""
    return arm2(u.z, b)


@by_body(of_frame=frame.mobility_inverse_times)
def mobility_inverse_times(u, x, b):
    """Return K^-1 x, (3,): the force that gives the contact point the acceleration x.

    It is also the impulse that gives it the velocity x.
    """
    return inverse_times(u, x, b, 0)


@formula
def inverse_times(u, x, b, less):
    """Return K^-1 x of a ball, (3,), with K = kappa - a a/I1 + excess k k, k = zhat x 3hat.

    K is that of `gains`. A torque about the vertical, as on a disc at rest, makes the excess
    smaller by `less`, the third result of `turn_held`.
    """
    excess = b.R**2 * (1 / b.I3 - 1 / b.I1) - less
    a = arm(u, b)
    kappa = 1 / b.m + arm_square(u, b) / b.I1
    across = u.x * x.y - u.y * x.x  # k.x
    along_k = -(excess * across) / (kappa + excess * (u.x * u.x + u.y * u.y))
    along_a = b.m * dot(a, x) / b.I1
    return Vector(
        (x.x + along_a * a.x - along_k * u.y) / kappa,
        (x.y + along_a * a.y + along_k * u.x) / kappa,
        (x.z + along_a * a.z) / kappa,
    )


def bent_bias(x, b):
    """Return `own_bias` of a body with an outline, which adds omega x (c' z' (3hat - z zhat))."""
    bends = b.bend * axis_rate(x, b).z
    moves = Vector(bends * x.u.x, bends * x.u.y, 0 * bends)
    return plus(own_bias(x, as_ball(b)), cross(angular_velocity(x, b), moves))


@by_body(of_outline=bent_bias, of_frame=frame.bias_vector)
def own_bias(x, b):
    """Return `bias_vector` on a level plane in still air, (3,) [m/s^2]."""
    u_dot = axis_rate(x, b)
    free = times(b.c / b.I1, cross(x.L, u_dot))
    spin = b.R * (1 / b.I3 - 1 / b.I1) * dot(x.L, x.u)
    return Vector(free.x - spin * u_dot.y, free.y + spin * u_dot.x, free.z - b.g)


def surrounded_bias(x, b):
    """Return the acceleration of A without a force there, in surroundings, (3,) [m/s^2].

    x is a `Moving` on a turntable; elsewhere a `Turning` is enough.
    """
    bias = own_bias(x, b)
    none = times(0, bias)
    by_torque, _ = gains(x.u, none, around_torque(x, b), b)
    return plus(plus(bias, by_torque), pushing(getattr(x, "velocity", none), none.z, b))


bias_vector = select(lambda b: surrounded_bias if b.around else own_bias)
"""bias_vector(x, b) -> (3,) [m/s^2]: how the contact point accelerates without a force there.

It is c 3hat'' - R (1/I3 - 1/I1) L_3 3hat' x zhat - g zhat, 3hat'' = L x 3hat'/I1, and more if the
ball changes.
"""


def around_torque(x, b):
    """Return the torque of air and turntable on a body, (3,) [N m]; zero without surroundings."""
    if not b.around:
        return times(0, x.L)
    omega = angular_velocity(x, b)
    torque = braking(omega, b)
    if not b.around.table:
        return torque
    return plus(torque, table_torque(omega, x.L, lambda omega: momentum_of(omega, x.u, b), b))


def surroundings_power(x, b):
    """Return the power that the surroundings take from a moving body [W]; x is a `Moving`."""
    if not b.around:
        return 0 * x.height
    omega = angular_velocity(x, b)
    push = pushing(x.velocity, 0 * omega.z, b)
    rises = (b.g - mean_gravity(b)) * x.velocity.z if b.around.shake else 0 * omega.z
    return b.m * (rises - dot(push, x.velocity)) - dot(around_torque(x, b), omega)


@formula
def contact_acceleration(x, F, torque, b):
    """Return dv_A/dt under a force F at the contact and a torque, (3,) [m/s^2]."""
    by_force, _ = gains(x.u, F, torque, b)
    return plus(bias_vector(x, b), by_force)


@formula
def work_of(x, p, twist, b):
    """Return the energy [J] that the impulses p [N s] and twist [N m s] give a body."""
    speeds = zip(velocities(x, b), gains(x.u, p, twist, b), strict=True)
    v, omega = (plus(times(2, before), more) for before, more in speeds)  # before + after
    return (dot(p, v) + dot(twist, omega)) / 2


def kicked(x: Moving, b: Touch, p: Vector, twist: Vector) -> Moving:
    """Return the state x after the impulses p [N s] and twist [N m s] at the contact, (3,) each.

    Its integrals of work, impulse and Jellett's integral are changed too.
    """
    after = x._replace(
        L=plus(plus(x.L, cross(arm(x.u, b), p)), twist),
        velocity=plus(x.velocity, times(1 / b.m, p)),
    )
    lost = dot(twist, arm(x.u, b))
    return gained(after, work=-work_of(x, p, twist, b), impulse=p.z, jellett_lost=lost)


# --- sliding ------------------------------------------------------------------------------------


def sliding(x, friction, v, b):
    """Return the force and torque (3,) on a body that slides with the horizontal velocity v.

    friction(omega, v, z, b) gives them per normal force, the vertical part of its force being 1;
    the normal force follows from dv_A/dt.zhat = 0. Under Coulomb's law itself v may be of length 1.
    """
    force, torque = friction(angular_velocity(x, b), v, x.u.z, b)
    by_force, _ = gains(x.u, force, torque, b)
    N = -bias_vector(x, b).z / by_force.z
    return times(N, force), times(N, torque)


@formula
def across_and_along(G, n):
    """Return Q = (zhat x n).G, w times the turn of n in space, and P = n.G.

    P is the rate of the slip speed w; G is a Vector [m/s^2].
    """
    return n.x * G.y - n.y * G.x, n.x * G.x + n.y * G.y


# --- a contact at rest, of a point or of a disc -------------------------------------------------


def turn_held(u, b):
    """Return the effect of the torque that keeps Omega_z: t, 1/k_zz, t^2/(k_zz |zhat x 3hat|^2).

    The third is the `less` of `inverse_times`; u is a Vector, b a `Touch` of a body of revolution.
    t is the acceleration of the contact point per torque, along zhat x 3hat, and Omega_z' per
    force; k_zz is Omega_z' per torque, regular at the poles. `exits.at_rest` reads the second.
    """
    more = 1 / b.I3 - 1 / b.I1
    per = 1 / ((u.x * u.x + u.y * u.y) / b.I1 + u.z * u.z / b.I3)
    lever = b.c / b.I1 + b.R * u.z * more
    return Vector(-(lever * u.y), lever * u.x, 0 * u.z), per, lever**2 * per


def impulses(u, v, Omega_z, b):
    """Return the impulses of force and torque (3,) that add v to v_A, and Omega_z to a disc.

    A law without regions has a point as its contact, of which Omega_z is ignored.
    """
    if not b.friction.regions:  # a point, which turns freely
        return mobility_inverse_times(u, v, b), times(0, v)
    along, per, less = turn_held(u, b)
    p = inverse_times(u, plus(v, times(-(Omega_z * per), along)), b, less)
    return p, Vector(0 * p.z, 0 * p.z, (Omega_z - dot(p, along)) * per)


def stopping(x, b):
    """Return the impulses of force and torque that stop the contact point, and a disc's turning.

    They are the last two arguments of `kicked`.
    """
    v, omega = velocities(x, b)
    return impulses(x.u, times(-1, v), -omega.z, b)


@formula
def held_reaction(x, b):
    """Return `reaction` by the acceleration without a force."""
    return times(-1, mobility_inverse_times(x.u, bias_vector(x, b), b))


reaction = select(
    lambda b: frame.reaction if isinstance(b, Asymmetric) and not b.around else held_reaction
)
"""reaction(x, b) -> the force of the plane on a body that rolls, (3,) [N]."""


def own_turn(x, b):
    """Return Omega_z' [rad/s^2] of a body with an axis of symmetry on which no torque acts.

    x is a `Turning` or `Moving`.
    """
    return (1 / b.I3 - 1 / b.I1) * dot(x.L, x.u) * axis_rate(x, b).z


def resting(x, b):
    """Return the force [N] and torque [N m] of the plane, (3,), that keep the contact at rest.

    The caller compares them with `margin` or `cone`: friction may not be able to give them.
    """
    if b.friction.torque is None:
        F = reaction(x, b)
        return F, times(0, F)
    bias = bias_vector(x, b)
    free = own_turn(x, b)
    _, turns = gains(x.u, times(0, bias), around_torque(x, b), b)
    return held(x.u, bias, free + turns.z, angular_velocity(x, b), b)


def held(u, bias, free, omega, b):
    """Return the force [N] and torque [N m], (3,), that keep a contact at rest in rolling.

    omega is the angular velocity, (3,). Without them, the acceleration of the contact point would
    be `bias`, (3,) [m/s^2], and Omega_z' = `free` [rad/s^2]. `impact_motion` calls it too, with a
    unit of bias.
    """
    rolls = (rolling if b.friction.regions else load)(omega, b.friction)
    by_load, turns = gains(u, times(0, rolls), rolls, b)
    F, torque = impulses(u, bias, free, b)
    more, twist = impulses(u, by_load, turns.z, b)
    # rolling adds in proportion to N: the force is -(F + N more), of which N is the vertical part
    N = -F.z / (1 + more.z)
    torque = minus(times(N, minus(rolls, twist)), torque)
    return times(-1, plus(F, times(N, more))), torque


@formula
def cone(F, body):
    """Return mu^2 N^2 - |F_h|^2 [N^2], the function of `slip`: zero where rolling ends."""
    return (body.friction.mu * F.z) ** 2 - F.x * F.x - F.y * F.y


HALVINGS = 60  # of the interval in which x/(1 + x) lies, x = |v_A|/U


def sliding_at(force: Any) -> Any:
    """Return x = |v_A|/U of a disc at which friction gives |F_h|/(mu N) = force, a number below 1.

    U is the speed of the disc's edge; the inverse of the law's f(x).
    """
    if force <= INSIDE:  # x - x^3/4 = 8 force/(3 pi)
        return 4 / math.sqrt(3) * sin(asin(2 * math.sqrt(3) / math.pi * force) / 3)

    def beyond(x: Any, force: Any) -> Any:
        """Return f(x) - force at x = |v_A|/U, whose zero is sought."""
        return drag(x * x, 1.0).k * x - force  # U = 1: k = f(x)/|v_A| = f(x)/x

    known = plain(force)
    low = 0.5
    high = 1.0
    for _ in range(HALVINGS):  # x/(1 + x)
        share = (low + high) / 2
        low, high = (share, high) if beyond(share / (1 - share), known) < 0 else (low, share)
    x = low / (1 - low)
    if force is known:
        return x
    # a step of Newton: first derivatives are those of the zero, by the implicit function theorem
    return x - beyond(x, force) / beyond(Line(x, 1.0), known).first


INSIDE = drag(1.0, 1.0).k  # |F_h|/(mu N) at x = 1


def margin(force: Any, torque: Any, law: Any) -> Any:
    """Return how much more friction could bear than a contact at rest needs; negative: too little.

    Of a point it is a force, mu N less the horizontal one. Of a disc it is a torque about the
    vertical per mu N patch, while friction also bears the force; -1 if nothing presses. Its
    sign decides; the event `gives` needs its zero, and `exits.at_rest` its size.

    Parameters
    ----------
    force
        On the contact, (3,).
    torque
        About the vertical.
    law
        The record of the law.
    """
    if not law.regions:
        return law.mu * force.z - sqrt(force.x * force.x + force.y * force.y)
    limit = law.mu * force.z
    if not limit > 0:
        return -1.0
    push = hypot(force.x, force.y) / limit
    turn = max(abs(torque) - getattr(law, "mu_d", 0.0) * force.z, 0.0) / (limit * law.patch)
    if not push < 1:
        return 1 - push - turn
    return drag(sliding_at(push) ** 2, 1.0).twist - turn


MOST = 1 - 2.0**-40  # |F_h|/(mu N) of a disc that hardly turns


def direction(force: Any, torque: Any, law: Any) -> tuple[Vector, Any]:
    """Return the direction in which a contact slides under the most that friction can bear.

    It is v_A and the velocity of the disc's edge, together of length 1; they belong to the bound in
    `margin`, whose arguments these are.
    """
    if not law.regions:
        push = force._replace(z=0 * force.z)
        return times(-1 / sqrt(dot(push, push)), push), push.z
    push = hypot(force.x, force.y)
    x = sliding_at(min(push / (law.mu * force.z), MOST))
    length = hypot(x, 1.0)
    along = -x / (length * push) if push else 0.0
    edge = (-1 if torque > 0 else 1) / length if torque else 0.0
    return Vector(along * force.x, along * force.y, 0 * force.z), edge
