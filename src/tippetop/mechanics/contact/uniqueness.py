"""Up to which friction the contact of a body with one or two balls has exactly one answer. [contact 2.6, 4.2]"""

import math

import numpy as np


def painleve_bound(m: float, I1: float, offset: float, radius: float) -> float:
    """The least mu at which the normal force of slip is not defined somewhere: min K_zz/|K_ez| over theta.

    Parameters
    ----------
    m, I1
        Mass and transverse moment of inertia [kg, kg m^2].
    offset, radius
        Of the ball: from the centre of mass to its centre along the axis, of any sign, and its radius [m].

    Returns
    -------
    float
        Infinite where K_ez vanishes everywhere (offset = 0).

    Notes
    -----
    The ratio (I1/m + offset^2 s^2)/(|offset| s |H|) is stationary at the roots of a cubic in cos(theta); it is flat
    there, so that roots to half the digits give it to all of them.
    """
    if offset == 0:
        return math.inf
    A, alpha = I1 / (m * radius**2) if radius else I1 / (m * offset**2), offset / radius if radius else 1.0
    rho, B = (1.0 if radius else 0.0), alpha**2
    roots = np.roots([rho * B, -alpha * (2 * A + B), rho * (A - B), alpha * (A + B)])
    z = np.clip(np.real(roots), -1, 1)
    s = np.sqrt((1 - z) * (1 + z))
    with np.errstate(divide="ignore"):
        return float(np.min((A + B * s**2) / np.abs(alpha * s * (rho - alpha * z))))


def both_touch_at(old: tuple[float, float], new: tuple[float, float]) -> float:
    """cos(theta) where two balls, (offset, radius) [m], touch the plane together; outside [-1, 1]: they never do.

    For a body and its stem: cos(theta_s) = -(R - r)/h.
    """
    return (old[1] - new[1]) / (old[0] - new[0])


def hand_over_bound(m: float, I1: float, old: tuple[float, float], new: tuple[float, float]) -> float:
    """The mu below which the old ball lifts off by itself whenever the new one strikes the plane. [contact 4.2]

    Parameters
    ----------
    m, I1
        Mass and transverse moment of inertia [kg, kg m^2].
    old, new
        Offset and radius of the ball in contact and of the one that arrives [m].

    Returns
    -------
    float
        Infinite where friction at the new ball never presses the old one down; 0 where the impact does so without
        friction; NaN if the two never touch the plane together.
    """
    z = both_touch_at(old, new)
    if abs(z) > 1:
        return math.nan
    s = math.sqrt((1 - z) * (1 + z))
    lever = abs((old[1] - old[0] * z) * old[0] * s)
    return max(0.0, I1 / m + old[0] * new[0] * s**2) / lever if lever else math.inf
