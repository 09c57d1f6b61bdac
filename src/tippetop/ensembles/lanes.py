"""Many tops at once: lanes of a SIMD integrator, refilled from a queue as tops end.

No lane sees another: a top's numbers depend on its own only.
"""

from collections.abc import Callable, Collection

import numpy as np

from ..engine.expressions import formulas_of
from ..engine.integrator import stepper_of
from ..engine.loop import Loop, Queue, Tops, new_motion
from ..engine.observables import values_of
from ..engine.settling import SETTLED_FOR, slides, stays
from ..engine.status import Status
from ..engine.tallies import (
    LANE_RECORD,
    EventRows,
    StopRules,
    looked_for,
    new_log,
    new_samples,
    new_tallies,
)
from ..engine.taylor import compiled_when
from ..mechanics.event import Event
from ..mechanics.units import SECOND
from ..problem import Problem, Problems


LANES = 8  # as fast as 32, and they compile in 1 s instead of 6
# of a lane, between two looks at the invariants: a look takes 0.2 ms whatever its length
SAMPLES = 64
EVERY = 32  # steps between two samples
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
MOST_DRIVEN = 8192  # steps between two looks of Python: 70 ms
SWINGS = ("turnings", "theta_min", "theta_max")  # columns that turnings give


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

    def __init__(
        self,
        tops: Problems,
        lanes: int = LANES,
        wanted: Collection[str] | None = None,
        every: int = EVERY,
    ):
        base = tops.base
        formulas = formulas_of(base.system, base.form.name, base.friction.__class__)
        code = compiled_when((formulas, "double", base.tolerance, lanes, tops.orientation))
        self.problems, self.lanes, self.rows = tops, lanes, watched(code.rows, base, wanted)
        n, order = len(code.integrator.state), code.integrator.order
        self.motion = new_motion(n, len(code.integrator.pars), order + 1, lanes)
        self.tallies, self.fresh = new_tallies(self.rows, lanes), new_tallies(self.rows, 1)
        drifts = wanted is None or any(name.startswith("drift") for name in wanted)
        self.samples = new_samples(SAMPLES * lanes if drifts else 0, n, lanes)
        self.top = self.samples.in_lane  # which top is in a lane; -1: none, and it takes no steps
        self.tallies.lane["status"], self.top[:] = Status.FINISHED.code, -1
        self.steps_possible = 0  # steps that the lanes could have made
        self.stepper = stepper_of(code)
        lasting = code.lasting if base.stop_when == "settled" else -1
        rules = StopRules(lasting, code.way, SETTLED_FOR, MOST_STEPS, every, 0)
        self.loop = Loop(
            self.motion, self.rows, self.tallies, new_log(0, n), self.samples, rules, self.stepper
        )

    def run(
        self,
        tops: Tops,
        queue: np.ndarray,
        taken: np.ndarray,
        look: Callable[[np.ndarray, np.ndarray], None],
        ended: Callable[[int], None],
    ) -> None:
        """Run tops to their ends.

        Parameters
        ----------
        tops
            All of them.
        queue
            Numbers of those that run.
        taken
            (1,) how many of them were taken, by this and other threads.
        look
            look(states, tops) takes states (variables, k) that were sampled on the way, and whose
            they are, (k,).
        ended
            ended(count): `count` more tops have ended.
        """
        done = np.zeros(1, np.int64)
        self.loop.take(tops, Queue(queue, taken, done, len(queue)), self.fresh)
        samples, status, idle = self.samples, self.tallies.lane["status"], False
        while not idle:
            self.steps_possible += self.loop.drive(MOST_DRIVEN) * self.lanes
            idle, count = bool((self.top < 0).all()), int(samples.filled[0])
            if count and (idle or count + self.lanes > len(samples.top)):
                look(samples.states[:count].T, samples.top[:count])
                samples.filled[0] = 0
            for lane in np.flatnonzero((self.top >= 0) & (status == Status.SETTLED.code)).tolist():
                if not self._stays(lane):
                    status[lane] = Status.RUNNING.code
                    self.tallies.lane["doubted"][lane] = self.tallies.lane["lasts_since"][lane]
            ended(int(done[0]))
            done[0] = 0

    def _stays(self, lane: int) -> bool:
        """Return whether a top that has settled stays as it is."""
        every, top = self.problems, self.top[[lane]]
        body = every.body(lambda given: float(np.broadcast_to(given, (every.n,))[top[0]]))
        state = self.motion.state[: len(every.start), [lane]]
        if slides(every, state, top).any():
            return False
        return stays(body, values_of(every, state, top), float(every.unit(SECOND)[top[0]]))


def new_tops(
    start: np.ndarray,
    pars: np.ndarray,
    until: np.ndarray,
    signs: np.ndarray,
    on_zero: np.ndarray,
    rows: EventRows,
) -> Tops:
    """Return tops before their first step."""
    start, pars, until = (np.ascontiguousarray(column, float) for column in (start, pars, until))
    signs, on_zero = (np.ascontiguousarray(column, np.int8) for column in (signs, on_zero))
    functions, kept = (
        np.zeros((3, len(rows.events), len(until))),
        np.zeros((len(rows.numbers), len(until))),
    )
    lane, final = np.zeros(len(until), LANE_RECORD), np.full(start.shape, np.nan)
    return Tops(start, pars, until, signs, on_zero, lane, functions, kept, final)


def watched(rows: EventRows, base: Problem, wanted: Collection[str] | None) -> EventRows:
    """Return the events that the wanted columns need.

    All if `wanted` is None. Events that end or settle a top are always included.

    Parameters
    ----------
    rows
        All events of the system.
    base
        The base of the tops.
    wanted
        Names of columns, and of groups of columns.

    Returns
    -------
    EventRows
        These events are found with the same bits.
    """
    events, stops = base.system.events, base.on_liftoff == "stop"  # else no event ends a run
    if wanted is None:
        return looked_for(rows, [True] * len(events), stops=stops)

    def watches(event: Event) -> bool:
        names = [kept.name for kept in event.kept] + (list(SWINGS) if event.sense else [])
        return bool(event.ends or event.lasting) or any(name in wanted for name in names)

    def ranges(event: Event) -> bool:
        return any(f"{event.extremes}_{end}" in wanted for end in ("min", "max"))

    return looked_for(rows, map(watches, events), map(ranges, events), stops=stops)
