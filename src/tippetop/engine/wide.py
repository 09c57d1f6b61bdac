"""One run in numbers wider than doubles: heyoka makes each step, and the loop follows its rounded
coefficients.

Events are found in doubles, from the same polynomials as those of a run in doubles, and their times
then refined in the working precision.
"""

import copy
from collections.abc import Sequence
from functools import cached_property
from typing import Any, cast

import heyoka as hy
import numpy as np

from .driver import Driver, Passages, Place
from .integrator import Compiled
from .loop import Motion, Rows
from .status import Status
from .stepper import Called, Stepper
from .tallies import ON_ZERO


REFINEMENTS = 3  # of a zero: each squares its error, from 1e-16
NEAR = 1e-6  # of a step: a zero that moves further is rounding's, and stays where it was
LEAST = 1e-300  # of a step, as the loop sees it: it may move no double
# of a coefficient: just before sliding stops, a step of 1e-13 has larger ones of high order
LARGEST = 1e300


class WideSteps(Called):
    """Steps whose state and time are those of heyoka's integrator; the loop gets them rounded to
    doubles.

    Whatever the loop keeps, this keeps too, in the working precision.
    """

    end: Any = None  # internal time of the end of the run
    # of the driver: samples; times of the log, and states there; rows
    samples: list
    times: list
    states: list
    rows: list

    def __init__(self, integrator: Any):
        self.integrator = copy.deepcopy(integrator)

    def step(self, motion: Motion) -> None:
        """Make a step, at most to the end of the run."""
        self.follow()
        ta = self.integrator
        self.before = ta.state.copy(), ta.dtime
        self.on_zero = self.records["tallies"].functions[ON_ZERO, :, 0].copy()
        high, low = ta.dtime
        motion.high[0] = motion.start_high[0] = start = float(high)
        motion.low[0] = motion.start_low[0] = 0.0
        outcome, _ = ta.step((self.end - high) - low, write_tc=True)
        broken = outcome == hy.taylor_outcome.err_nf_state
        motion.h[0] = np.nan if broken else max(float(ta.time) - start, LEAST)
        is_last = (
            outcome == hy.taylor_outcome.time_limit
        )  # which the loop sees from a step of the allowed length
        motion.limit[0] = motion.h[0] if is_last else np.inf
        with np.errstate(over="ignore"):
            motion.state[:, 0] = ta.state.astype(float)
            motion.tc[:, :, 0] = ta.tc
            if not np.abs(motion.tc).max() < LARGEST:
                motion.tc[:] = np.clip(motion.tc, -LARGEST, LARGEST)

    def follow(self) -> None:
        """Keep the end of the last step where the loop has: as a sample, as a row."""
        for name, kept in (("samples", self.samples), ("output", self.rows)):
            if self.records[name].filled[0] > len(kept):
                kept.append(self.integrator.state.copy())

    def undo(self) -> None:
        """Return to the start of the last step."""
        self.integrator.state[:], self.integrator.dtime = self.before

    def state_at(self, inside: np.ndarray) -> np.ndarray:
        """Keep the next zero of the log, which is refined, or else the next row, and return its
        state.
        """
        ta, log, number = self.integrator, self.records["log"], self.integrator.state.dtype.type
        if len(self.times) < log.filled[0]:
            k, start = len(self.times), self.before[1][0]
            when, event, *_ = log.rows[k]
            roots = -min(0, int(self.on_zero[event]))
            function = _function(ta.tc, self.records["rows"].events[event], roots)
            time = start + _refined(function, number(when) - start, ta.time - start)
            self.times.append(time)
            kept = self.states
        else:
            time = number(self.records["output"].times[len(self.rows)])
            kept = self.rows
        kept.append(ta.update_d_output(time).copy())
        return kept[-1].astype(float)[:, None]


class WideDriver(Driver):
    """Makes the steps of one run in numbers wider than doubles."""

    @staticmethod
    def stepper_of(code: Compiled) -> Stepper:
        return WideSteps(code.integrator)

    @cached_property
    def kept(self) -> tuple[list, list, list, list]:
        """Return the samples; times of the log, and states there; rows."""
        return [], [], [], []

    def work_in(self, place: Place) -> None:
        super().work_in(place)
        steps = self.stepper
        steps.samples, steps.times, steps.states, steps.rows = self.kept

    def take(self, place: Place, body: Sequence[Any]) -> None:
        pars = cast(WideSteps, place.stepper).integrator.pars
        pars[:] = [self.number(number) for number in body[: len(pars)]]

    @property
    def stepper(self) -> WideSteps:
        """The steps of the run."""
        return cast(WideSteps, self.place.stepper)

    def make(self, rows: Rows, most: int) -> int:
        steps = super().make(rows, most)
        if self.tally["status"] == Status.NON_FINITE.code:
            self.stepper.undo()
        else:
            self.stepper.follow()
        return steps

    def ask(self) -> None:
        super().ask()
        self.stepper.rows.clear()

    def states_of(self, rows: slice) -> np.ndarray:
        return self._wide(self.stepper.rows[rows])

    def add(self, times: np.ndarray, states: np.ndarray) -> None:
        super().add(times, states.astype(float))
        self.stepper.rows.extend(states)

    def forget(self) -> None:
        super().forget()
        for kept in self.kept[:3]:
            kept.clear()

    def _wide(self, states: list[np.ndarray]) -> np.ndarray:
        """Return states as wide as the widest phase."""
        width = self.log.states.shape[1]
        return np.array([np.resize(one, width) for one in states], self.number).reshape(-1, width)

    def sampled(self) -> np.ndarray:
        return self._wide(self.stepper.samples)

    def passages(self) -> Passages:
        times = np.array(self.stepper.times, self.number)
        return super().passages()._replace(times=times, states=self._wide(self.stepper.states))

    def drop(self) -> None:
        super().drop()
        self.stepper.times.pop()
        self.stepper.states.pop()

    def note(self, time: Any, number: int, sign: int, phase: int, state: np.ndarray) -> None:
        super().note(float(time), number, sign, phase, state.astype(float))
        self.stepper.times.append(time)
        self.stepper.states.append(state)

    def reached(self) -> tuple[Any, np.ndarray]:
        within = self.upto[0] < 1.0
        time = self.stepper.times[-1] if within else self.stepper.integrator.time
        return time, self.stepper.states[-1] if within else self.state

    @property
    def clock(self) -> tuple[Any, Any]:
        return self.stepper.integrator.dtime

    @property
    def state(self) -> np.ndarray:
        return self.stepper.integrator.state

    def put(self, state: Sequence[Any] | np.ndarray, clock: tuple[Any, Any]) -> None:
        ta = self.stepper.integrator
        ta.state[:] = 0
        ta.state[: len(state)], ta.dtime = state, clock

    def end_at(self, end: Any) -> None:
        super().end_at(end)
        self.stepper.end = end


def _function(tc: np.ndarray, event: np.void, roots: int) -> np.ndarray:
    """Return the coefficients of an event function in a step, from those of all variables,
    (variables, order + 1), without the leading `roots` coefficients.
    """
    whole = tc[event["row"]]
    if event["shift"] == 1:  # the rate of the variable
        return (whole[1:] * np.arange(1, len(whole)).astype(whole.dtype))[roots:]
    function = whole.copy()
    function[0] = function[0] + function.dtype.type(event["offset"])
    return function[roots:]


def _refined(function: np.ndarray, x: Any, length: Any) -> Any:
    """Return the zero of a polynomial near x, by Newton's rule in the precision of its
    coefficients.
    """
    descending = list(function[::-1])
    for _ in range(REFINEMENTS):
        value = slope = 0 * x
        for coefficient in descending:
            slope = slope * x + value
            value = value * x + coefficient
        if slope == 0 or not abs(value / slope) <= NEAR * length:
            break
        x = x - value / slope
    return x
