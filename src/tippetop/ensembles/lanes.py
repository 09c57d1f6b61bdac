"""Many tops at once: lanes of a SIMD integrator, refilled from a queue as tops end.

No lane sees another: a top's numbers depend on its own only.
"""

import threading
from collections.abc import Callable, Collection, Iterator

import numpy as np

from ..engine.expressions import formulas_of
from ..engine.loop import MOST_COEFFICIENTS, Loop, new_motion
from ..engine.observables import values_of
from ..engine.settling import SETTLED_FOR, slides, stays
from ..engine.status import Status
from ..engine.tallies import (
    EventRows,
    Rules,
    Tallies,
    looked_for,
    new_log,
    new_samples,
    new_tallies,
)
from ..engine.taylor import compiled_when
from ..problem import Problem, Problems
from .hybrid_tops import problem_of
from .outcomes import SWINGS, Outcomes


LANES = 8  # as fast as 32, and they compile in 1 s instead of 6
# of a lane, between two looks at the invariants: a look takes 0.2 ms whatever its length
SAMPLES = 64
EVERY = 32  # steps between two samples
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second
MOST_DRIVEN = 8192  # steps between two looks of Python: 70 ms


class Lanes:
    """The lanes of one integrator.

    Parameters
    ----------
    tops
        All that may run in them.
    lanes
        How many run at a time.
    wanted, events
        As in `ensemble.measure`.

    Attributes
    ----------
    stop
        Set it to end `run` soon, whether its tops have ended or not.
    """

    def __init__(
        self,
        tops: Problems,
        lanes: int,
        wanted: Collection[str] | None = None,
        *,
        events: bool = False,
    ):
        base = tops.base
        formulas = formulas_of(base.system, base.form.name, base.friction.__class__)
        code = compiled_when((formulas, "double", base.tolerance, lanes, tops.orientation))

        def reads(*names: str) -> bool:
            return wanted is None or any(name.startswith(names) for name in wanted)

        self.problems = tops
        self.lanes = lanes
        self.stop = threading.Event()
        self.rows = watched(code.rows, base, reads)
        n = len(code.integrator.state)
        self.motion = new_motion(n, len(code.integrator.pars), code.integrator.order + 1, lanes)
        self.tallies = new_tallies(self.rows, np.ones((len(self.rows.events), lanes)))
        self.samples = new_samples(SAMPLES * lanes if reads("drift") else 0, n)
        self.top = self.motion.in_lane  # which top is in a lane; -1: none, and it takes no steps
        self.tallies.lane["status"], self.top[:] = Status.FINISHED.code, -1
        settled_for = SETTLED_FOR if base.stop_when == "settled" else np.inf
        rules = Rules(settled_for, MOST_STEPS, EVERY, 0)
        # twice what a step may find
        room = 2 * lanes * len(self.rows.events) * MOST_COEFFICIENTS
        self.log = new_log(room if events else 0, n)
        found = self.tallies, self.log, self.samples
        self.loop = Loop(self.motion, self.rows, *found, rules, code.machine)

    def run(
        self,
        outcomes: Outcomes,
        tallies: Tallies,
        queue: Iterator[int],
        ended: Callable[[], None],
    ) -> None:
        """Run tops to their ends.

        Parameters
        ----------
        outcomes
            Gets the last states, and looks at states that were sampled on the way.
        tallies
            Of all tops: those of their starts become those of their ends.
        queue
            Numbers of those that run; threads may share it.
        ended
            Called whenever a top has ended.
        """
        samples = self.samples
        status = self.tallies.lane["status"]
        final = outcomes.final
        while True:
            for lane in np.flatnonzero(status != Status.RUNNING.code).tolist():
                top, self.top[lane] = int(self.top[lane]), next(queue, -1)
                if top >= 0:
                    final[:, top] = self.loop.end(lane)[: len(final)]
                    for mine, of_tops in zip(self.tallies, tallies, strict=True):
                        of_tops.T[top] = mine.T[lane]
                    ended()
                if self.top[lane] >= 0:
                    self._take(tallies, lane)
            idle = bool((self.top < 0).all())
            count = int(samples.filled[0])
            if count and (idle or count + self.lanes > len(samples.top)):
                outcomes.look(samples.states[:count].T, samples.top[:count])
                samples.filled[0] = 0
            if idle or self.stop.is_set():
                return
            self.loop.drive(MOST_DRIVEN)
            if len(self.log.rows):
                logged = slice(self.log.filled[0])
                outcomes.passages.append(
                    (self.log.rows[logged].copy(), self.log.states[logged].copy())
                )
                self.log.filled[0] = 0
            for lane in np.flatnonzero((self.top >= 0) & (status == Status.SETTLED.code)).tolist():
                if not self._stays(lane):
                    status[lane] = Status.RUNNING.code
                    self.tallies.lane["lasts_since"][lane] = np.nan

    def _take(self, tallies: Tallies, lane: int) -> None:
        """Put a top into a lane. Integrals of event functions, which its start does not contain,
        begin at zero.
        """
        every = self.problems
        motion = self.motion
        top = int(self.top[lane])
        variables = len(every.start)
        motion.state[:variables, lane] = every.start[:, top]
        motion.state[variables:, lane] = 0.0
        motion.pars[:, lane] = every.pars[: len(motion.pars), top]
        motion.high[lane] = motion.low[lane] = 0.0
        motion.end[lane] = every.end[top]
        for mine, of_tops in zip(self.tallies, tallies, strict=True):
            mine.T[lane] = of_tops.T[top]

    def _stays(self, lane: int) -> bool:
        """Return whether a top that has settled stays as it is."""
        tops = self.problems
        top = self.top[[lane]]
        state = self.motion.state[: len(tops.start), [lane]]
        alone = problem_of(tops, int(top[0]))
        return not slides(tops, state, top).any() and stays(alone, values_of(tops, state, top))


def watched(rows: EventRows, base: Problem, reads: Callable[..., bool]) -> EventRows:
    """Return the events that end or settle a top, that are wanted, or that columns need.

    Parameters
    ----------
    rows
        All events of the system.
    base
        The base of the tops.
    reads
        reads(*names) -> whether a column, or an event, is wanted whose name begins like one of
        these.

    Returns
    -------
    EventRows
        These events are found with the same bits.
    """
    watches = []
    ranges = []
    for event in base.system.events:
        names = [event.name, *(kept.name for kept in event.kept)]
        names += SWINGS if event.sense else ()
        watches.append(bool(event.ends or event.lasting) or reads(*names))
        ranges.append(reads(f"{event.extremes}_min", f"{event.extremes}_max"))
    return looked_for(rows, watches, ranges, stops=base.on_liftoff == "stop")
