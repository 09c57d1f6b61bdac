"""The rolling cylinder: the eccentric cylinder of `cylinder`, whose contact point is at rest.

[T 6.11]
"""

from typing import Any, NamedTuple

from ..contact import body as contact
from ..contact.body import Touch
from ..contact.gliding import catalogue as gliding
from ..contact.integrals import integral
from ..contact.orientation import planar
from ..contact.rolling import catalogue as rolling
from ..contact.rolling import reaction
from ..operand import Operand, formula
from ..system import Form, of_one_phase
from ..units import METRE, NEWTON_SECOND, ONE, RADIAN, RADIAN_PER_SECOND
from . import cylinder, outlook


class RollingState(NamedTuple):
    """sin(theta), cos(theta), theta'."""

    s: Operand
    z: Operand
    theta_dot: Operand


ROLLING_UNITS = RollingState(ONE, ONE, RADIAN_PER_SECOND)


class RollingAngles(NamedTuple):
    """theta, not wrapped, theta' and the place of the centre of mass; then the integral of the
    normal force.
    """

    theta: Operand
    theta_dot: Operand
    x: Operand
    impulse: Operand


ROLLING_ANGLES = RollingAngles(RADIAN, RADIAN_PER_SECOND, METRE, NEWTON_SECOND)


@formula
def rolling_acceleration(s, z, theta_dot, b):
    """theta'' of pure rolling [1/s^2]. [T 6.11]"""
    return -(b.m * b.c * s * (b.g + b.R * theta_dot**2)) / (b.I1 + b.m * contact.arm2(z, b))


class RollingScalars(NamedTuple):
    """What the quantities read: as where it glides, with v_A = 0, and the horizontal part of the
    reaction.
    """

    z: Operand
    s2: Operand
    z_dot: Operand
    z_ddot_free: Operand
    phi_dot_s2: Operand
    axis_speed2: Operand
    L3: Operand
    v_u: Operand
    v2: Operand
    speed2: Operand
    theta_dot: Operand
    s: Operand
    nu_x: Operand
    friction_force2: Operand


@formula
def rolling_scalars(q, b):
    """The scalars of a rolling state."""
    h, w2 = contact.height(q.z, b), q.theta_dot**2
    along = q.theta_dot * h
    Fx = b.m * (rolling_acceleration(q.s, q.z, q.theta_dot, b) * h + b.c * w2 * q.s)
    return RollingScalars(
        z=q.z,
        s2=q.s**2,
        z_dot=-(q.theta_dot * q.s),
        z_ddot_free=-(q.z * w2),
        phi_dot_s2=0,
        axis_speed2=w2,
        L3=0,
        v_u=0,
        v2=0,
        speed2=along**2,
        theta_dot=q.theta_dot,
        s=q.s,
        nu_x=0,
        friction_force2=Fx**2,
    )


@formula
def rolling_rates(q, b):
    """theta'' of pure rolling. [T 6.11]"""
    return RollingState(
        q.z * q.theta_dot, -(q.s * q.theta_dot), rolling_acceleration(q.s, q.z, q.theta_dot, b)
    )


@formula
def rolling_of_angles(e, s, z, b):
    """The rolling state of an angle record."""
    return RollingState(s, z, e.theta_dot)


@formula
def rolling_to_angles(q, carried, b):
    """The angle record of a rolling state."""
    return RollingAngles(carried.theta, q.theta_dot, carried.x, carried.impulse)


def rolling_start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> RollingAngles:
    """The angle record of the given initial values."""
    return RollingAngles(*(data.get(name, 0) for name in RollingAngles._fields))


ROLLING_FORM = Form(
    "angle",
    ROLLING_UNITS,
    rolling_rates,
    rolling_scalars,
    rolling_of_angles,
    rolling_to_angles,
    integrals=(
        integral("theta", lambda q, carried, b: q.theta_dot),
        integral("x", lambda q, carried, b: q.theta_dot * contact.height(q.z, b)),
        integral("impulse", lambda q, carried, b: reaction.normal_force(rolling_scalars(q, b), b)),
    ),
    orientation=planar(lambda q: (q.s, q.z)),
)


ROLLING_CYLINDER = of_one_phase(
    "roll",
    name="rolling-cylinder",
    title="eccentric cylinder in pure rolling",
    source=cylinder.SOURCE,
    initial=cylinder.INITIAL,
    start=rolling_start,
    angles=ROLLING_ANGLES,
    forms={"angle": ROLLING_FORM},
    quantities=(*gliding.ENERGIES, *rolling.REACTION),
    integrals=("energy",),
    events=(cylinder.TURNING, rolling.LIFTOFF, gliding.EQUATOR),
    outlook=outlook.cylinder,
    **cylinder.COMMON,
)
