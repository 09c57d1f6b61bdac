"""Many tops at once: lanes of a SIMD integrator, refilled from a queue as tops end.

No lane sees another: a top's numbers depend on its own only.
"""

import copy
from collections.abc import Collection, Iterator
from typing import Protocol

import numpy as np

from ..awaiting import awaited
from ..engine.compiled import compiled, is_same_step
from ..engine.driver import begin_step, dense_state, drive, end_step, new_motion, no_rows
from ..engine.observables import values_of
from ..engine.settling import SETTLED_FOR, stays
from ..engine.slices import STATUSES
from ..engine.status import Status
from ..engine.tallies import EventRows, StopRules, mark_bounded, new_log, new_samples, new_scratch, new_tallies, reset
from ..mechanics.units import SECOND
from ..problem import Problem, Problems


LANES = 8  # as fast as 32, and they compile in 1 s instead of 6
SAMPLES = 64  # of a lane, between two looks at the invariants: a look takes 0.2 ms whatever its length
EVERY = 32  # steps between two samples
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
ENDLESS = 1 << 62
SWINGS = ("turnings", "theta_min", "theta_max")  # columns that turnings give


class Observer(Protocol):
    """What `Lanes.run` calls: with tops that begin, samples on the way, and ends."""

    def ready(self, top: int) -> tuple[np.ndarray, np.ndarray]:
        """Signs of the event functions of a top at its start, (events,), and which of them are on their zero."""

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Takes states (variables, k) that were sampled on the way, and whose they are, (k,)."""

    def done(self, lane: int, status: Status) -> None:
        """Takes the end of the top in a lane, whose tally still stands."""


class Lanes:
    """The lanes of one integrator. `run` takes tops from a queue and tells an observer of their ends."""

    def __init__(self, tops: Problems, lanes: int = LANES, wanted: Collection[str] | None = None, every: int = EVERY):
        base = tops.base
        law, tolerance, orientation = base.friction.__class__, base.tolerance, tops.orientation
        code = awaited(
            lambda: compiled(base.system, base.form.name, law, "double", tolerance, lanes, False, orientation),
            "the equations are being compiled",
        )
        self.tops, self.lanes, self.rows = tops, lanes, watched(code.rows, base, wanted)
        self.rules, self.tallies = rules(base, every), new_tallies(self.rows, lanes)
        n, order = len(code.integrator.state), code.integrator.order
        self.motion = new_motion(code.integrator, lanes)
        drifts = wanted is None or any(name.startswith("drift") for name in wanted)
        self.samples = new_samples(SAMPLES * lanes if drifts else 0, n, lanes)
        self.log, self.scratch = new_log(0, n), new_scratch(order + 1, lanes)
        self.out = np.zeros((n, lanes))  # states within a step
        self.top = self.samples.in_lane  # which top is in a lane; -1: none
        self.final = np.zeros((lanes, n))
        self.steps_made = self.steps_possible = 0  # steps of tops, and steps that the lanes could have made
        self.pars = tops.pars[: len(self.motion.pars)]  # the integrator has none beyond the last that it reads
        for lane in range(lanes):
            self.park(lane)
        self.machine = code.machine
        if self.machine is not None and not is_same_step(code, self.motion.state, self.motion.pars):
            self.machine = None
        if self.machine is not None:  # all lanes are at their ends: it makes no step
            watch = self.rows, self.tallies, self.log, self.samples, self.scratch, no_rows(n), self.rules
            self._drive = drive.on(self.machine.step, self.machine.dense, self.motion, *watch)
            awaited(lambda: self._drive(0), "the loop is being compiled")
        self.integrator = copy.deepcopy(code.integrator) if self.machine is None else code.integrator

    def _put(self, lane: int, top: int, end: float) -> None:
        motion, start = self.motion, self.tops.start[:, top]
        motion.pars[:, lane] = self.pars[:, top]
        motion.state[:, lane] = 0.0
        motion.state[: len(start), lane] = start
        motion.high[lane] = motion.low[lane] = 0.0
        motion.end[lane] = end

    def load(self, lane: int, top: int, signs: np.ndarray, on_zero: np.ndarray) -> None:
        """Puts a top into a lane."""
        self._put(lane, top, self.tops.end[top])
        self.top[lane] = top
        reset(self.tallies, self.rows, lane, signs, on_zero)

    def park(self, lane: int) -> None:
        """Leaves a lane with a sound top at its end: it takes no steps."""
        self._put(lane, int(np.flatnonzero(self.tops.valid)[0]), 0.0)
        self.tallies.lane[lane]["status"] = Status.FINISHED.code
        self.top[lane] = -1

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
        """Steps until a top ends, or samples are to be looked at; lanes whose top has ended are left empty (-2)."""
        steps = self._by_heyoka() if self.machine is None else self._drive(ENDLESS)
        self.steps_possible += steps * self.lanes
        if self._is_full():
            self._look(observer)
        lane_of = self.tallies.lane
        for lane in np.flatnonzero((self.top >= 0) & (lane_of["status"] != Status.RUNNING.code)).tolist():
            if lane_of["status"][lane] == Status.SETTLED.code and not self._stays(lane):
                lane_of["status"][lane] = Status.RUNNING.code
                lane_of["doubted"][lane] = lane_of["lasts_since"][lane]
                continue
            self.steps_made += int(lane_of["steps"][lane])
            self.final[lane] = self._state_at_end(lane)
            observer.done(lane, STATUSES[int(lane_of["status"][lane])])
            self.top[lane] = -2

    def _by_heyoka(self) -> int:
        """The same where the machine code cannot be called: heyoka makes each step."""
        ta, motion, steps, ended = self.integrator, self.motion, 0, False
        ta.pars[:] = motion.pars
        while not ended and not self._is_full():
            begin_step(motion, self.tallies)
            ta.state[:] = motion.state
            ta.step(motion.limit.tolist(), write_tc=True)
            motion.h[:] = [step for _, step in ta.step_res]
            motion.state[:], motion.tc[:] = ta.state, ta.tc
            ended = end_step(motion, self.rows, self.rules, self.tallies, self.log, self.samples, self.scratch)
            steps += 1
        return steps

    def _is_full(self) -> bool:
        room = len(self.samples.top)
        return room > 0 and int(self.samples.filled[0]) + self.lanes > room

    def _stays(self, lane: int) -> bool:
        """Whether a top that has settled stays what it is."""
        top = self.top[[lane]]
        body = self.tops.body(lambda given: float(np.broadcast_to(given, (self.tops.n,))[top[0]]))
        state = self.motion.state[: len(self.tops.start), [lane]]
        return stays(body, values_of(self.tops, state, top), float(self.tops.unit(SECOND)[top[0]]))

    def _look(self, observer: Observer) -> None:
        count = int(self.samples.filled[0])
        if count:
            observer.look(self.samples.states[:count].T, self.samples.top[:count])
            self.samples.filled[0] = 0

    def _state_at_end(self, lane: int) -> np.ndarray:
        """The state in which a top ended, perhaps in the midst of a step."""
        tally, motion = self.tallies.lane[lane], self.motion
        if tally["upto"] == 1.0:
            return motion.state[:, lane]
        if self.machine is None:
            inside = float(tally["t"]) - motion.start_high[lane] - motion.start_low[lane]
            return np.polynomial.polynomial.polyval(inside, motion.tc[:, :, lane].T)
        dense_state(self.machine.dense, motion, np.full(self.lanes, tally["t"]), self.out)
        return self.out[:, lane]


def watched(rows: EventRows, base: Problem, wanted: Collection[str] | None) -> EventRows:
    """The events that columns named `wanted` need, None: all; what ends a top or settles it is always looked for.

    Parameters
    ----------
    rows
        All events of the system.
    base
        What the tops have in common.
    wanted
        Names of columns, and of groups of columns.

    Returns
    -------
    EventRows
        What is found of the others is the same, to the bit.
    """
    records = rows.events.copy()
    for record, event in zip(records, base.system.events, strict=True):
        if base.on_liftoff != "stop":  # then no event ends a run
            record["ends"] = 0
        if wanted is None:
            continue
        names = [kept.name for kept in event.kept] + (list(SWINGS) if event.sense else [])
        record["watched"] = bool(event.ends or event.lasting) or any(name in wanted for name in names)
        record["ranged"] &= any(f"{event.extremes}_{end}" in wanted for end in ("min", "max"))
    mark_bounded(records)
    return rows._replace(events=records)


def rules(base: Problem, every: int) -> StopRules:
    """When a top ends before its time, other than by an event; and how often it is sampled."""
    lasting = [i for i, event in enumerate(base.system.events) if event.lasting] if base.stop_when == "settled" else []
    way = base.system.events[lasting[0]].direction if lasting else 0
    return StopRules(lasting[0] if lasting else -1, way, SETTLED_FOR, MOST_STEPS, every, 0)
