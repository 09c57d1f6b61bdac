"""Many tops at once: lanes of a SIMD integrator, refilled from a queue as tops end.

No lane sees another: a top's numbers depend on its own only.
"""

from collections.abc import Callable, Collection
from typing import Protocol

import numpy as np

from ..awaiting import awaited
from ..engine.compiled import Compiled, compiled, stepper_of
from ..engine.loop import Loop, Queue, Tops, new_motion
from ..engine.observables import values_of
from ..engine.settling import SETTLED_FOR, slides, stays
from ..engine.status import Status
from ..engine.tallies import LANE_RECORD, EventRows, StopRules, mark_bounded, new_log, new_samples, new_tallies
from ..mechanics.units import SECOND
from ..problem import Problem, Problems


LANES = 8  # as fast as 32, and they compile in 1 s instead of 6
SAMPLES = 64  # of a lane, between two looks at the invariants: a look takes 0.2 ms whatever its length
EVERY = 32  # steps between two samples
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
MOST_DRIVEN = 8192  # steps between two looks of Python: 70 ms
SWINGS = ("turnings", "theta_min", "theta_max")  # columns that turnings give


class Observer(Protocol):
    """What `Lanes.run` tells."""

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Takes states (variables, k) that were sampled on the way, and whose they are, (k,)."""

    def ended(self, count: int) -> None:
        """So many more tops have ended."""


class Lanes:
    """The lanes of one integrator.

    Parameters
    ----------
    tops
        All that may run in them.
    lanes
        How many run at a time.
    wanted
        As in `ensemble.measure`.
    every
        Steps between two samples.
    """

    def __init__(self, tops: Problems, lanes: int = LANES, wanted: Collection[str] | None = None, every: int = EVERY):
        base = tops.base
        law, tolerance, orientation = base.friction.__class__, base.tolerance, tops.orientation
        code = awaited(
            lambda: compiled(base.system, base.form.name, law, "double", tolerance, lanes, False, orientation),
            "the equations are being compiled",
        )
        self.problems, self.lanes, self.rows = tops, lanes, watched(code.rows, base, wanted)
        n, order = len(code.integrator.state), code.integrator.order
        self.motion = new_motion(n, len(code.integrator.pars), order + 1, lanes)
        self.rules = rules(code, base, every)
        self.tallies, self.fresh = new_tallies(self.rows, lanes), new_tallies(self.rows, 1)
        drifts = wanted is None or any(name.startswith("drift") for name in wanted)
        self.samples = new_samples(SAMPLES * lanes if drifts else 0, n, lanes)
        self.top = self.samples.in_lane  # which top is in a lane
        self.queue = Queue(np.zeros(lanes, np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64))
        self.steps_possible = 0  # steps that the lanes could have made
        self._park()
        self.stepper = stepper_of(code)
        watch = self.rows, self.tallies, new_log(0, n), self.samples
        self.loop = Loop(self.motion, *watch, self.rules, self.stepper)

    def _park(self) -> None:
        """A sound top in every lane, at its end: it takes no steps."""
        motion, every = self.motion, self.problems
        top = int(np.flatnonzero(every.valid)[0])
        motion.pars[:] = every.pars[: len(motion.pars), [top]]  # the integrator has none beyond the last that it reads
        motion.state[: len(every.start)] = every.start[:, [top]]
        self.tallies.lane["status"], self.top[:] = Status.FINISHED.code, -1

    def run(self, tops: Tops, take: Callable[[int], np.ndarray], observer: Observer) -> None:
        """Runs tops to their ends: `take` gives numbers of some, for so many empty lanes, and not more than all."""
        self.loop.take(tops, self.queue, self.fresh)
        while True:
            if self.queue.waiting[0] == 0:
                numbers = take(int((self.top < 0).sum()))
                self.queue.tops[: len(numbers)] = numbers[::-1]
                self.queue.waiting[0] = len(numbers)
            if self.queue.waiting[0] == 0 and not (self.top >= 0).any():
                break
            self.steps_possible += self.loop.drive(MOST_DRIVEN) * self.lanes
            for lane in np.flatnonzero((self.top >= 0) & (self.tallies.lane["status"] == Status.SETTLED.code)).tolist():
                if not self._stays(lane):
                    self.tallies.lane["status"][lane] = Status.RUNNING.code
                    self.tallies.lane["doubted"][lane] = self.tallies.lane["lasts_since"][lane]
            observer.ended(int(self.queue.ended[0]))
            self.queue.ended[0] = 0
            if self._is_full():
                self._look(observer)
        self._look(observer)

    def _is_full(self) -> bool:
        room = len(self.samples.top)
        return room > 0 and int(self.samples.filled[0]) + self.lanes > room

    def _stays(self, lane: int) -> bool:
        """Whether a top that has settled stays what it is."""
        every, top = self.problems, self.top[[lane]]
        body = every.body(lambda given: float(np.broadcast_to(given, (every.n,))[top[0]]))
        state = self.motion.state[: len(every.start), [lane]]
        if slides(every, state, top).any():
            return False
        return stays(body, values_of(every, state, top), float(every.unit(SECOND)[top[0]]))

    def _look(self, observer: Observer) -> None:
        count = int(self.samples.filled[0])
        if count:
            observer.look(self.samples.states[:count].T, self.samples.top[:count])
            self.samples.filled[0] = 0


def new_tops(
    start: np.ndarray, pars: np.ndarray, until: np.ndarray, signs: np.ndarray, on_zero: np.ndarray, rows: EventRows
) -> Tops:
    """Tops that have not yet begun."""
    start, pars, until = (np.ascontiguousarray(column, float) for column in (start, pars, until))
    signs, on_zero = (np.ascontiguousarray(column, np.int8) for column in (signs, on_zero))
    functions, kept = np.zeros((3, len(rows.events), len(until))), np.zeros((len(rows.numbers), len(until)))
    lane, final = np.zeros(len(until), LANE_RECORD), np.full(start.shape, np.nan)
    return Tops(start, pars, until, signs, on_zero, lane, functions, kept, final)


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


def rules(code: Compiled, base: Problem, every: int) -> StopRules:
    """When a top ends before its time, other than by an event; and how often it is sampled."""
    return StopRules(code.lasting if base.stop_when == "settled" else -1, code.way, SETTLED_FOR, MOST_STEPS, every, 0)
