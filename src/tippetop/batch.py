"""Many tops at once: lanes of heyoka's SIMD integrator, refilled from a queue as tops end.

Slices of steps never change a top, and no lane sees another: a top's numbers depend on its own only.
"""

import copy
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from . import ledger
from .engine import Status
from .events import KINDS
from .ledger import GOING, LIFTED, SETTLED, STALLED, Places, Rules
from .operand import leaves
from .problem import QUADRATURE_SCALE, Problem
from .solve import SETTLED_FOR
from .symbols import variables
from .systems import SYSTEMS
from .tops import Tops


LANES = 16  # two vectors of eight doubles; 8 and 32 take a tenth longer a top
LONGEST, SHORTEST = 64, 8  # steps of a slice: overhead against idle lanes, and coefficients that stay in the cache
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
ENDS = {GOING: Status.FINISHED, LIFTED: Status.LIFTOFF, STALLED: Status.STALLED, SETTLED: Status.SETTLED}


class Machine(NamedTuple):
    """A compiled batch integrator, and where the variables that the books need stand among its variables."""

    integrator: Any
    names: tuple[str, ...]
    places: Places


@lru_cache(maxsize=32)
def compiled(name: str, form_name: str, friction: Any, tolerance: float, lanes: int) -> Machine:
    """The batch integrator of a system in a form with a friction law.

    Beside the equations of motion it integrates the event functions, scaled not to control the step: their Taylor
    coefficients are the functions themselves on every step. heyoka's own detection takes three times the integration.
    """
    system = SYSTEMS[name]
    form = system.forms[form_name]
    record, body, equations = variables(system, form, friction)
    scalars = form.scalars(record, body)
    names = list(form.units._fields)
    for event in system.events:
        rate = hy.expression(QUADRATURE_SCALE) * event.formula(scalars, body)
        equations.append((hy.make_vars(f"integral_{event.name}"), rate))
        names.append(f"integral_{event.name}")
    places = [names.index(v) if v in names else -1 for v in (*(f"integral_{k}" for k in KINDS), "ux", "uy", "uz")]
    integrator = hy.taylor_adaptive_batch(
        equations,
        np.zeros((len(equations), lanes)),
        pars=np.zeros((len(leaves(body)), lanes)),
        tol=tolerance,
        high_accuracy=True,
    )
    return Machine(integrator, tuple(names), Places(*places))


class Tally:
    """What a thread counts: steps made, and steps that lanes could have made."""

    made, possible = 0, 0


class Lanes:
    """The lanes of one integrator. `run` takes tops from a queue and hands back their pages of the books."""

    def __init__(self, tops: Tops, lanes: int = LANES):
        base = tops.base
        machine = compiled(base.system.name, base.form.name, base.friction.__class__, base.tolerance, lanes)
        self.tops, self.lanes, self.places = tops, lanes, machine.places
        self.integrator = copy.deepcopy(machine.integrator)
        self.rules = rules(base)
        self.books = ledger.blank(lanes)
        self.top = np.full(lanes, -1)  # which top is in a lane; -1: none
        self.end = np.zeros(lanes)
        self.final = np.zeros((lanes, len(machine.names)))
        self.worst: dict[str, np.ndarray] = {}
        self.samples = np.empty((len(machine.names), (LONGEST // ledger.EVERY + 1) * lanes))
        self.owners = np.empty(self.samples.shape[1], np.int64)
        self.tcs, self.kept = np.empty((LONGEST, *self.integrator.tc.shape)), 0
        self.times = np.empty((LONGEST + 1, lanes))
        self.tally = Tally()
        integrator = self.integrator
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
        ledger.open_page(self.books, lane, signs, on_zero)

    def park(self, lane: int) -> None:
        """Leaves a lane with a sound top at its end: it takes no steps."""
        sound = np.flatnonzero(self.tops.valid)[0]
        self.integrator.pars[:, lane] = self.tops.pars[:, sound]
        self._put(lane, self.tops.start[:, sound])
        self.top[lane] = -1

    def _length(self) -> int:
        """Steps until the first lane is likely to end."""
        going = (self.top >= 0) & (self.books.steps > 0)
        if not going.any():
            return SHORTEST
        left = (self.end - self.books.t)[going] * self.books.steps[going] / self.books.t[going]
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

    def _next(self, lane: int, queue: Iterator[int], ready: Callable) -> None:
        top = next(queue, None)
        if top is None:
            self.park(lane)
        else:
            self.load(lane, top, *ready(top))

    def advance(self, done: Callable) -> None:
        """A slice; lanes whose top has ended are told of and left empty (-2)."""
        ta, books = self.integrator, self.books
        state, dtime = ta.state.copy(), tuple(np.array(part) for part in ta.dtime)
        self.times[0], self.kept = ta.time, 0
        # heyoka's dense output costs 0.7 ms a call (it compiles) and fresh memory; its callback 4 us a step
        ta.propagate_until(self.end, max_steps=self._length(), write_tc=True, callback=self._keep)
        times, tcs = self.times[: self.kept + 1], self.tcs[: self.kept]
        outcomes = [result[0] for result in ta.propagate_res]
        broken = [lane for lane in range(self.lanes) if outcomes[lane] == hy.taylor_outcome.err_nf_state]
        if broken:  # heyoka stopped all lanes, in a step that nobody saw: the slice is made again without
            for lane in broken:
                self.final[lane] = state[:, lane]
                if self.kept:  # the steps that were good
                    alone = np.zeros(times.shape)
                    alone[:, lane] = times[:, lane]
                    self._follow(alone, tcs)
                    if books.code[lane] == GOING:
                        h = alone[-1, lane] - alone[-2, lane]
                        self.final[lane] = np.polynomial.polynomial.polyval(h, tcs[-1, :, :, lane].T)
                done(lane, Status.NON_FINITE if books.code[lane] == GOING else ENDS[int(books.code[lane])])
            ta.state[:] = state
            ta.set_dtime(*dtime)
            for lane in broken:
                self.park(lane)
                self.top[lane] = -2
            return
        before = int(books.steps.sum())
        self._follow(times, tcs)
        self.tally.made += int(books.steps.sum()) - before
        self.tally.possible += self.lanes * self.kept
        for lane in np.flatnonzero(self.top >= 0).tolist():
            code = int(books.code[lane])
            if code == GOING and outcomes[lane] != hy.taylor_outcome.time_limit:
                continue
            if code == GOING:
                self.final[lane] = ta.state[:, lane]
            done(lane, ENDS[code])
            self.top[lane], self.end[lane] = -2, ta.time[lane]

    def _keep(self, integrator: Any) -> bool:
        """heyoka calls this after every step."""
        self.tcs[self.kept] = integrator.tc
        self.kept += 1
        self.times[self.kept] = integrator.time
        return True

    def _follow(self, times: np.ndarray, tcs: np.ndarray) -> None:
        kept = ledger.follow(
            times,
            tcs,
            self.places,
            self.rules,
            self.books,
            1 / QUADRATURE_SCALE,
            self.final,
            self.samples,
            self.owners,
        )
        if kept:
            self.look(self.samples[:, :kept], self.owners[:kept])

    def look(self, states: np.ndarray, lanes: np.ndarray) -> None:
        """Told of sampled states; replaced by who wants to compare invariants."""


def rules(base: Problem) -> Rules:
    """When a lane ends before its time."""
    stops = base.on_liftoff == "stop" and any(e.name == "liftoff" and e.stops for e in base.system.events)
    return Rules(stops, SETTLED_FOR if base.stop_when == "settled" else np.inf, MOST_STEPS)
