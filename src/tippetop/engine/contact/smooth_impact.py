"""An impact under a friction law that is smooth in the sliding velocity: F_h = -k(|v|^2) g_n v, so dp_h = -k v dpi.

The equations of `contact.struck`, whose law has a corner at v = 0, without one. The vertical velocity v_n, which rises
all along, is the time: compression ends at v_n = 0 exactly. Steps are Picard's, on Chebyshev's nodes.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ...mechanics.contact.ball import Mobility
from ...mechanics.contact.struck import Impact


NODES, SWEEPS = 20, 40
UNRESOLVED = 4e-15  # of the largest value: the last coefficients of a step that is too long
SMALL = 4e-16  # of the largest value: a correction that is rounding
MOST_PARTS = 40  # halvings of a step
V_E, V_2, IMPULSE, WORK_N, WORK_T = range(5)


def struck_smooth(
    v_e: float, v_2: float, v_n: float, K: Mobility, k: Callable, e_n: float, restitution: str = "energetic"
) -> Impact:
    """The impact of a contact point that arrives with v_n < 0.

    Parameters
    ----------
    v_e, v_2, v_n
        Velocity of the contact point before it, along e, 2hat, zhat.
    K
        Mobility of the contact.
    k
        k(|v|^2) of the friction law, of arrays.
    e_n, restitution
        As of `contact.struck.struck`.

    Returns
    -------
    Impact
        After it, in doubles.

    Raises
    ------
    ArithmeticError
        If the law is too stiff to be followed, or jams the contact.
    """
    K, v_e, v_2, v_n = Mobility(*map(float, K)), float(v_e), float(v_2), float(v_n)

    def rates(v: np.ndarray, y: np.ndarray) -> np.ndarray:
        v_e, v_2 = y[V_E], y[V_2]
        pull = k(v_e * v_e + v_2 * v_2)
        along, sideways = pull * v_e, pull * v_2
        slopes = np.empty_like(y)
        per = slopes[IMPULSE] = 1 / (K.zz - K.ez * along)  # impulse per v_n
        slopes[V_E], slopes[V_2] = (K.ez - K.ee * along) * per, -(K.tt * sideways) * per
        slopes[WORK_N], slopes[WORK_T] = v * per, -(along * v_e + sideways * v_2) * per
        return slopes

    y = _integrated(rates, v_n, 0.0, np.array([v_e, v_2, 0.0, 0.0, 0.0]))
    compression, after = float(y[WORK_N]), 0.0
    if e_n > 0:
        field, value = {
            "energetic": (WORK_N, (1 - e_n**2) * compression),
            "poisson": (IMPULSE, (1 + e_n) * y[IMPULSE]),
            "newton": (None, 0.0),
        }[restitution]
        after, compressed = -e_n * v_n, y
        for _ in range(8):
            y = _integrated(rates, 0.0, after, compressed)
            if field is None:
                break
            change = (value - y[field]) / rates(np.array([after]), y[:, None])[field, 0]
            after += change
            if abs(change) <= 1e-15 * after:
                break
        y[field if field is not None else IMPULSE] = value if field is not None else y[IMPULSE]
    left_e, left_2, p_z, work_n, work_t = y.tolist()
    p_e, p_2 = (left_e - v_e - K.ez * p_z) / K.ee, (left_2 - v_2) / K.tt
    return Impact(p_e, p_2, p_z, left_e, left_2, float(after), work_n, work_t, compression, "slip")


@lru_cache(maxsize=1)
def _chebyshev() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chebyshev's nodes in [0, 1], and the matrices, to be multiplied from the right, that integrate from 0 to each of
    them, and give the last two coefficients."""
    x = (1 - np.cos(np.pi * np.arange(NODES) / (NODES - 1))) / 2
    basis = np.polynomial.chebyshev
    of_values = np.linalg.inv(basis.chebvander(2 * x - 1, NODES - 1))
    integrals = np.array([basis.chebval(2 * x - 1, basis.chebint(row, lbnd=-1)) / 2 for row in np.eye(NODES)]).T
    return x, np.ascontiguousarray((integrals @ of_values).T), np.ascontiguousarray(of_values.T[:, -2:])


def _sizes(values: np.ndarray, h: float) -> np.ndarray:
    """What rounding is relative to, (5, 1): velocities to the largest of them, works to the larger."""
    v_e, v_2, impulse, work_n, work_t = np.abs(values).max(axis=1).tolist()
    speed, work = max(v_e, v_2, abs(h)), max(work_n, work_t, abs(h) * impulse)
    return np.array([speed, speed, impulse, work, work])[:, None] + 1e-300


def _integrated(rates: Callable, start: float, end: float, y: np.ndarray, parts: int = 0) -> np.ndarray:
    """The state at `end`, from y at `start`. Raises ArithmeticError where it cannot be followed."""
    x, matrix, coefficients = _chebyshev()
    h = end - start
    times, first = start + h * x, y[:, None]
    slope = rates(times[:1], first)
    if not 0 < slope[IMPULSE, 0] < np.inf:
        raise ArithmeticError("friction jams the contact within an impact, or is not finite: it has no solution")
    values = first + slope * (h * x)
    sizes = _sizes(values, h)
    before: Any = np.inf
    for _ in range(SWEEPS):
        slopes = rates(times, values)
        new = first + h * (slopes @ matrix)
        change = (np.abs(new - values) / sizes).max()
        values = new
        if change <= SMALL or (change < 1e-14 and change >= before):
            last = (np.abs(values @ coefficients) / _sizes(values, h)).max()
            if last > UNRESOLVED or not slopes[IMPULSE].min() > 0:
                break
            return values[:, -1]
        if not change < 1e3 * max(before, 1e-3):
            break
        before = change
    if parts == MOST_PARTS:
        raise ArithmeticError("friction within an impact is too stiff to be followed")
    middle = start + h / 2
    return _integrated(rates, middle, end, _integrated(rates, start, middle, y, parts + 1), parts + 1)
