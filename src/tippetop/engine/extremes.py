"""Extremes of the normal force within every step, from the step's own Taylor polynomial."""

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


_FINE = np.linspace(0.0, 1.0, 65)[:, None] ** np.arange(64)  # powers of the points of a fine scan
_NODES = np.linspace(0.0, 1.0, 9)  # a step holds about a radian of nutation: a dip cannot hide between nine points


def rate_extremes(times: np.ndarray, coefficients: np.ndarray) -> Extremes:
    """Extremes of the rate of a variable over a run of steps.

    Parameters
    ----------
    times
        (n + 1,), ends of n steps, internal.
    coefficients
        (n, order + 1), Taylor coefficients of the variable in the time since the start of each step.

    Returns
    -------
    Extremes
        Of the rate, internal units.

    Notes
    -----
    times (n + 1,) are the ends of n steps, coefficients (n, order + 1) the variable's Taylor coefficients in time
    since the start of each step. The sampled extreme is refined on the polynomial of its step and of its neighbours.
    """
    times, h, rate = _rates(times, coefficients)
    finite = np.isfinite(rate).all(axis=1)  # wider numbers can overflow a double where steps shrink to nothing
    if not finite.all():
        times, h, rate = times[:-1][finite], h[finite], rate[finite]
    if not len(rate):
        return Extremes()
    samples = rate @ np.vander(_NODES, rate.shape[1], increasing=True).T
    extremes = []
    for sign in (1, -1):
        lowest = (sign * samples).min(axis=1)
        near = np.flatnonzero(lowest <= lowest.min() + 0.01 * np.ptp(samples))  # a dip between nodes is shallower yet
        near = near[np.argsort(lowest[near])][:32]
        values, tau = _least(sign * rate[near])
        best = np.argmin(values)
        extremes += [sign * float(values[best]), float(times[near[best]] + tau[best] * h[near[best]])]
    return Extremes(*extremes)


def falls_below_zero(times: np.ndarray, coefficients: np.ndarray) -> float | None:
    """When the rate of a variable first falls below zero over a run of steps; None if it does not.

    Parameters
    ----------
    times, coefficients
        As for `rate_extremes`.

    Returns
    -------
    float or None
        Internal time, bisected to neighbouring numbers.
    """
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
    with np.errstate(over="ignore", invalid="ignore"):
        return times, h, np.asarray(coefficients, float)[:, 1:] * k * np.multiply.accumulate(powers, axis=1)


def _least(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest values of polynomials (n, order + 1), ascending, on [0, 1], and where: a fine scan, polished."""
    derive = np.polynomial.polynomial.polyder
    values = p @ _FINE[:, : p.shape[1]].T
    best = np.argmin(values, axis=1)
    lowest, x, slope, curvature = values.min(axis=1), best / (len(_FINE) - 1), derive(p, axis=1), derive(p, 2, axis=1)
    scanned = x
    for _ in range(4):  # Newton on the slope, kept inside the step
        bend = _each(curvature, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            x = np.where(bend > 0, np.clip(x - _each(slope, x) / bend, 0.0, 1.0), x)
    polished = _each(p, x)
    return np.minimum(polished, lowest), np.where(polished <= lowest, x, scanned)


def _each(p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The value of every polynomial (n, order + 1) at its own x (n,)."""
    return np.polynomial.polynomial.polyval(x, p.T, tensor=False)
