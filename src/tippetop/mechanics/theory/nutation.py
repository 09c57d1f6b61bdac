"""One degree of freedom: turning angles and period of E = inertia(z) theta'^2 + V(z)."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


GRID = 4001  # angles at which a band is looked for
WIDE = np.longdouble  # E - V cancels at the turning angles


class Nutation(NamedTuple):
    """Turning angles [rad] and period [s] of theta."""

    theta_min: float
    theta_max: float
    period: float


def nutation(
    inertia: Callable,
    potential: Callable,
    energy: Any,
    theta: float,
    span: tuple[float, float] = (0.0, math.pi),
) -> Nutation:
    """Return the nutation that passes theta, or starts there, by quadrature; about 14 digits.

    [T 2.38, 4.21, 5.26]

    Parameters
    ----------
    inertia
        inertia(z), the factor of theta'^2 [kg m^2]; takes arrays of z = cos(theta), long doubles.
    potential
        potential(z) [J], likewise.
    energy
        Energy of the nutation [J].
    theta
        An angle that it passes, or where it is at rest [rad].
    span
        Where theta may go [rad].

    Returns
    -------
    Nutation
        Steady motion gives equal angles and NaN as its period; a motion that leaves the span,
        infinity.
    """

    def kinetic(angle: Any) -> Any:
        z = np.cos(np.asarray(angle, dtype=WIDE))
        return (energy - potential(z)) / inertia(z)

    grid = np.linspace(*span, GRID, dtype=WIDE)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = kinetic(grid) > 0
    if not inside.any():
        return Nutation(theta, theta, math.nan)
    where = np.flatnonzero(inside)
    nearest = int(where[np.argmin(np.abs(grid[where] - theta))])
    outside = np.flatnonzero(~inside)
    below, above = outside[outside < nearest], outside[outside > nearest]
    if not len(below) or not len(above):
        return Nutation(float(span[0]), float(span[1]), math.inf)
    low = _edge(kinetic, grid[below[-1]], grid[below[-1] + 1])
    high = _edge(kinetic, grid[above[0]], grid[above[0] - 1])
    middle, half = (low + high) / 2, (high - low) / 2
    period, nodes, last = WIDE(0), 32, WIDE(np.inf)
    while (
        abs(period - last) > 1e-16 * period and nodes <= 4096
    ):  # the midpoint rule converges geometrically
        psi = (np.arange(nodes, dtype=WIDE) + WIDE(0.5)) * WIDE(np.pi) / nodes
        speed = np.sqrt(kinetic(middle - half * np.cos(psi)))
        last, period, nodes = (
            period,
            2 * np.mean(half * np.sin(psi) / speed) * WIDE(np.pi),
            2 * nodes,
        )
    return Nutation(float(low), float(high), float(period))


def _edge(kinetic: Callable, outside: Any, inside: Any) -> Any:
    """Return the zero of kinetic between an angle outside the band and one inside.

    By bisection to the last bit.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        while (middle := (outside + inside) / 2) not in (outside, inside):
            outside, inside = (outside, middle) if kinetic(middle) > 0 else (middle, inside)
    return inside
