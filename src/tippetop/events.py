"""The event log: raw zeros from the integrator become rows with angle, sign, amplitude and significance."""

from typing import Any, NamedTuple

import numpy as np


KINDS = ("turning", "liftoff", "equator", "inverted", "settled")
NOISE_FLOOR = 100 * np.finfo(float).eps
"""Swings of theta below this [rad] are rounding: components of 3hat carry a few units of 2.2e-16."""


class Zero(NamedTuple):
    """A zero of an event function: internal time, kind, and the sign of the crossing."""

    time: Any
    kind: str
    sign: int


class EventTable(NamedTuple):
    """Columns of the log, one row per event, ascending in time."""

    time: np.ndarray  # [s]
    kind: np.ndarray  # index into KINDS, int8
    theta: np.ndarray  # [rad]
    theta_dot_sign: np.ndarray  # of theta' just after the event: +1 at a minimum of theta, -1 at a maximum; int8
    amplitude: np.ndarray  # swing |theta - theta of the turning before| [rad]; NaN for other kinds
    significant: np.ndarray  # False where rounding could have made the event; bool

    @classmethod
    def empty(cls) -> "EventTable":
        """A log without rows."""
        return cls(*(np.zeros(0, dtype) for dtype in (float, np.int8, float, np.int8, float, bool)))

    @classmethod
    def joined(cls, tables: list["EventTable"]) -> "EventTable":
        """One log of several, in order."""
        return cls(*map(np.concatenate, zip(*tables, strict=True))) if tables else cls.empty()

    def logged(self, kinds: tuple[str, ...]) -> "EventTable":
        """The rows of the kinds that a person asked for."""
        keep = np.isin(self.kind, [KINDS.index(kind) for kind in kinds])
        return EventTable(*(column[keep] for column in self))

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """The rows of one kind; only the significant ones, if asked."""
        keep = self.kind == KINDS.index(kind)
        return EventTable(*(column[keep & self.significant] if significant else column[keep] for column in self))


def amplitudes(theta: np.ndarray, turning: np.ndarray, start: float) -> np.ndarray:
    """Swing |theta - theta of the turning before| of every turning [rad], the first since the start; NaN elsewhere."""
    swing = np.full(theta.shape, np.nan)
    swing[turning] = np.abs(np.diff(theta[turning], prepend=start))
    return swing


def significance(theta: np.ndarray, sign: np.ndarray, end: float, floor: float = NOISE_FLOOR) -> np.ndarray:
    """Which turnings of theta (sign +1 minima, -1 maxima, in order) are more than rounding, bool.

    Hysteresis: the extreme of a stretch counts once theta has come back from it by `floor`, whatever small wiggles lie
    between. So a true turning that rounding splits into three counts once, and a decay that ends in noise not at all.
    `end` is theta at the end of the run.
    """
    found = np.zeros(len(theta), dtype=bool)
    swings = np.abs(np.diff(theta, append=end))
    if np.all(swings >= floor):
        return ~found
    candidate = -1
    for i, (angle, way) in enumerate(zip(theta.tolist(), sign.tolist(), strict=True)):
        if candidate >= 0 and sign[candidate] * (angle - theta[candidate]) >= floor:
            found[candidate] = True
            candidate = i
        elif candidate < 0 or (way == sign[candidate] and way * (angle - theta[candidate]) < 0):
            candidate = i
    if candidate >= 0 and sign[candidate] * (end - theta[candidate]) >= floor:
        found[candidate] = True
    return found
