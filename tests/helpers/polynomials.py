"""The search of the compiled loop for zeros, extremes and bounds of polynomials, called with
arrays.
"""

import ctypes
from collections.abc import Iterable

import numpy as np

from tippetop.engine.loop import Loop, Motion, library, new_motion
from tippetop.engine.stepper import Called
from tippetop.engine.tallies import (
    Rules,
    event_rows,
    new_log,
    new_tallies,
)
from tippetop.mechanics.event import Event


class Given(Called):
    """Steps with given coefficients: each has its start, its length and its coefficients."""

    def __init__(self, steps: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]):
        self.steps = iter(steps)

    def step(self, motion: Motion) -> None:
        start, h, tc = next(self.steps)
        motion.high[:], motion.start_high[:], motion.tc[:] = start, start, tc
        motion.h[:] = np.where(motion.limit > 0, h, 0.0)

    def keep(self) -> None:
        pass


def crossings(p: np.ndarray, positive: bool) -> tuple[np.ndarray, bool]:
    """Return the zeros of p on [0, 1) where it changes sign, and whether it is positive
    at the end.
    """
    zeros = np.empty(64)
    count = library().loop_crossings(_data(p), len(p), positive, _data(zeros))
    return zeros[:count], positive ^ bool(count % 2)


def extremes(p: np.ndarray, low: float, high: float) -> tuple[float, ...]:
    """Return the least and the greatest of these values and those of p on [0, 1], and where p has
    them, else NaN.
    """
    values, places = np.array([low, high]), np.empty(2)
    library().loop_extremes(_data(p), len(p), _data(values), _data(places))
    return *values.tolist(), *places.tolist()


def ranges(c: np.ndarray, shift: int, h: np.ndarray) -> np.ndarray:
    """Return low and high (2, lanes) of variables with coefficients c (order + 1, lanes)
    over steps of length h, or of their rates (shift 1).
    """
    rows = event_rows([Event("", "", lambda s, b: None)], [(0, shift, 1.0, 0.0)], [])
    motion, tallies = new_motion(1, 0, *c.shape), new_tallies(rows, np.ones((1, c.shape[1])))
    motion.end[:] = np.inf
    rules = Rules(np.inf, 1 << 62, 8, 0)
    loop = Loop(
        motion,
        rows,
        tallies,
        new_log(0, 1),
        new_log(0, 0),
        rules,
        Given([(0.0 * h, h, c[None])]),
    )
    loop.drive(1)
    return np.array([tallies.functions[name][0] for name in ("low", "high")])


def _data(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
