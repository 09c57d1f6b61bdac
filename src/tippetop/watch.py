"""The watch kept on every step: extremes of the normal force from the step's own Taylor polynomial."""

from typing import NamedTuple

import numpy as np


class Extremes(NamedTuple):
    """Smallest and largest value of a quantity and when, in internal units."""

    least: float = np.inf
    t_least: float = np.nan
    most: float = -np.inf
    t_most: float = np.nan

    def joined(self, other: "Extremes") -> "Extremes":
        """The extremes of both."""
        low, high = min(self[:2], other[:2]), max(self[2:], other[2:])
        return Extremes(*low, *high)


_NODES = np.linspace(0.0, 1.0, 9)  # a step holds about a radian of nutation: a dip cannot hide between nine points


def rate_extremes(times: np.ndarray, coefficients: np.ndarray) -> Extremes:
    """Extremes of the rate of a variable over a run of steps.

    times (n + 1,) are the ends of n steps, coefficients (n, order + 1) the variable's Taylor coefficients in time
    since the start of each step. The sampled extreme is refined on the polynomial of its step and of its neighbours.
    """
    times, h = np.asarray(times, float), np.diff(np.asarray(times, float))
    k = np.arange(1, coefficients.shape[1])
    rate = (
        np.asarray(coefficients, float)[:, 1:] * k * h[:, None] ** (k - 1)
    )  # polynomial of tau = (t - t_i)/h in [0, 1]
    samples = rate @ np.vander(_NODES, len(k), increasing=True).T
    found = []
    for sign in (1, -1):
        worst = int(np.argmin((sign * samples).min(axis=1)))
        candidates = [(*_least(sign * rate[i]), i) for i in range(max(0, worst - 1), min(len(h), worst + 2))]
        value, tau, i = min(candidates)
        found += [sign * value, times[i] + tau * h[i]]
    return Extremes(*found)


def _least(polynomial: np.ndarray) -> tuple[float, float]:
    """Smallest value of a polynomial (ascending coefficients) on [0, 1], and where: a fine scan, polished."""
    p = np.polynomial.Polynomial(polynomial)
    tau = np.linspace(0.0, 1.0, 65)
    best = int(np.argmin(p(tau)))
    x, slope, curvature = tau[best], p.deriv(), p.deriv(2)
    for _ in range(4):  # Newton on the slope, kept inside the step
        bend = float(curvature(x))
        if bend > 0:
            x = min(1.0, max(0.0, x - float(slope(x)) / bend))
    if float(p(x)) > float(p(tau[best])):
        x = tau[best]
    return float(p(x)), float(x)
