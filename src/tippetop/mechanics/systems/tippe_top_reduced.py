"""The rolling tippe top reduced by its integrals: the form `reduced`, in which z moves only.

Singular at the poles, like Euler angles. Rounding reaches the energy through z and z' alone: over
very long runs it drifts less than in vector form, in which every component of L is rounded at every
step.

Symbols
    b         the body, a `contact.body.Touch`
    q         a state of the form: z = cos(theta), z', D, lambda (`lam`); carried: its integrals
    e         record of angles and rates; s in (e, s, z, b): sin(theta)
    D         Routh's function; lambda: Jellett's integral; L3, Lz: L.3hat, L.zhat
"""

import math
from typing import Any

from ..contact import body as contact
from ..contact import rolling
from ..contact.body import filled
from ..contact.body_axes import by_angles
from ..contact.gliding import AWAY_FROM_POLE, angles_by
from ..contact.integrals import integral, place
from ..operand import atan2, cos, formula, sin, sqrt
from ..system import Form
from ..theory.spinning import d
from ..units import ANGULAR_MOMENTUM, JELLETT, ONE, PER_SECOND
from . import tippe_top


LENGTH_UNIT = math.pi / 3
"""The unit of length, per R.

With R itself the parameters are often simple fractions (alpha = 3/10, I3 = 2/5), by which products
do not round evenly: in very long runs the energy then drifts linearly, instead of walking at
random.
"""


REDUCED_UNITS = filled(z=ONE, z_dot=PER_SECOND, D=ANGULAR_MOMENTUM, lam=JELLETT)
"""z = cos(theta), z', Routh's function D, Jellett's integral lambda."""

ReducedState = type(REDUCED_UNITS)


@formula
def spin_momentum(z, D, b):
    """Return L_3 = D/sqrt(d(z)) [kg m^2/s]. [T 4.7]"""
    return D / sqrt(d(z, b))


@formula
def reduced_kinematics(q, b):
    """Return the `Kinematics` of a state, 0/0 at a pole; elsewhere as `body.kinematics`."""
    z = q.z
    s2 = (1 - q.z) * (1 + q.z)
    L3 = spin_momentum(z, q.D, b)
    Lz = (q.lam + b.c * L3) / b.R  # `body.jellett_of`, solved for Lz
    phi_dot_s2 = (Lz - L3 * z) / b.I1
    axis_speed2 = (q.z_dot * q.z_dot + phi_dot_s2 * phi_dot_s2) / s2
    z_ddot_free = contact.torque_free(L3, phi_dot_s2, axis_speed2, z, b)
    return contact.Kinematics(z, s2, q.z_dot, z_ddot_free, phi_dot_s2, axis_speed2, L3, Lz)


@formula
def reduced_scalars(q, b):
    """Return the scalars of a state, `rolling.Scalars`."""
    return rolling.scalars_by_kinematics(reduced_kinematics(q, b), b)


@formula
def reduced_rates(q, b):
    """Return the rates of a state: z'' of the rolling top; D and lambda stay. [T 4.2, 4.8]"""
    return ReducedState(q.z_dot, rolling.z_dot2(reduced_kinematics(q, b), b), 0 * q.D, 0 * q.lam)


@formula
def phi_rate(q, carried, b):
    """Return phi' [rad/s], the rate of the integral phi."""
    s = reduced_kinematics(q, b)
    return s.phi_dot_s2 / s.s2


@formula
def psi_rate(q, carried, b):
    """Return psi' = omega_3 - phi' cos(theta) [rad/s], the rate of the integral psi."""
    s = reduced_kinematics(q, b)
    return s.L3 / b.I3 - s.phi_dot_s2 / s.s2 * q.z


@formula
def sine_and_cosine(q):
    """Return sin(theta), cos(theta) of a state q."""
    return sqrt((1 - q.z) * (1 + q.z)), q.z


@formula
def velocity(q, carried, b):
    """Return x', y' of the centre of mass [m/s], the rates of these integrals."""
    s = reduced_kinematics(q, b)
    sine = sqrt(s.s2)
    # theta, here 0, is not read
    e = rolling.EulerState(0, -(q.z_dot / sine), s.phi_dot_s2 / s.s2, s.L3 / b.I3)
    along_e, along_2 = contact.rolling_velocity(e, sine, q.z, b)
    return contact.of_azimuth(along_e, along_2, carried.phi)


@formula
def reduced_of_angles(e, s, z, b):
    """Return the state of angles e: `of_angles` of the form; s, z are sin(theta), cos(theta)."""
    c = rolling.euler_scalars(e, b)
    return ReducedState(z, -(e.theta_dot * s), tippe_top.routh(c, b), contact.jellett(c, b))


def azimuth(q: Any, carried: Any) -> Any:
    """Return phi in (-pi, pi] [rad], from the integral phi: `azimuth` of `angles_by`."""
    return atan2(sin(carried.phi), cos(carried.phi))


REDUCED = Form(
    "reduced",
    REDUCED_UNITS,
    reduced_rates,
    reduced_scalars,
    reduced_of_angles,
    angles_by(rolling.ANGLES, reduced_kinematics, azimuth),
    integrals=(
        integral("phi", phi_rate),
        *place(velocity),
        integral(
            "impulse", lambda q, carried, b: rolling.normal_force(reduced_kinematics(q, b), b)
        ),
    ),
    orientation=by_angles(sine_and_cosine, psi_rate),
    domains=(AWAY_FROM_POLE,),
    length_unit=LENGTH_UNIT,
    not_normalised=("R",),
)
