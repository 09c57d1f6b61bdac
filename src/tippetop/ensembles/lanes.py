"""Many tops at once: lanes of heyoka's SIMD integrator, refilled from a queue as tops end.

Slices of steps never change a top, and no lane sees another: a top's numbers depend on its own only.
"""

import copy
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..engine.expressions import equations_of_motion
from ..engine.observables import values_of
from ..engine.settling import SETTLED_FOR, stays
from ..engine.status import Status
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..mechanics.variables import INTEGRAL_SCALE, Variables
from ..problem import Problem, Problems
from .observer import EVERY, follow
from .tallies import EventRows, StopRules, event_rows, new_tallies, reset


LANES = 32  # two threads share the lock of Python better than with 16; alone 16 are as fast, 8 and 64 slower
LONGEST, SHORTEST = 64, 8  # steps of a slice: overhead against idle lanes, and coefficients that stay in the cache
SLICES_PER_CHECK = 32  # slices between two looks at the invariants: a look takes 0.2 ms whatever its length
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
STATUSES = {status.code: status for status in Status}


class CompiledBatch(NamedTuple):
    """A compiled batch integrator, and what the observer reads of its Taylor coefficients."""

    integrator: Any
    variables: np.ndarray  # whose coefficients are kept
    rows: EventRows  # where the event functions stand among them


class Observer(Protocol):
    """What `Lanes.run` calls: with tops that begin, samples on the way, and ends."""

    def ready(self, top: int) -> tuple[np.ndarray, np.ndarray]:
        """Signs of the event functions of a top at its start, (events,), and which of them are on their zero."""

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Takes states (variables, k) that were sampled on the way, and whose they are, (k,)."""

    def done(self, lane: int, status: Status) -> None:
        """Takes the end of the top in a lane, whose tally still stands."""


@lru_cache(maxsize=32)
def compiled(
    system: System, form_name: str, friction: Any, tolerance: float, lanes: int, orientation: bool = False
) -> CompiledBatch:
    """The batch integrator of a system in a form with a friction law.

    Taylor coefficients of an event function are those of a variable, or of a rate; if it is neither, its integral is
    integrated too, scaled not to control the step. heyoka's own detection takes three times the integration.
    """
    form = system.forms[form_name]
    variables = Variables(form, orientation)
    q, _, body, equations = equations_of_motion(system, variables, friction)
    scalars = form.scalars(q, body)
    sources = []
    for event in system.events:
        function = event.formula(scalars, body)
        source = _source(function, equations)
        sources.append(source or (len(equations), 1, INTEGRAL_SCALE, 0.0))
        if not source:
            equations.append((hy.make_vars(f"integral_{event.name}"), hy.expression(INTEGRAL_SCALE) * function))
    axis = [variables.names.index(v) for v in ("ux", "uy", "uz")]
    kept = np.unique([*axis, *(index for index, *_ in sources)])
    integrator = hy.taylor_adaptive_batch(
        equations,
        np.zeros((len(equations), lanes)),
        tol=tolerance,
        high_accuracy=True,
    )
    return CompiledBatch(integrator, kept, event_rows(system.events, sources, kept, axis))


def _source(function: Any, equations: list[tuple]) -> tuple[int, int, float, float] | None:
    """Index of the variable that an expression is, give or take a number (shift 0), or is the rate of (shift 1); its
    scale, and that number."""
    for index, (variable, rate) in enumerate(equations):
        alone = hy.get_variables(function) == [str(variable)] and not hy.get_params(function)
        if alone and hy.diff(function, variable) == hy.expression(1.0):
            return index, 0, 1.0, float(hy.cfunc([function], vars=[variable])([0.0])[0])
        for scale in (1.0, INTEGRAL_SCALE):
            if hy.expression(scale) * function == rate:
                return index, 1, scale, 0.0
    return None


class Lanes:
    """The lanes of one integrator. `run` takes tops from a queue and tells an observer of their ends."""

    def __init__(self, tops: Problems, lanes: int = LANES):
        base = tops.base
        law = base.friction.__class__
        batch = awaited(
            lambda: compiled(base.system, base.form.name, law, base.tolerance, lanes, tops.orientation),
            "the equations are being compiled",
        )
        self.tops, self.lanes, self.batch = tops, lanes, batch
        integrator = self.integrator = copy.deepcopy(batch.integrator)
        self.rules, self.rows = rules(base), batch.rows
        if base.on_liftoff != "stop":  # then no event ends a run
            self.rows = self.rows._replace(events=self.rows.events.copy())
            self.rows.events["ends"] = 0
        self.tallies = new_tallies(self.rows, lanes)
        self.top = np.full(lanes, -1)  # which top is in a lane; -1: none
        self.end = np.zeros(lanes)
        self.final = np.zeros((lanes, len(integrator.state)))
        self.samples = np.empty((2, (LONGEST // EVERY + 1) * lanes), np.int64)
        self.seen: list[tuple[np.ndarray, np.ndarray]] = []  # sampled states and their tops, compared in one call
        # views of the integrator's own memory, and what is kept of it after every step
        self.now, self.state, self.tc, self.kept = integrator.time, integrator.state, integrator.tc, 0
        self.times = np.empty((LONGEST + 1, lanes))
        self.states = np.empty((LONGEST + 1, *self.state.shape))
        self.tcs = np.empty((LONGEST, len(batch.variables), *self.tc.shape[1:]))
        self.steps_made = self.steps_possible = 0  # steps of tops, and steps that the lanes could have made
        self.pars = tops.pars[: len(integrator.pars)]  # the integrator has none beyond the last that it reads
        integrator.pars[:] = self.pars[:, tops.valid][:, :1]  # lanes without a top hold a sound one, at its end
        self._put(slice(None), tops.start[:, tops.valid][:, :1])

    def _put(self, lane: Any, state: np.ndarray) -> None:
        self.integrator.state[:, lane] = 0.0
        self.integrator.state[: len(state), lane] = state
        high, low = (np.array(part) for part in self.integrator.dtime)
        high[lane], low[lane] = 0.0, 0.0
        self.integrator.set_dtime(high, low)
        self.end[lane] = 0.0

    def load(self, lane: int, top: int, signs: np.ndarray, on_zero: np.ndarray) -> None:
        """Puts a top into a lane."""
        self.integrator.pars[:, lane] = self.pars[:, top]
        self._put(lane, self.tops.start[:, top])
        self.top[lane], self.end[lane] = top, self.tops.end[top]
        reset(self.tallies, self.rows, lane, signs, on_zero)

    def park(self, lane: int) -> None:
        """Leaves a lane with a sound top at its end: it takes no steps."""
        sound = np.flatnonzero(self.tops.valid)[0]
        self.integrator.pars[:, lane] = self.pars[:, sound]
        self._put(lane, self.tops.start[:, sound])
        self.top[lane] = -1

    def _length(self) -> int:
        """Steps until the first lane is likely to end."""
        tally = self.tallies.lane
        going = (self.top >= 0) & (tally["steps"] > 0)
        if not going.any():
            return SHORTEST
        left = (self.end - tally["t"])[going] * tally["steps"][going] / tally["t"][going]
        return int(np.clip(1.01 * left.min() + 1, SHORTEST, LONGEST))

    def run(self, queue: Iterator[int], observer: Observer) -> None:
        """Runs tops from the queue to their ends."""
        for lane in range(self.lanes):
            self._next(lane, queue, observer)
        while (self.top >= 0).any():
            self.advance(observer)
            for lane in np.flatnonzero(self.top == -2).tolist():
                self._next(lane, queue, observer)
        self._look(observer)

    def _next(self, lane: int, queue: Iterator[int], observer: Observer) -> None:
        top = next(queue, None)
        if top is None:
            self.park(lane)
        else:
            self.load(lane, top, *observer.ready(top))

    def advance(self, observer: Observer) -> None:
        """A slice; lanes whose top has ended are left empty (-2)."""
        ta, tally = self.integrator, self.tallies.lane
        dtime = tuple(np.array(part) for part in ta.dtime)
        self.times[0], self.states[0], self.kept = self.now, self.state, 0
        # heyoka's dense output costs 0.7 ms a call (it compiles) and fresh memory; its callback 1 us a step
        ta.propagate_until(self.end, max_steps=self._length(), write_tc=True, callback=self._keep)
        outcomes = [result[0] for result in ta.propagate_res]
        broken = np.array([outcome == hy.taylor_outcome.err_nf_state for outcome in outcomes])
        if broken.any():  # heyoka stopped all lanes, in a step that nobody saw: the slice is made again without
            self.times[: self.kept + 1, ~broken] = self.times[0, ~broken]  # steps that lead nowhere are not followed
        before = int(tally["steps"].sum())
        self._follow(observer)
        if broken.any():
            ta.state[:] = self.states[0]
            ta.set_dtime(*dtime)
        else:
            self.steps_made += int(tally["steps"].sum()) - before
            self.steps_possible += self.lanes * self.kept
        over = np.array([outcome == hy.taylor_outcome.time_limit for outcome in outcomes]) & ~broken.any()
        stopped = tally["status"] != Status.RUNNING.code
        for lane in np.flatnonzero((self.top >= 0) & (over | broken | stopped)).tolist():
            if stopped[lane]:
                status, self.final[lane] = STATUSES[int(tally["status"][lane])], self._state_at_end(lane)
            else:
                status, self.final[lane] = Status.FINISHED, self.states[self.kept, :, lane]
                status = Status.NON_FINITE if broken[lane] else status
            observer.done(lane, status)
            self.end[lane] = self.now[lane]
            if broken[lane]:
                self.park(lane)
            self.top[lane] = -2

    def _keep(self, integrator: Any) -> bool:
        """heyoka calls this after every step."""
        k = self.kept
        self.tc.take(self.batch.variables, 0, self.tcs[k], "clip")
        self.kept = k = k + 1
        self.states[k], self.times[k] = self.state, self.now
        return True

    def _follow(self, observer: Observer) -> None:
        self.tallies.lane["step"] = -1
        while True:
            times, tcs = self.times[: self.kept + 1], self.tcs[: self.kept]
            sampled = follow(times, tcs, self.rows, self.rules, self.tallies, self.samples)
            if sampled:
                steps, lanes = self.samples[:, :sampled]
                self.seen.append((self.states[steps + 1, :, lanes].T, self.top[lanes]))
                if len(self.seen) >= SLICES_PER_CHECK:
                    self._look(observer)
            if not self._goes_on():
                return

    def _goes_on(self) -> bool:
        """Whether tops that had settled will yet move: then the rest of their steps is still to be followed."""
        tally, any_does = self.tallies.lane, False
        for lane in np.flatnonzero((self.top >= 0) & (tally["status"] == Status.SETTLED.code)).tolist():
            top = self.top[[lane]]
            body = self.tops.body(lambda given, top=top: float(np.broadcast_to(given, (self.tops.n,))[top[0]]))
            state = self.states[int(tally["step"][lane]) + 1, : len(self.tops.start), [lane]].T
            if not stays(body, values_of(self.tops, state, top), float(self.tops.unit(SECOND)[top[0]])):
                tally["status"][lane], any_does = Status.RUNNING.code, True
                tally["doubted"][lane] = tally["lasts_since"][lane]
        return any_does

    def _look(self, observer: Observer) -> None:
        seen, self.seen = self.seen, []
        if seen:
            observer.look(*(np.concatenate(part, axis=-1) for part in zip(*seen, strict=True)))

    def _state_at_end(self, lane: int) -> np.ndarray:
        """The state in which a rule ended a top: if in the midst of a step, that step is made again up to there."""
        step, upto = int(self.tallies.lane["step"][lane]), float(self.tallies.lane["upto"][lane])
        if upto == 1.0:
            return self.states[step + 1, :, lane]
        again = copy.deepcopy(self.batch.integrator)
        again.pars[:], again.state[:] = self.integrator.pars[:, [lane]], self.states[step, :, [lane]].T
        again.propagate_until(np.full(self.lanes, upto * (self.times[step + 1, lane] - self.times[step, lane])))
        return again.state[:, 0]


def rules(base: Problem) -> StopRules:
    """When a top ends before its time, other than by an event."""
    lasting = [i for i, event in enumerate(base.system.events) if event.lasting] if base.stop_when == "settled" else []
    way = base.system.events[lasting[0]].direction if lasting else 0
    return StopRules(lasting[0] if lasting else -1, way, SETTLED_FOR, MOST_STEPS)
