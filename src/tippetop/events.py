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


def amplitudes(kind: np.ndarray, theta: np.ndarray, before: float) -> tuple[np.ndarray, float]:
    """Swing |theta - theta of the turning before| of every turning row, [rad]; `before` is the angle where the first
    swing began. Returns the column (NaN for other kinds) and the angle that the next slice continues from."""
    turning = kind == KINDS.index("turning")
    swing = np.full(theta.shape, np.nan)
    swing[turning] = np.abs(np.diff(theta[turning], prepend=before))
    return swing, float(theta[turning][-1]) if turning.any() else before
