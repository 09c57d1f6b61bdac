"""One run in numbers wider than doubles: heyoka makes each step, and the loop follows its rounded coefficients.

Events are found in doubles, from the same polynomials as those of a run in doubles, and their times then refined in the
working precision.
"""

import copy
from collections.abc import Sequence
from typing import Any, cast

import heyoka as hy
import numpy as np

from .driver import NO_ROWS, Driver, Passages, Request
from .loop import PATIENCE, Motion
from .status import Status
from .stepper import Called, Stepper
from .tallies import ON_ZERO


REFINEMENTS = 3  # of a zero: each squares its error, from 1e-16
NEAR = 1e-6  # of a step: a zero that moves further is rounding's, and stays where it was
LARGEST = 1e300  # of a coefficient: just before sliding stops, a step of 1e-13 has larger ones of high order


class WideSteps(Called):
    """Steps whose state and time are those of heyoka's integrator; the loop gets them rounded to doubles."""

    end: Any = None  # internal time of the end of the run

    def step(self, motion: Motion) -> None:
        """Make a step, at most to the end of the run."""
        ta, number = self.integrator, self.integrator.state.dtype.type
        self.before = ta.state.copy(), ta.dtime
        high, low = ta.dtime
        rounded = float(high)
        motion.high[0] = motion.start_high[0] = rounded
        motion.low[0] = motion.start_low[0] = float((high - number(rounded)) + low)
        outcome, h = ta.step((self.end - high) - low, write_tc=True)
        motion.h[0] = np.nan if outcome == hy.taylor_outcome.err_nf_state else float(h)
        is_last = outcome == hy.taylor_outcome.time_limit  # which the loop sees from a step of the allowed length
        motion.limit[0] = motion.h[0] if is_last else np.inf
        with np.errstate(over="ignore"):
            motion.state[:, 0] = ta.state.astype(float)
            motion.tc[:, :, 0] = np.clip(ta.tc.astype(float), -LARGEST, LARGEST)

    def undo(self) -> None:
        """Return to the start of the last step."""
        self.integrator.state[:], self.integrator.dtime = self.before

    def state_at(self, inside: np.ndarray) -> np.ndarray:
        """Return nothing of use: the driver makes the states of the log, in the working precision."""
        return np.zeros((len(self.integrator.state), 1))

    def states_at(self, times: np.ndarray) -> np.ndarray:
        """Return the states (k, variables) at internal times (k,) of the last step, in the working precision."""
        ta = self.integrator
        return np.array([ta.update_d_output(time).copy() for time in times]).reshape(len(times), len(ta.state))


class WideDriver(Driver):
    """Makes the steps of one run in numbers wider than doubles."""

    tiny = 0  # steps so short that the time in doubles stays

    def _stepper(self, state: np.ndarray, pars: Sequence[Any]) -> Stepper:
        return WideSteps(copy.deepcopy(self.compiled.integrator))

    def take(self, pars: Sequence[Any]) -> None:
        self.stepper.integrator.pars[:] = [self.number(number) for number in pars]

    @property
    def stepper(self) -> WideSteps:
        """The steps of the run."""
        return cast(WideSteps, self.place.stepper)

    def drive(self, request: Request, most: int) -> tuple[np.ndarray, Passages]:
        samples: list[np.ndarray] = []
        passages = [self._passages(0, np.zeros(len(self.rows.events)))]
        ends: list[tuple[float, np.ndarray]] = []
        ta, ended = self.stepper.integrator, False
        self.loop.fill(NO_ROWS)
        for _ in range(most):
            if ended:
                break
            seen, taken = int(self.log.filled[0]), int(self.samples.filled[0])
            on_zero = self.tallies.functions[ON_ZERO, :, 0].copy()
            before = int(self.tally["steps"])
            self.loop.drive(1)
            if self.tally["steps"] == before and self.tally["status"] == Status.RUNNING.code:
                self.tiny += 1  # a step that moves no double
                if self.tiny == PATIENCE:
                    self.tally["status"] = Status.STALLED.code
            ended = self.tally["status"] != Status.RUNNING.code
            if self.tally["status"] == Status.NON_FINITE.code:
                self.stepper.undo()
                break
            passages.append(self._passages(seen, on_zero))
            if self.samples.filled[0] > taken:
                samples.append(ta.state.copy())
            if not request.steps:
                self._rows(request, float(self.reached(passages[-1])), ended)
            elif self.tally["upto"] == 1.0:
                ends.append((float(ta.time), ta.state[: self.variables].copy()))
        if ends:
            request.take(np.array([time for time, _ in ends]), np.array([state for _, state in ends]))
        sampled = np.array(samples).reshape(len(samples), len(ta.state))
        return sampled, Passages(*(np.concatenate(columns) for columns in zip(*passages, strict=True)))

    def _passages(self, first: int, on_zero: np.ndarray) -> Passages:
        """Return the passages of the last step, from number `first` of the log on, in the working precision. `on_zero`
        is what was known of zeros where it began."""
        log, ta = self.log, self.stepper.integrator
        some = first + np.argsort(log.time[first : log.filled[0]], kind="stable")
        times, states = np.zeros(0, self.number), np.zeros((0, len(ta.state)), self.number)
        if len(some):
            start = self.stepper.before[1][0]
            length, near = ta.time - start, log.time[some].astype(self.number) - start
            functions = (_function(ta.tc, self.rows.events[e], -min(0, int(on_zero[e]))) for e in log.event[some])
            times = start + np.array(
                [_refined(f, x, length) for f, x in zip(functions, near, strict=True)], self.number
            )
            states = self.stepper.states_at(times)
        return Passages(times, log.event[some], log.sign[some], log.at_pole[some], states)

    def _rows(self, request: Request, reached: float, ended: bool) -> None:
        """Give the request its rows up to the time reached, and those at it if the run has ended."""
        while True:
            self.wanted.ask(request)
            left = self.wanted.left
            count = int(np.searchsorted(left, reached, side="right" if ended else "left"))
            if count:
                states = self.stepper.states_at(left[:count].astype(self.number))
                request.take(left[:count], states[:, : self.variables])
            self.wanted.made += count
            if count < len(left) or not count:
                return

    def reached(self, passages: Passages) -> Any:
        """Return the internal time where a slice with these passages has ended."""
        return passages.times[-1] if self.tally["upto"] < 1.0 else self.stepper.integrator.time

    @property
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""
        return self.stepper.integrator.dtime

    @property
    def state(self) -> np.ndarray:
        """All that is integrated."""
        return self.stepper.integrator.state

    def put(self, state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Put state and time in place."""
        ta = self.stepper.integrator
        ta.state[:], ta.dtime = state, clock

    def end_at(self, end: Any) -> None:
        """Put the end of the run at an internal time."""
        super().end_at(end)
        self.stepper.end = end


def _function(tc: np.ndarray, event: np.void, roots: int) -> np.ndarray:
    """Return the coefficients of an event function in a step, from those of all variables, (variables, order + 1),
    without so many zeros where the step begins."""
    whole = tc[event["row"]]
    if event["shift"] == 1:  # the rate of the variable
        return (whole[1:] * np.arange(1, len(whole)).astype(whole.dtype))[roots:]
    function = whole.copy()
    function[0] = function[0] + function.dtype.type(event["offset"])
    return function[roots:]


def _refined(function: np.ndarray, x: Any, length: Any) -> Any:
    """Return the zero of a polynomial near x, by Newton's rule in the precision of its coefficients."""
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
