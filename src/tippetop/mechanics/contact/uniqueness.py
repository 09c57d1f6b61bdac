"""Up to which friction the contact of a body has exactly one answer. [contact 2.6, 4.2]"""

from typing import Any

import numpy as np

from ..operand import Vector
from .body_axes import axes_of_angles
from .frame import Asymmetric, Frame, height
from .response import gains


THETA = np.linspace(0, np.pi, 10_001)[1:-1]
SINE, COSINE = np.sin(THETA), np.cos(THETA)


def levers(offset: Any, radius: Any) -> tuple[Any, Any]:
    """Return the levers of vertical and horizontal forces on a ball [m], over theta."""
    return np.abs(offset * SINE), np.abs(radius - offset * COSINE)


def painleve_bound(m: float, I1: float, offset: Any, radius: Any) -> float:
    """Return the least mu at which the normal force of slip is not defined somewhere.

    It is min K_zz/|K_ez| over theta, which is flat there.

    Parameters
    ----------
    m, I1
        Mass and transverse moment of inertia [kg, kg m^2].
    offset, radius
        Of the ball: from the centre of mass to its centre along the axis, of any sign, and its
        radius [m]; numbers, or arrays over THETA.

    Returns
    -------
    float
        Infinite where K_ez vanishes everywhere (offset = 0).
    """
    lever, height = levers(offset, radius)
    with np.errstate(divide="ignore"):
        return float(np.min((I1 / m + lever**2) / (lever * height)))


def painleve_bound_of_frame(b: Asymmetric, highest: float) -> float:
    """Return the least mu at which the normal force of slip is not defined in some pose.

    It is min K_zz/|K_hz| over the poses that have the centre of mass not above `highest`: that of a
    body with so little energy never rises above it.
    """
    theta = THETA[::50, None]
    psi = np.linspace(-np.pi, np.pi, len(theta))
    first, third = axes_of_angles(np.sin(theta), np.cos(theta), 0 * psi, psi)
    u = Frame(*third, *first)
    up = Vector(0.0, 0.0, 1.0)
    K, _ = gains(u, up, Vector(0.0, 0.0, 0.0), b)
    with np.errstate(divide="ignore"):
        bounds = K.z / np.hypot(K.x, K.y)
    return float(np.min(bounds, initial=np.inf, where=height(u, b) <= highest))


def most_rolling(m: float, I1: float, offset: Any, radius: Any, mu: float) -> float:
    """Return the rolling resistance that lifts a body as much as the force presses it down [m].

    Above it there is no normal force. The parameters are those of `painleve_bound`.
    """
    lever, height = levers(offset, radius)
    with np.errstate(divide="ignore"):
        return float(np.min((I1 / m + lever * (lever - mu * height)) / lever))
