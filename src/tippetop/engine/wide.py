"""One run in any precision: heyoka makes the steps, a slice at a time, and the observer follows their coefficients.

Events are found in doubles, from the same polynomials as those of a compiled step, and their times then refined in the
working precision.
"""

import copy
from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np

from ..mechanics.operand import leaves
from ..problem import Problem
from .code_cache import without_heyokas_cache
from .compiled import Compiled
from .loop import follow
from .slices import STATUSES, Driver, Passages, Request, Slice, new_room
from .status import Status
from .tallies import new_log


REFINEMENTS = 3  # of a zero: each squares its error, from 1e-16
NEAR = 1e-6  # of a step: a zero that moves further is rounding's, and stays where it was


class SliceDriver(Driver):
    """Drives a run by heyoka's own loop."""

    def __init__(self, problem: Problem, compiled: Compiled):
        super().__init__(problem, compiled, new_room(compiled))
        self.integrator = copy.deepcopy(compiled.integrator)
        pars = leaves(problem.internal_body)[: len(self.integrator.pars)]  # it has none beyond the last that it reads
        self.integrator.pars[:] = [problem.number(leaf) for leaf in pars]
        self.integrator.state[: self.variables] = problem.start()
        self.reached: Any = problem.number(0)

    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps."""
        integrator = self.integrator
        before, state = int(self.tally["steps"]), self.state.copy()
        with without_heyokas_cache():  # its dense output is compiled for each number of steps
            outcome, *_, output, _ = integrator.propagate_until(self.end, max_steps=most, c_output=True)
        if output is None:  # not one step was possible
            broken = outcome == hy.taylor_outcome.err_nf_state
            none, no_states = np.zeros(0, int), np.zeros((0, len(state)), state.dtype)
            passages = Passages(np.zeros(0, state.dtype), none, none, none > 0, no_states)
            return self._slice(
                0, self.reached, state[None, :], no_states, passages, Status.NON_FINITE if broken else Status.FINISHED
            )
        times, coefficients = output.times, output.tcs
        ends = np.concatenate([coefficients[1:, :, 0], self._end(output, outcome)])
        steps = len(times) - 1
        while steps and not np.all(np.isfinite(ends[steps - 1].astype(float))):  # never let a bad state in
            steps -= 1
        self.log = new_log(steps * len(self.rows.events) * coefficients.shape[2], 0)  # there cannot be more zeros
        follow(
            times[: steps + 1].astype(float)[:, None],
            np.ascontiguousarray(_doubles(coefficients[:steps])[..., None]),
            self.rows, self.rules, self.tallies, self.log,
        )  # fmt: skip
        reached, last = times[steps], ends[steps - 1 : steps] if steps else state[None, :]
        passages = self._passages(output, coefficients)
        if self.tally["upto"] < 1.0:
            reached, last = passages.times[-1], passages.states[-1:]
        ended, self.reached = self._status(outcome), reached
        self._rows(output, request, float(reached), ended is not None, ends)
        counts = np.arange(before + 1, 1 + int(self.tally["steps"]))
        sampled = ends[: len(counts)][(counts % self.rules.every == 0) | (counts <= self.rules.first)]
        return self._slice(len(counts), reached, last, sampled, passages, ended)

    def _slice(
        self, steps: int, time: Any, last: Any, samples: Any, passages: Passages, status: Status | None
    ) -> Slice:
        n = self.variables
        passages = passages._replace(states=passages.states[:, :n])
        return Slice(steps, time, last[:, :n].copy(), samples[:, :n].copy(), passages, status)

    def _end(self, output: Any, outcome: Any) -> np.ndarray:
        """The state at the end of the last step, (1, variables)."""
        broken = outcome == hy.taylor_outcome.err_nf_state
        return (np.array(output(output.times[-1])) if broken else self.integrator.state.copy())[None, :]

    def _status(self, outcome: Any) -> Status | None:
        """How the run ended: by what the observer found before the integrator came to its end."""
        status = STATUSES[int(self.tally["status"])]
        if status is not Status.RUNNING:
            return status
        known = {hy.taylor_outcome.time_limit: Status.FINISHED, hy.taylor_outcome.err_nf_state: Status.NON_FINITE}
        return known.get(outcome)

    def _passages(self, output: Any, coefficients: np.ndarray) -> Passages:
        """What the log holds, in the working precision."""
        log, number = self.log, self.problem.number
        order = np.argsort(log.time[: log.filled[0]], kind="stable")
        events, step = log.event[order], log.step[order]
        if not len(order):
            none = np.zeros(0, int)
            return Passages(np.zeros(0, number), none, none, none > 0, np.zeros((0, coefficients.shape[1]), number))
        start = output.times[step]
        record = self.rows.events[events]
        inside = log.time[order].astype(number) - start
        refined = start + _refined(coefficients[step], record, inside, np.diff(output.times)[step])
        states = np.array(output(refined), copy=True)
        return Passages(refined, events, log.sign[order], log.at_pole[order], states)

    def _rows(self, output: Any, request: Request, reached: float, ended: bool, ends: np.ndarray) -> None:
        """Gives the request its rows up to the time reached, and those at it if the run has ended."""
        if request.steps:
            times = output.times[1:].astype(float)
            count = int(np.searchsorted(times, reached, side="right" if self.tally["upto"] == 1.0 else "left"))
            request.take(times[:count], ends[:count, : self.variables].copy())
            return
        while True:
            self.wanted.ask(request)
            left = self.wanted.left
            count = int(np.searchsorted(left, reached, side="right" if ended else "left"))
            if count:
                self._give(request, left[:count], output)
            self.wanted.made += count
            if count < len(left) or not count:
                return

    def _give(self, request: Request, times: np.ndarray, output: Callable) -> None:
        states = np.array(output(times.astype(self.problem.number)), copy=True)[:, : self.variables]
        request.take(times.astype(float), states)

    @property
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""
        return self.integrator.dtime

    @property
    def state(self) -> np.ndarray:
        """All that is integrated."""
        return self.integrator.state

    def put(self, state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Puts state and time in place."""
        self.integrator.state[:] = state
        self.integrator.dtime = clock
        self.reached = clock[0]


def _refined(coefficients: np.ndarray, events: np.ndarray, inside: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Zeros (k,) of event functions in the time since the start of their steps, by Newton's rule in the precision of
    the coefficients, (k, variables, order + 1)."""
    k, size = np.arange(len(inside)), coefficients.shape[2]
    number = coefficients.dtype.type
    whole = coefficients[k, events["row"]]
    powers = np.arange(1, size).astype(number)
    function = np.where((events["shift"] == 1)[:, None], _shifted(whole, powers), whole)
    function[:, 0] = function[:, 0] + events["offset"].astype(number)
    x = inside
    for _ in range(REFINEMENTS):
        value, slope = function[:, -1] * number(0), function[:, -1] * number(0)
        for j in range(size - 1, -1, -1):
            slope = slope * x + value
            value = value * x + function[:, j]
        steep = np.abs(slope) > 0
        change = np.where(steep, value / np.where(steep, slope, slope + number(1)), value * number(0))
        small = np.abs(change).astype(float) <= NEAR * length.astype(float)
        x = np.where(small, x - change, x)
    return x


def _shifted(whole: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Coefficients of the rate of a variable, from those of the variable, (k, order + 1)."""
    rate = whole[:, 1:] * powers
    return np.concatenate([rate, whole[:, :1] * powers.dtype.type(0)], axis=1)


LARGEST = 1e300  # of a coefficient: just before sliding stops, a step of 1e-13 has larger ones of high order


def _doubles(coefficients: np.ndarray) -> np.ndarray:
    """Taylor coefficients as doubles; what exceeds them counts for nothing within its step."""
    with np.errstate(over="ignore"):
        rounded = coefficients.astype(float)
    return np.clip(rounded, -LARGEST, LARGEST, out=rounded)
