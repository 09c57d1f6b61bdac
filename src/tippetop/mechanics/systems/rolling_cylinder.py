"""The rolling cylinder: the eccentric cylinder of `cylinder`, whose contact point is at rest.

[T 6.11]

Symbols
    b         the body, a `contact.body.Touch`
    q         a state: s = sin(theta), z = cos(theta), theta'; e: record of angles
"""

from ..contact import body as contact
from ..contact import gliding, rolling
from ..contact.body import filled
from ..contact.body_axes import by_angles
from ..contact.integrals import integral
from ..operand import formula
from ..system import Form, of_one_phase
from ..units import METRE, NEWTON_SECOND, ONE, RADIAN, RADIAN_PER_SECOND
from . import cylinder, outlook
from .tippe_top import SOURCE


ROLLING_UNITS = filled(s=ONE, z=ONE, theta_dot=RADIAN_PER_SECOND)
"""sin(theta), cos(theta), theta'."""

ROLLING_ANGLES = filled(theta=RADIAN, theta_dot=RADIAN_PER_SECOND, x=METRE, impulse=NEWTON_SECOND)
"""theta, not wrapped, theta', x of the centre of mass, the integral of the normal force."""

RollingState = type(ROLLING_UNITS)


@formula
def rolling_acceleration(s, z, theta_dot, b):
    """Return theta'' of pure rolling [1/s^2]. [T 6.11]

    `rolling.z_dot2` is equal to -(theta'' s + theta'^2 z) of it: columns use that one.
    s, z are sin(theta), cos(theta); theta_dot is theta' [rad/s].
    """
    return -(b.m * b.c * s * (b.g + b.R * theta_dot**2)) / (b.I1 + b.m * contact.arm2(z, b))


@formula
def rolling_scalars(q, b):
    """Return the `cylinder.Scalars` of a state, with v_A = 0 and the horizontal force."""
    # m x'' of x' = theta' h, with h' = c theta' s
    Fx = b.m * (
        rolling_acceleration(q.s, q.z, q.theta_dot, b) * contact.height(q.z, b)
        + b.c * q.theta_dot**2 * q.s
    )
    gliding = cylinder.scalars(cylinder.State(q.s, q.z, q.theta_dot, 0), b)
    return cylinder.Scalars(*gliding[:-1], Fx**2)  # type: ignore[call-arg]


@formula
def rolling_rates(q, b):
    """Return the rates of a state. [T 6.11]"""
    return RollingState(
        q.z * q.theta_dot, -(q.s * q.theta_dot), rolling_acceleration(q.s, q.z, q.theta_dot, b)
    )


@formula
def rolling_of_angles(e, s, z, b):
    """Return the state of angles e; s, z are sin(theta), cos(theta)."""
    return RollingState(s, z, e.theta_dot)


ROLLING_FORM = Form(
    "angle",
    ROLLING_UNITS,
    rolling_rates,
    rolling_scalars,
    rolling_of_angles,
    cylinder.to_angles(ROLLING_ANGLES),
    integrals=(
        integral("theta", lambda q, carried, b: q.theta_dot),
        integral("x", lambda q, carried, b: q.theta_dot * contact.height(q.z, b)),
        integral("impulse", lambda q, carried, b: rolling.normal_force(rolling_scalars(q, b), b)),
    ),
    orientation=by_angles(lambda q: (q.s, q.z)),
)


ROLLING_CYLINDER = of_one_phase(
    "roll",
    name="rolling-cylinder",
    title="eccentric cylinder in pure rolling",
    source=SOURCE + "6",
    initial=cylinder.INITIAL,
    angles=ROLLING_ANGLES,
    forms={"angle": ROLLING_FORM},
    quantities=(*gliding.ENERGIES, *rolling.REACTION),
    integrals=("energy",),
    events=(cylinder.TURNING, rolling.LIFTOFF, gliding.EQUATOR),
    outlook=outlook.cylinder,
    **cylinder.COMMON,
)
