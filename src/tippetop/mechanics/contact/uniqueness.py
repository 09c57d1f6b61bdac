"""Up to which friction, or rolling resistance, the contact of a body has exactly one answer.

In goes a body; out comes the bound of mu or mu_r, over all its poses on a grid of theta (and psi).
`scenario.contact` compares the friction of a scenario with it.

Symbols
    b         the body, a `body.Touch` or `frame.Asymmetric`, in numbers
    K         acceleration of the contact point per normal force there [1/kg], (3,)
"""

import math
from typing import Any

import numpy as np

from ..operand import Vector
from .body import arm, by_axis
from .body_axes import axes_of_angles
from .frame import Asymmetric, Frame
from .response import gains


THETA = np.linspace(0, np.pi, 2_001)[1:-1]


def mobility(b: Any) -> tuple[Vector, Vector]:
    """Return K and the arm [m] by pose, (3,) each.

    K is the acceleration of the contact point per normal force [1/kg]; each number is an array over
    the poses of the body.
    """
    theta = THETA
    psi: Any = 0.0  # phi too: the axis lies in the x-z plane, and so the arm of a `Touch`
    if isinstance(b, Asymmetric):
        theta = THETA[::10, None]
        psi = np.linspace(-np.pi, np.pi, len(theta))
    first, u = axes_of_angles(np.sin(theta), np.cos(theta), 0 * psi, psi)
    u = Frame(*u, *first)
    b = by_axis(u, b)
    K, _ = gains(u, Vector(0.0, 0.0, 1.0), Vector(0.0, 0.0, 0.0), b)
    return K, arm(u, b)


def painleve_bound(b: Any, highest: float = math.inf) -> float:
    """Return the least mu at which the normal force of slip is not defined in some pose.

    It is min K_zz/|K_hz| over the poses that have the centre of mass not above `highest` [m]: that
    of a body with so little energy never rises above it. It is infinite where K_hz vanishes
    everywhere. `theory.eggs_and_discs` reports it as a threshold.
    """
    K, a = mobility(b)
    with np.errstate(divide="ignore"):
        bounds = K.z / np.hypot(K.x, K.y)
    return float(np.min(bounds, initial=np.inf, where=-a.z <= highest))


def most_rolling(b: Any, mu: float) -> float:
    """Return the rolling resistance that lifts a body as much as the force presses it down [m].

    Above it there is no normal force.
    """
    K, a = mobility(b)
    with np.errstate(divide="ignore"):
        return float(np.min(b.I1 * (K.z - mu * np.abs(K.x)) / np.abs(a.x)))
