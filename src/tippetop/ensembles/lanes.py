"""Integrate the tops of a queue in SIMD lanes on one thread; see `engine.pools`.

Numbers of tops come from a queue; their outcomes go to the common `Outcomes`. The slot of a top is
its number, the index in all arrays.
"""

import threading
from collections.abc import Callable, Collection, Iterator
from itertools import islice
from typing import Any

import numpy as np

from ..engine.driver import Workspace
from ..engine.expressions import formulas_of
from ..engine.loop import MOST_COEFFICIENTS, count_turnings
from ..engine.observables import Observables, values_of
from ..engine.pools import HybridPools, Pools, Tops
from ..engine.settling import SETTLED_FOR, slides, stays
from ..engine.status import Status
from ..engine.tallies import EventRows, Rules, looked_for, new_log
from ..engine.taylor import compiled_when
from ..problem import Problem, Problems
from ..runs.event_log import settled_since
from .hybrid_tops import problem_of
from .outcomes import SWINGS, Outcomes


ROOM = 512
"""Tops under way on a thread, enough for full lanes in every phase."""
MOST_DRIVEN = 512
"""Steps between two looks of Python: at most 12 ms."""
# of a lane, between two looks at the invariants, which take 0.2 ms: half of them at most
SAMPLES = 128
EVERY = 32  # steps between two samples
MOST_STEPS = 2_000_000  # of one top: a canonical one makes 143 a second


class PoolOfOne(Pools):
    """The only pool of a system of one phase.

    Parameters
    ----------
    tops
        All tops that may enter it.
    wanted, events, most
        As in `ensemble.measure`.
    """

    def __init__(
        self,
        tops: Problems,
        wanted: Collection[str] | None,
        *,
        events: bool,
        most: int,
    ):
        """Compile the equations, select the events to find, and allocate samples and log."""
        base = tops.base
        formulas = formulas_of(base.system, base.form.name, base.friction.__class__)
        code = compiled_when((formulas, "double", base.tolerance, self.lanes, tops.orientation))

        def reads(*names: str) -> bool:
            """Return whether all columns are wanted, or one that begins with one of these names."""
            return wanted is None or any(name.startswith(names) for name in wanted)

        rows = watched(code.rows, base, reads)
        self.code = code
        width = len(code.integrator.state)
        # zeros that a step may find: at least the room that `is_full` in loop.c wants
        logged = self.lanes * len(rows.events) * MOST_COEFFICIENTS
        self.all_events = rows
        self.variables = len(tops.start)
        self.samples = new_log(SAMPLES * self.lanes if reads("drift") else 0, width, row=int)
        # twice, as `run_tops` empties it when it is half full; without events it has no room
        self.log = new_log(2 * logged * events, width)
        settled_for = SETTLED_FOR if base.stop_when == "settled" else np.inf
        self.rules = Rules(settled_for, most, EVERY, 0)

    def join(self, tops: Tops, thread: int) -> None:
        """Set the arrays of the tops, and add the pool; see `Pools.share`.

        `new_tops` reads log and events of a pool before, so that these are made by `__init__`.
        """
        self.share(tops, thread)
        self.found = self.of_tops, self.log, self.samples
        self.workspace = Workspace(self, self.code, self.all_events)
        self.add_pool(0, self.workspace.loop, range(len(self.workspace.motion.pars)))

    def rows_of(self, phases: np.ndarray, states: np.ndarray, slots: np.ndarray) -> np.ndarray:
        """Return states of tops as rows (k, variables), without the padding of the integrator.

        The phases and slots are parameters for `HybridDriver.rows_of` only.
        """
        return states[:, : self.variables]


def run_tops(
    outcomes: Outcomes,
    pools: Any,
    ended: Callable[[], None],
    room: int,
    stop: threading.Event,
    queue: Iterator[int],
) -> None:
    """Integrate tops of a common queue on one thread, and write their outcomes.

    Parameters
    ----------
    outcomes
        A row per top; the rows of tops that end here are written.
    pools
        The `PoolOfOne` or `HybridPools` of this thread, with the arrays of all tops.
    ended
        Called whenever a top has ended.
    room
        Number of tops that may be under way; more than ROOM counts as ROOM.
    stop
        Set it to return soon, whether the tops have ended or not.
    queue
        Numbers of tops, which threads share.
    """
    is_hybrid = isinstance(pools, HybridPools)
    room = min(room, ROOM)
    under_way = 0
    done = list[int]()
    is_more = True
    while not stop.is_set():
        over = list[int]()
        if is_more and under_way <= 0.75 * room:
            new = np.array([*islice(queue, room - under_way)], int)
            under_way += len(new)
            is_more = under_way == room  # otherwise the queue is empty
            over = pools.start(new)
            if is_hybrid:  # the first phase begins after a jump
                outcomes.begin(pools.rows_in(new).T, new)
        if not under_way:
            break
        others, looks = pools.step(MOST_DRIVEN)
        over += others
        for top in looks:
            if _stays(outcomes.tops, pools, top):
                over.append(top)
                continue
            if not is_hybrid:  # no look at every step: `settled_every` is 1, in phases 64
                pools.of_tops.lane["lasts_since"][top] = np.nan
            pools.push(top)
        for _ in over:
            ended()
        under_way -= len(over)
        done += over
        if any(2 * some.filled[0] > len(some.states) for some in (pools.log, pools.samples)):
            _look(outcomes, pools)
    _look(outcomes, pools)
    _write(outcomes, pools, np.array(done, int))


def _stays(tops: Problems, pools: Any, top: int) -> bool:
    """Return whether a top that may have settled has done so for good.

    `top` is one of the `looks` of `Pools.step`, which is not in a queue: `run_tops` pushes it again
    if not.
    """
    problem = problem_of(tops, top)
    view = Observables(problem)
    last = pools.rows_in(np.array([top]))
    is_settled = settled_since(view, pools.of_tops.lane[top], last) is not None
    return is_settled and stays(problem, view.evaluate(last))


def _look(outcomes: Outcomes, pools: Any) -> None:
    """Compare the invariants of sampled states with the start, and empty samples and log.

    The loop stops where they may have no room for a step: `run_tops` calls this when one is half
    full, and at the end. The zeros of the log become `passages`, for `top_events`.
    """
    if count := int(pools.samples.filled[0]):
        # a row of samples is top times phases plus phase, see `Pools`
        tops, phases = np.divmod(pools.samples.rows[:count], len(pools.pools))
        rows = pools.rows_of(phases, pools.samples.states[:count], tops)
        outcomes.look(rows.T, tops)
        pools.samples.filled[0] = 0
    if count := int(pools.log.filled[0]):
        found = pools.log.rows, pools.log.states
        outcomes.passages.append(tuple(array[:count].copy() for array in found))
        pools.log.filled[0] = 0


def _write(outcomes: Outcomes, pools: Any, tops: np.ndarray) -> None:
    """Write the rows of `outcomes` of these tops, which have ended, in internal units.

    `tops` are those of one thread; invalid ones among them get a status and a fault. As
    `hybrid_tops._run` for tops run alone: a change of one is a change of both.
    """
    is_hybrid = isinstance(pools, HybridPools)
    problems = outcomes.tops
    columns = outcomes.columns
    status = pools.of_tops.lane["status"][tops]
    outcomes.status[tops] = status
    for top, sentence in pools.failures.items():
        outcomes.refuse(top, sentence)
    tops = tops[status != Status.INVALID.code]
    final = pools.rows_in(tops).T
    outcomes.final[:, tops] = final
    if is_hybrid:
        outcomes.look(final, tops)
    rows = pools.rows
    place, row = np.nonzero(np.isfinite(rows.states[tops, :, 0]))
    made = tops[place], row
    # `Rows.phases` has the `in_lane` of the top: top times phases plus phase
    phases = rows.phases[made] % len(pools.pools)
    outcomes.rows[made] = pools.rows_of(phases, rows.states[made], tops[place])

    theta = values_of(problems, final, tops)["theta"]
    # the end of a run, sign 0, decides on the turning that waits; [top:] begins with its tally
    for top, angle in zip(tops.tolist(), theta, strict=True):
        count_turnings(pools.of_tops.lane[top:], np.zeros(1), angle)
    tallies = pools.of_tops.lane[tops]
    columns["t_end"][tops] = tallies["t"]
    # `steps` of a record are those of earlier phases, see `TOP_RECORD`
    columns["steps"][tops] = pools.tops["steps"][tops] + tallies["steps"]
    for name in SWINGS:
        columns[name][tops] = tallies[name]

    functions = pools.of_tops.functions[:, tops]
    kept = iter(pools.of_tops.kept[:, tops])  # in the order of events, see `tallies.event_rows`
    settled = ~slides(problems, final, tops)
    if is_hybrid:
        settled &= ~np.isnan(tallies["lasts_since"])
    for k, event in enumerate(problems.base.system.events):
        if event.lasting:
            settled &= functions["sign"][k] * event.direction > 0
        for number in event.kept:
            values = next(kept)
            if event.lasting and number.what != "count":  # it did not last to the end
                values[~settled] = np.nan
            columns[number.name][tops] = values
    outcomes.settled[tops] = settled
    outcomes.lasts_since[tops] = tallies["lasts_since"]
    events = pools.all_events.events
    names = dict(enumerate(event.extremes for event in problems.base.system.events))
    for k in np.flatnonzero(events["extremes"]).tolist():
        # in the scale of the coefficients, as in `Driver.extremes`; a change of one is one of both
        values = functions["extremes"][k].T / events["scale"][k]
        for end, best, found in zip(("min", "max"), (np.fmin, np.fmax), values, strict=True):
            column = columns[f"{names.get(k) or 'normal_force'}_{end}"]
            # each phase may have its own function of the normal force
            column[tops] = best(column[tops], found)


def watched(rows: EventRows, base: Problem, reads: Callable[..., bool]) -> EventRows:
    """Return the events of a system, with those marked that a run in lanes has to find.

    They end or settle a top, are wanted, or are needed by a column.

    Parameters
    ----------
    rows
        All events of the system, in its order.
    base
        The base of the tops.
    reads
        reads(*names) -> whether a column, or an event, is wanted whose name begins like one of
        these.
    """
    watches = []
    ranges = []
    for event in base.system.events:
        names = [event.name, *(kept.name for kept in event.kept)]
        names += SWINGS if event.sense else ()  # its zeros are turnings, which give them
        watches.append(bool(event.ends or event.lasting) or reads(*names))
        ranges.append(reads(f"{event.extremes}_min", f"{event.extremes}_max"))
    return looked_for(rows, watches, ranges, stops=base.on_liftoff == "stop")
