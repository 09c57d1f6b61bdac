"""An impact at one ball: friction followed through it in impulse space (Routh, Stronge). [contact 3.2, 3.3]

The configuration is frozen; the normal impulse pi is the time, dv = K (zhat - mu n) dpi. With dpi = w dsigma and the
horizontal slip w (cos beta e + sin beta 2hat) nothing is singular where the slip stops: w falls like an exponential.
"""

from typing import NamedTuple

from ..operand import Operand, cos, cross, exp, formula, sin, times
from .ball import arm


class ImpactRates(NamedTuple):
    """By sigma [kg]: of the direction beta and log w, of v_n, of the normal impulse and of its work."""

    beta: Operand
    log_w: Operand
    v_n: Operand
    impulse: Operand
    work_n: Operand


@formula
def impact_rates(beta, log_w, v_n, K, mu):
    """The equations of an impact that slips."""
    C, S, w = cos(beta), sin(beta), exp(log_w)
    along, across = K.ez - mu * C * K.ee, -(mu * S * K.tt)
    return ImpactRates(C * across - S * along, C * along + S * across, w * (K.zz - mu * C * K.ez), w, w * v_n)


# --- what an impulse changes ------------------------------------------------------------------------------------------


@formula
def jumps(p_e, p_2, p_z, s, z, ball):
    """What the impulse at the contact adds to theta', phi' and omega_3 [rad/s]; phi' is 0/0 at a pole. [contact 3.2]"""
    tilt = -(ball.offset * s * p_z + (ball.radius - ball.offset * z) * p_e) / ball.I1
    return tilt, (ball.offset - ball.radius * z) * p_2 / (ball.I1 * s), ball.radius * s * p_2 / ball.I3


@formula
def jumps_vector(u, p, ball):
    """What the impulse p, (3,), adds to the velocity of the centre of mass and to L: p/m and a x p."""
    return times(1 / ball.m, p), cross(arm(u, ball), p)
