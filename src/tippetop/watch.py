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
    times, h, rate = _rates(times, coefficients)
    samples = rate @ np.vander(_NODES, rate.shape[1], increasing=True).T
    found = []
    for sign in (1, -1):
        lowest = (sign * samples).min(axis=1)
        near = np.flatnonzero(lowest <= lowest.min() + 0.01 * np.ptp(samples))  # a dip between nodes is shallower yet
        candidates = [(*_least(sign * rate[i]), i) for i in near[np.argsort(lowest[near])][:32]]
        value, tau, i = min(candidates)
        found += [sign * value, times[i] + tau * h[i]]
    return Extremes(*found)


def falls_below_zero(times: np.ndarray, coefficients: np.ndarray) -> float | None:
    """When the rate of a variable first falls below zero over a run of steps; None if it does not."""
    times, h, rate = _rates(times, coefficients)
    tau = np.linspace(0.0, 1.0, 65)
    negative = rate @ np.vander(tau, rate.shape[1], increasing=True).T < 0
    steps = np.flatnonzero(negative.any(axis=1))
    if not len(steps):
        return None
    step = steps[0]
    p, first = np.polynomial.Polynomial(rate[step]), int(np.argmax(negative[step]))
    low, high = tau[max(0, first - 1)], tau[first]
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (middle, high) if p(middle) > 0 else (low, middle)
    return float(times[step] + high * h[step])


def _rates(times: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Step ends, step lengths, and the rate of the variable as polynomials of tau = (t - t_i)/h in [0, 1]."""
    times = np.asarray(times, float)
    h, k = np.diff(times), np.arange(1, coefficients.shape[1])
    powers = np.repeat(h[:, None], len(k), axis=1)  # h^(k - 1) by products: np.power takes ten times as long
    powers[:, 0] = 1.0
    return times, h, np.asarray(coefficients, float)[:, 1:] * k * np.multiply.accumulate(powers, axis=1)


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
