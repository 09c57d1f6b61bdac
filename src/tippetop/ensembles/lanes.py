"""Many tops at once: lanes of heyoka's SIMD integrator, refilled from a queue as tops end.

Slices of steps never change a top, and no lane sees another: a top's numbers depend on its own only.
"""

import copy
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..engine.expressions import variables
from ..engine.status import SETTLED_FOR, Status
from ..mechanics.operand import leaves
from ..mechanics.system import KINDS, System
from ..problem import QUADRATURE_SCALE, Problem, Problems
from . import observer
from .observer import GOING, LIFTED, SETTLED, STALLED, Rules, Sources


LANES = 32  # two threads share the lock of Python better than with 16; alone 16 are as fast, 8 and 64 slower
LONGEST, SHORTEST = 64, 8  # steps of a slice: overhead against idle lanes, and coefficients that stay in the cache
AT_ONCE = 32  # slices between two looks at the invariants: a look takes 0.2 ms whatever its length
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
ENDS = {GOING: Status.FINISHED, LIFTED: Status.LIFTOFF, STALLED: Status.STALLED, SETTLED: Status.SETTLED}


class Machine(NamedTuple):
    """A compiled batch integrator, and what the books read of its Taylor coefficients."""

    integrator: Any
    rows: np.ndarray  # which variables' coefficients are kept
    sources: Sources  # where the event functions stand among them


@lru_cache(maxsize=32)
def compiled(system: System, form_name: str, friction: Any, tolerance: float, lanes: int) -> Machine:
    """The batch integrator of a system in a form with a friction law.

    Taylor coefficients of an event function are those of a variable, or of a rate; if it is neither, its integral is
    integrated too, scaled not to control the step. heyoka's own detection takes three times the integration.
    """
    form = system.forms[form_name]
    record, body, equations = variables(system, form, friction)
    scalars = form.scalars(record, body)
    found = {}
    for event in system.events:
        function = event.formula(scalars, body)
        source = _source(function, equations)
        found[event.name] = source or (len(equations), 1, QUADRATURE_SCALE, 0.0)
        if not source:
            equations.append((hy.make_vars(f"integral_{event.name}"), hy.expression(QUADRATURE_SCALE) * function))
    axis = [form.units._fields.index(v) for v in ("ux", "uy", "uz")]
    rows = np.unique([*axis, *(index for index, *_ in found.values())])
    index, shift, scale, offset = map(np.array, zip(*(found.get(k, (-1, 0, 1.0, 0.0)) for k in KINDS), strict=True))
    sources = Sources(
        np.where(index >= 0, np.searchsorted(rows, index), -1),
        shift,
        scale,
        offset,
        (index == index[0]) & (shift == 0) & (shift[0] == 1) & (scale[0] == 1.0),
        np.searchsorted(rows, axis),
    )
    integrator = hy.taylor_adaptive_batch(
        equations,
        np.zeros((len(equations), lanes)),
        pars=np.zeros((len(leaves(body)), lanes)),
        tol=tolerance,
        high_accuracy=True,
    )
    return Machine(integrator, rows, sources)


def _source(function: Any, equations: list[tuple]) -> tuple[int, int, float, float] | None:
    """Index of the variable that an expression is, give or take a number (shift 0), or is the rate of (shift 1); its
    scale, and that number."""
    for index, (variable, rate) in enumerate(equations):
        alone = hy.get_variables(function) == [str(variable)] and not hy.get_params(function)
        if alone and hy.diff(function, variable) == hy.expression(1.0):
            return index, 0, 1.0, float(hy.cfunc([function], vars=[variable])([0.0])[0])
        for scale in (1.0, QUADRATURE_SCALE):
            if hy.expression(scale) * function == rate:
                return index, 1, scale, 0.0
    return None


class Tally:
    """What a thread counts: steps made, and steps that lanes could have made."""

    made, possible = 0, 0


class Lanes:
    """The lanes of one integrator. `run` takes tops from a queue and hands back their pages of the books."""

    def __init__(self, tops: Problems, lanes: int = LANES):
        base = tops.base
        machine = compiled(base.system, base.form.name, base.friction.__class__, base.tolerance, lanes)
        self.tops, self.lanes, self.machine = tops, lanes, machine
        integrator = self.integrator = copy.deepcopy(machine.integrator)
        self.rules, self.rows = rules(base), machine.rows
        self.books = observer.blank(lanes)
        self.top = np.full(lanes, -1)  # which top is in a lane; -1: none
        self.end = np.zeros(lanes)
        self.final = np.zeros((lanes, len(integrator.state)))
        self.samples = np.empty((2, (LONGEST // observer.EVERY + 1) * lanes), np.int64)
        self.seen: list[tuple[np.ndarray, np.ndarray]] = []  # sampled states, and their tops, to be looked at together
        # views of the integrator's own memory, and what is kept of it after every step
        self.now, self.state, self.tc, self.kept = integrator.time, integrator.state, integrator.tc, 0
        self.times = np.empty((LONGEST + 1, lanes))
        self.states = np.empty((LONGEST + 1, *self.state.shape))
        self.tcs = np.empty((LONGEST, len(machine.rows), *self.tc.shape[1:]))
        self.tally = Tally()
        integrator.pars[:] = tops.pars[:, tops.valid][:, :1]  # lanes without a top hold a sound one, at its end
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
        self.integrator.pars[:, lane] = self.tops.pars[:, top]
        self._put(lane, self.tops.start[:, top])
        self.top[lane], self.end[lane] = top, self.tops.end[top]
        observer.open_page(self.books, lane, signs, on_zero)

    def park(self, lane: int) -> None:
        """Leaves a lane with a sound top at its end: it takes no steps."""
        sound = np.flatnonzero(self.tops.valid)[0]
        self.integrator.pars[:, lane] = self.tops.pars[:, sound]
        self._put(lane, self.tops.start[:, sound])
        self.top[lane] = -1

    def _length(self) -> int:
        """Steps until the first lane is likely to end."""
        going = (self.top >= 0) & (self.books["steps"] > 0)
        if not going.any():
            return SHORTEST
        left = (self.end - self.books["t"])[going] * self.books["steps"][going] / self.books["t"][going]
        return int(np.clip(1.01 * left.min() + 1, SHORTEST, LONGEST))

    def run(self, queue: Iterator[int], ready: Callable, done: Callable) -> None:
        """Runs tops from the queue to their ends. `ready(top)` gives the signs of its event functions at the start,
        `done(lane, status)` is told of every end, with the lane's page still open."""
        for lane in range(self.lanes):
            self._next(lane, queue, ready)
        while (self.top >= 0).any():
            self.advance(done)
            for lane in np.flatnonzero(self.top == -2).tolist():
                self._next(lane, queue, ready)
        self._look()

    def _next(self, lane: int, queue: Iterator[int], ready: Callable) -> None:
        top = next(queue, None)
        if top is None:
            self.park(lane)
        else:
            self.load(lane, top, *ready(top))

    def advance(self, done: Callable) -> None:
        """A slice; lanes whose top has ended are told of and left empty (-2)."""
        ta, books = self.integrator, self.books
        dtime = tuple(np.array(part) for part in ta.dtime)
        self.times[0], self.states[0], self.kept = self.now, self.state, 0
        # heyoka's dense output costs 0.7 ms a call (it compiles) and fresh memory; its callback 1 us a step
        ta.propagate_until(self.end, max_steps=self._length(), write_tc=True, callback=self._keep)
        outcomes = [result[0] for result in ta.propagate_res]
        broken = np.array([outcome == hy.taylor_outcome.err_nf_state for outcome in outcomes])
        if broken.any():  # heyoka stopped all lanes, in a step that nobody saw: the slice is made again without
            self.times[: self.kept + 1, ~broken] = self.times[0, ~broken]  # steps that lead nowhere are not followed
        before = int(books["steps"].sum())
        self._follow()
        if broken.any():
            ta.state[:] = self.states[0]
            ta.set_dtime(*dtime)
        else:
            self.tally.made += int(books["steps"].sum()) - before
            self.tally.possible += self.lanes * self.kept
        over = np.array([outcome == hy.taylor_outcome.time_limit for outcome in outcomes]) & ~broken.any()
        for lane in np.flatnonzero((self.top >= 0) & (over | broken | (books["code"] != GOING))).tolist():
            code = int(books["code"][lane])
            if code != GOING:
                self.final[lane] = self._state_at_end(lane)
            else:
                self.final[lane] = self.states[self.kept, :, lane]
            done(lane, Status.NON_FINITE if broken[lane] and code == GOING else ENDS[code])
            self.end[lane] = self.now[lane]
            if broken[lane]:
                self.park(lane)
            self.top[lane] = -2

    def _keep(self, integrator: Any) -> bool:
        """heyoka calls this after every step."""
        k = self.kept
        self.tc.take(self.rows, 0, self.tcs[k], "clip")
        self.kept = k = k + 1
        self.states[k], self.times[k] = self.state, self.now
        return True

    def _follow(self) -> None:
        times, tcs = self.times[: self.kept + 1], self.tcs[: self.kept]
        kept = observer.follow(times, tcs, self.machine.sources, self.rules, self.books, self.samples)
        if kept:
            steps, lanes = self.samples[:, :kept]
            self.seen.append((self.states[steps + 1, :, lanes].T, self.top[lanes]))
            if len(self.seen) >= AT_ONCE:
                self._look()

    def _look(self) -> None:
        seen, self.seen = self.seen, []
        if seen:
            self.look(*(np.concatenate(part, axis=-1) for part in zip(*seen, strict=True)))

    def _state_at_end(self, lane: int) -> np.ndarray:
        """The state in which a rule ended a top: if in the midst of a step, that step is made again up to there."""
        step, upto = int(self.books["step"][lane]), float(self.books["upto"][lane])
        if upto == 1.0:
            return self.states[step + 1, :, lane]
        again = copy.deepcopy(self.machine.integrator)
        again.pars[:], again.state[:] = self.integrator.pars[:, [lane]], self.states[step, :, [lane]].T
        again.propagate_until(np.full(self.lanes, upto * (self.times[step + 1, lane] - self.times[step, lane])))
        return again.state[:, 0]

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Told of sampled states (variables, k) and whose they are; replaced by who wants to compare invariants."""


def rules(base: Problem) -> Rules:
    """When a lane ends before its time."""
    stops = base.on_liftoff == "stop" and any(e.name == "liftoff" and e.stops for e in base.system.events)
    return Rules(stops, SETTLED_FOR if base.stop_when == "settled" else np.inf, MOST_STEPS)
