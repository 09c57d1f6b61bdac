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
        pull = np.broadcast_to(np.asarray(k(y[V_E] ** 2 + y[V_2] ** 2), float), v.shape)
        along, sideways = pull * y[V_E], pull * y[V_2]
        per = 1 / (K.zz - K.ez * along)  # impulse per v_n
        slid = along * y[V_E] + sideways * y[V_2]
        return np.array([(K.ez - K.ee * along) * per, -(K.tt * sideways) * per, per, v * per, -slid * per])

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
    p_z = float(y[IMPULSE])
    p_e, p_2 = (y[V_E] - v_e - K.ez * p_z) / K.ee, (y[V_2] - v_2) / K.tt
    return Impact(p_e, p_2, p_z, y[V_E], y[V_2], after, float(y[WORK_N]), float(y[WORK_T]), compression, "slip")


@lru_cache(maxsize=1)
def _chebyshev() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chebyshev's nodes in [0, 1], and the matrices that integrate from 0 to each of them, and give coefficients."""
    x = (1 - np.cos(np.pi * np.arange(NODES) / (NODES - 1))) / 2
    basis = np.polynomial.chebyshev
    of_values = np.linalg.inv(basis.chebvander(2 * x - 1, NODES - 1))
    integrals = np.array([basis.chebval(2 * x - 1, basis.chebint(row, lbnd=-1)) / 2 for row in np.eye(NODES)]).T
    return x, integrals @ of_values, of_values


def _sizes(values: np.ndarray, h: float) -> np.ndarray:
    """What rounding is relative to, (5, 1): velocities to the largest of them, works to the larger."""
    largest = np.max(np.abs(values), axis=1)
    speed, work = (
        max(largest[V_E], largest[V_2], abs(h)),
        max(largest[WORK_N], largest[WORK_T], abs(h) * largest[IMPULSE]),
    )
    return np.array([speed, speed, largest[IMPULSE], work, work])[:, None] + 1e-300


def _integrated(rates: Callable, start: float, end: float, y: np.ndarray, parts: int = 0) -> np.ndarray:
    """The state at `end`, from y at `start`. Raises ArithmeticError where it cannot be followed."""
    x, matrix, coefficients = _chebyshev()
    h = end - start
    times, values = start + h * x, np.repeat(y[:, None], NODES, axis=1)
    before: Any = np.inf
    if not 0 < rates(times[:1], y[:, None])[IMPULSE, 0] < np.inf:
        raise ArithmeticError("friction jams the contact within an impact, or is not finite: it has no solution")
    for _ in range(SWEEPS):
        slopes = rates(times, values)
        new = y[:, None] + h * (slopes @ matrix.T)
        change = np.max(np.abs(new - values) / _sizes(new, h))
        values = new
        if change <= SMALL or (change < 1e-14 and change >= before):
            last = np.max(np.abs(values @ coefficients.T[:, -2:]) / _sizes(values, h))
            if last > UNRESOLVED or not np.all(slopes[IMPULSE] > 0):
                break
            return values[:, -1]
        if not change < 1e3 * max(before, 1e-3):
            break
        before = change
    if parts == MOST_PARTS:
        raise ArithmeticError("friction within an impact is too stiff to be followed")
    middle = start + h / 2
    return _integrated(rates, middle, end, _integrated(rates, start, middle, y, parts + 1), parts + 1)
