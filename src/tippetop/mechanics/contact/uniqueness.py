"""Up to which friction the contact of a body with one or two balls has exactly one answer.

[contact 2.6, 4.2]
"""

import math

import numpy as np


def painleve_bound(m: float, I1: float, offset: float, radius: float) -> float:
    """Return the least mu at which the normal force of slip is not defined somewhere.

    It is min K_zz/|K_ez| over theta.

    Parameters
    ----------
    m, I1
        Mass and transverse moment of inertia [kg, kg m^2].
    offset, radius
        Of the ball: from the centre of mass to its centre along the axis, of any sign, and its
        radius [m].

    Returns
    -------
    float
        Infinite where K_ez vanishes everywhere (offset = 0).

    Notes
    -----
    The ratio (I1/m + offset^2 s^2)/(|offset| s |H|) is stationary at the roots of a cubic in
    cos(theta); it is flat there, so that roots to half the digits give it to all of them.
    """
    if offset == 0:
        return math.inf
    A, alpha = (
        I1 / (m * radius**2) if radius else I1 / (m * offset**2),
        offset / radius if radius else 1.0,
    )
    rho, B = (1.0 if radius else 0.0), alpha**2
    roots = np.roots([rho * B, -alpha * (2 * A + B), rho * (A - B), alpha * (A + B)])
    z = np.clip(np.real(roots), -1, 1)
    s = np.sqrt((1 - z) * (1 + z))
    with np.errstate(divide="ignore"):
        return float(np.min((A + B * s**2) / np.abs(alpha * s * (rho - alpha * z))))
