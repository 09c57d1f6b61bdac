"""One run in numbers wider than doubles.

heyoka makes each step, and the loop gets its coefficients rounded to doubles. It finds events on
them, by the same code as in a run in doubles; Python then refines their times by Newton's rule in
the working precision. So no second search for events has to be written or trusted.
"""

import copy
import weakref
from collections.abc import Sequence
from typing import Any

import heyoka as hy
import numpy as np

from .driver import Driver, Workspace
from .integrator import Compiled
from .loop import Motion
from .stepper import Called, Stepper


REFINEMENTS = 3  # of a zero: each squares its error, from 1e-16
NEAR = 1e-6  # of a step: a zero that moves further is rounding's, and stays where it was
LEAST = 1e-300  # of a step, as the loop sees it: it may move no double
# of a coefficient: just before sliding stops, a step of 1e-13 has larger ones of high order
LARGEST = 1e300


class WideSteps(Called):
    """Make steps by heyoka's integrator, and pass them to the loop rounded to doubles.

    Passages, samples and rows that the loop stores are stored here in the working precision.

    Parameters
    ----------
    integrator
        heyoka's integrator, which is copied.
    run
        The driver whose steps these are.

    Attributes
    ----------
    refined
        How many passages of the log are refined.
    """

    refined = 0

    def __init__(self, integrator: Any, run: Driver):
        self.integrator = copy.deepcopy(integrator)
        self.run = run

    def step(self, motion: Motion) -> None:
        """Make a step, at most to the end of the run.

        If it is not finite, `motion.h` becomes NaN, by which the loop ends the run, and heyoka's
        state is set back.
        """
        ta = self.integrator
        run = self.run
        self.before = (ta.state.copy(), ta.dtime)
        self.refined = run.logged[0]
        high, low = ta.dtime
        motion.high[0] = motion.start_high[0] = start = float(high)
        motion.low[0] = motion.start_low[0] = 0.0
        outcome, _ = ta.step((run.goal - high) - low, write_tc=True)
        motion.h[0] = max(float(ta.time) - start, LEAST)
        # the loop sees the last step from its length, the allowed one
        motion.limit[0] = motion.h[0] if outcome == hy.taylor_outcome.time_limit else np.inf
        with np.errstate(over="ignore"):
            motion.state[:, 0] = ta.state.astype(float)
            motion.tc[:, :, 0] = np.clip(ta.tc.astype(float), -LARGEST, LARGEST)
        is_broken = outcome == hy.taylor_outcome.err_nf_state
        if is_broken or not np.isfinite(motion.state).all():
            motion.h[0] = np.nan
            ta.state[:], ta.dtime = self.before
        # where the loop puts the end of the step, if it keeps it as a sample or as a row
        n = len(ta.state)
        rows = run.output.states
        row = run.made[0]
        run.samples.states[run.sampled_so_far[0], :n] = ta.state
        if row < len(rows):
            rows[row, :n] = ta.state

    def keep(self) -> None:
        """Store the next zero of the log, refined, or else the next row.

        The loop has logged all zeros of the step, in order, before it calls for the first of them;
        `step` sets `refined` to where they begin.
        """
        ta = self.integrator
        run = self.run
        n = len(self.integrator.state)
        if self.refined < run.logged[0]:
            k = self.refined
            start = self.before[1][0]
            when, event, *_ = run.log.rows[k]
            on_zero = int(run.functions["on_zero"][event])
            # as `roots` in loop.c, but this step is already counted
            roots = -min(0, on_zero) if run.steps[0] == 1 else 0
            function = _function(ta.tc, run.workspace.rows.events[event], roots)
            time = start + _refined(function, run.number(when) - start, ta.time - start)
            run.times[k], run.log.states[k, :n] = time, ta.update_d_output(time)
            self.refined += 1
        else:
            rows = run.output
            row = run.made[0]
            rows.states[row, :n] = ta.update_d_output(run.number(rows.times[row]))


class WideDriver(Driver):
    """Integrate one run in numbers wider than doubles: a `Driver` whose stepper is `WideSteps`."""

    def stepper_of(self, code: Compiled) -> Stepper:
        """Return a stepper in Python around heyoka's integrator."""
        return WideSteps(code.integrator, weakref.proxy(self))

    def set_parameters(self, workspace: Workspace, body: Sequence[Any]) -> None:
        """Set the parameters of an integrator to the first of these numbers."""
        pars = workspace.stepper.integrator.pars
        pars[:] = [self.number(number) for number in body[: len(pars)]]

    @property
    def now(self) -> Any:
        """Return the internal time at the end of the last step."""
        return self.stepper.integrator.time

    @property
    def clock(self) -> tuple[Any, Any]:
        """Return the internal time in double length, as the sum of two numbers."""
        return self.stepper.integrator.dtime

    @property
    def state(self) -> np.ndarray:
        """Return all integrated variables."""
        return self.stepper.integrator.state

    def set_state(self, state: Sequence[Any] | np.ndarray, clock: tuple[Any, Any]) -> None:
        """Set the state, padded with zeros, and the time as (high, low), of heyoka's integrator.

        The arrays of the loop follow with the next step.
        """
        ta = self.stepper.integrator
        ta.state[:] = 0
        ta.state[: len(state)], ta.dtime = state, clock


def _function(tc: np.ndarray, event: np.void, roots: int) -> np.ndarray:
    """Return the Taylor coefficients of an event function in a step, from number `roots` on.

    They are those that `search` in loop.c takes, in wider numbers, and not in time over h.

    `tc` are those of all variables, (variables, order + 1); `event` is a `tallies.EVENT_RECORD`.
    """
    whole = tc[event["row"]]
    if event["shift"] == 1:  # the rate of the variable
        return (whole[1:] * np.arange(1, len(whole)).astype(whole.dtype))[roots:]
    function = whole.copy()
    function[0] = function[0] + function.dtype.type(event["offset"])
    return function[roots:]


def _refined(function: np.ndarray, x: Any, length: Any) -> Any:
    """Return the zero of a polynomial near x, by Newton's rule in its precision.

    `function` are its coefficients, ascending; `length` is that of the step, beyond which no zero
    moves.
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
