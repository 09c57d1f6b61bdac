"""A cylinder under set-valued Coulomb friction: a ball whose phi', omega_3 and nu_y vanish. [contact 2.7]

theta is not wrapped: sin(theta) may be negative; sigma is the sign of nu_x. I1 is the moment about the centre of mass.
"""

from typing import NamedTuple

from ..operand import Operand, formula
from .body import height
from .coulomb import reaction_of_rolling, slip_force
from .response import bias, contact_acceleration, mobility


class Planar(NamedTuple):
    """The force at the contact [N], and what it leads to."""

    F_x: Operand
    N: Operand
    theta_dot2: Operand  # theta'' [rad/s^2]
    nu_x_dot: Operand  # nu_x' [m/s^2]


@formula
def moved(b, K, F, s, z, body):
    """The motion with the force F, Components."""
    theta_dot2 = -(body.c * s * F.z + height(z, body) * F.e) / body.I1
    return Planar(F.e, F.z, theta_dot2, contact_acceleration(b, K, F).e)


@formula
def slip(s, z, theta_dot, sigma, body):
    """The motion while the cylinder slips in the direction sigma."""
    b, K = bias(s, z, theta_dot, 0, 0, body), mobility(s, z, body)
    return moved(b, K, slip_force(b, K, sigma, 0, body), s, z, body)


@formula
def roll(s, z, theta_dot, body):
    """The motion while the cylinder rolls; nu_x' vanishes to rounding."""
    b, K = bias(s, z, theta_dot, 0, 0, body), mobility(s, z, body)
    return moved(b, K, reaction_of_rolling(b, K), s, z, body)
