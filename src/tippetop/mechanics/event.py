"""Events: zeros of functions of the state, their effect on a run, and the numbers kept of them.

Systems and phases list `Event`s; `engine` finds their zeros along a run, and keeps `Kept` numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..errors import names_its_faults
from .described import Described


NUMBERED = ("turning", "liftoff", "equator", "inverted", "settled")
"""The kinds of events that have fixed numbers in stores: their places here.

Every store lists them all.
"""

NOISE_FLOOR = 100 * np.finfo(float).eps
"""Swings of theta below this [rad] are rounding: components of 3hat carry a few units of 2.2e-16.
"""

AT_POLE = 1e-9
"""Internal time in which the axis passes a pole: where its closest approach is less than this times
its speed, z' = 0 is a passage of a planar motion through the pole, where theta = |..| has a kink,
and no turning.
"""

NEAR_POLE = 1e-6
"""Internal time within which the closest approach must be: a zero of z' known no better than 1e-7
is still it.
"""

ON_ZERO = 1e-9
"""An event function, of order one, that is smaller than this at t = 0 starts on its zero, which is
no event.
"""

ON_ZERO_FOR = 1e-6
"""Internal time in which such a function leaves its zero: one zero of it so early is that of the
start.
"""


@dataclass(frozen=True)
class Kept(metaclass=Described):
    """A number that is kept of the passages of an event, of every run and every top of an ensemble.

    Parameters
    ----------
    name : str
        Of the number in `run.summary.kept`, and of the column of an ensemble.
    what : str
        "first" or "last": the time of that passage [s], NaN without one; "count": the number of
        passages.
    long_name : str
        The meaning, in words.
    direction : int
        The passages that count: +1 rising ones, -1 falling ones, 0 all that the event detects.
    """

    name: str
    what: Literal["first", "last", "count"]
    long_name: str
    direction: int = 0


@dataclass(frozen=True)
class Event(metaclass=Described):
    """A zero of formula(scalars, b) along a run.

    Parameters
    ----------
    name : str
        The kind, as in the log and in `run.events`.
    long_name : str
        The meaning, in words.
    formula : callable
        formula(s, b), under `@formula`: `s` are the scalars of a state, `b` is the body, in units
        in which mass, length and time of the body are about 1. It must be regular: finite, with
        derivatives, wherever the run goes; and of order one: its values are neither millions nor
        millionths. None: it happens in jumps, which log it.
    direction : int
        +1: rising zeros only; -1: falling ones only; 0: all.
    ends : str, optional
        The status of a run that the event ends (unless `on_liftoff` is "continue"): liftoff,
        fallen; any other word gives `ended`. None: it does not end a run.
    sense : int
        Of the turnings of theta: +1 if the formula has the sign of theta', -1 if the opposite. 0:
        it is no turning.
    lasting : bool
        Whether a passage is significant only if the function stays beyond its zero to the end of
        the run.
    extremes : str
        The quantity that the function is, if its least and greatest values are to be reported.
    kept : tuple of Kept
        Numbers that are kept of its passages.
    sampled : bool
        Whether `formula` is a plain function of numbers, without a Taylor series, positive until it
        happens. It is evaluated in the middle and at the end of each step, so that a shorter
        passage is missed. Only an exit of a phase whose motion is slow may be sampled: the phase
        `rest` of a disc has the only one of this package.

    Notes
    -----
    Of the events of a system one may have a `sense`, one may be `lasting`, one may have `extremes`.
    A formula written with the sub-expressions of the equations of motion costs no further product.
    """

    name: str
    long_name: str
    formula: Any = None
    direction: int = 0
    ends: str | None = None
    sense: int = 0
    lasting: bool = False
    extremes: str = ""
    kept: tuple[Kept, ...] = ()
    sampled: bool = False

    def __post_init__(self) -> None:
        if callable(self.formula):
            named = names_its_faults(self.formula, f"the event `{self.name}`")
            object.__setattr__(self, "formula", named)


def zero_of(function: Callable, low: Any, *points: Any) -> Any:
    """Return the first zero of a function that is positive at `low`, by bisection.

    It is sought before the first of `points`, ascending, at which the function is not positive;
    None if it is positive at all of them. The result is the upper end of the last interval, where
    the function is not positive.
    """
    for high in points:
        if not function(high) > 0:
            while low < (middle := (low + high) / 2) < high:
                low, high = (middle, high) if function(middle) > 0 else (low, middle)
            return high
        low = high
    return None
