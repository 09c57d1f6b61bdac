"""Tops whose contact may change its phase, in pools of lanes; see `engine.pools`."""

import threading
from collections.abc import Callable, Iterator

import numpy as np

from ..engine.loop import count_turnings
from ..engine.observables import Observables, values_of
from ..engine.pools import Pools
from ..engine.settling import slides, stays
from ..engine.status import Status
from ..engine.tallies import Tallies
from ..errors import InputError
from ..mechanics.units import SECOND
from ..runs.event_log import LogReport
from .hybrid_tops import faults_of, problem_of
from .outcomes import SWINGS, Outcomes


ROOM, ROWS = 512, 1 << 18
"""Tops under way on a thread, enough for full lanes in every phase, and their rows, 50 MB."""
MOST_DRIVEN = 512
"""Steps between two looks of Python: 10 ms."""


class HybridLanes:
    """The pools of one thread.

    Parameters
    ----------
    outcomes
        A row per top; gets those of all tops that end here.
    ended
        Called whenever a top has ended.

    Attributes
    ----------
    alone
        Tops that must run alone, from their start.
    """

    def __init__(self, outcomes: Outcomes, ended: Callable[[], None]):
        self.outcomes = outcomes
        self.tops = outcomes.tops
        self.ended = ended
        self.stop = threading.Event()
        self.alone: list[int] = []
        self.pools: Pools | None = None
        row_count = outcomes.times.shape[1]
        self.room = min(ROOM, max(ROOM // 8, ROWS // max(1, row_count)))
        self.top_in = np.full(self.room, -1)
        self.under_way = 0
        self.steps = self.possible = 0  # of lanes: made, and possible

    def run(self, queue: Iterator[int]) -> None:
        """Run tops of a queue, which threads may share, to their ends."""
        free = list(range(self.room))
        done = list[int]()  # slots of tops that have ended
        is_more = True
        while not self.stop.is_set():
            if not self.under_way or (is_more and len(free) + len(done) >= self.room / 4):
                self._look()
                self._write(np.array(done, int))
                free += done
                done = []
                self._begin(queue, free)
                is_more = not free
            pools = self.pools
            if pools is None or not self.under_way:
                return
            ended, looks = pools.step(MOST_DRIVEN)
            for slot in looks:
                if self._stays(slot):
                    pools.tallies_of["status"][slot] = Status.SETTLED.code
                    ended.append(slot)
                else:
                    pools.push(slot)
            for _ in ended:
                self.ended()
            self.under_way -= len(ended)
            done += ended
            self.possible = pools.record.possible
            if pools.samples.filled[0] > len(pools.samples.top) / 2:
                self._look()

    def _begin(self, queue: Iterator[int], free: list[int]) -> None:
        """Begin as many tops as there are slots."""
        begun = []
        while free and not self.stop.is_set() and (top := next(queue, -1)) >= 0:
            problem = problem_of(self.tops, top)
            try:
                if faults := faults_of(problem):
                    raise InputError(faults)
                if self.pools is None:
                    row_count = self.outcomes.times.shape[1]
                    self.pools = Pools(problem, self.room, self.stop, row_count)
                fits = self.pools.begin_top(free[-1], problem, self.outcomes.times[top])
            except InputError as error:
                self.outcomes.status[top] = Status.INVALID.code
                self.outcomes.faults.append((top, error.sentences[0]))
                self.ended()
                continue
            if fits:
                begun.append(free.pop())
                self.top_in[begun[-1]] = top
            else:
                self.alone.append(top)
        if begun and self.pools is not None:
            slots = np.array(begun)
            self.outcomes.begin(self.pools.rows_in(slots).T, self.top_in[slots])
        self.under_way += len(begun)

    def _stays(self, slot: int) -> bool:
        """Return whether a top that may have settled has, and stays as it is."""
        pools = self.pools
        assert pools is not None
        problem = pools.problems[slot]
        view = Observables(problem)
        some = np.array([slot])
        last = pools.rows_in(some)
        second = float(problem.scales.of(SECOND))
        tally = pools.tallies_of[slot]
        log = LogReport(tuple(problem.system.events), second, {}, tally, [])
        is_settled = log.settled_since(view, last) is not None
        return is_settled and stays(problem, view.evaluate(last))

    # --- rows of tops ----------------------------------------------------------------------------

    def _look(self) -> None:
        """Compare the invariants of the states that were sampled."""
        pools = self.pools
        if pools is None or not (count := int(pools.samples.filled[0])):
            return
        slots, phases = np.divmod(pools.samples.top[:count], len(pools.phases))
        rows = pools.rows_at(phases, pools.samples.states[:count], slots)
        self.outcomes.look(rows.T, self.top_in[slots])
        pools.samples.filled[0] = 0

    def _write(self, slots: np.ndarray) -> None:
        """Write the rows of tops that have ended."""
        pools = self.pools
        outcomes = self.outcomes
        columns = outcomes.columns
        if pools is None or not len(slots):
            return
        status = pools.tallies_of["status"][slots]
        outcomes.status[self.top_in[slots]] = status
        for slot in slots[status == Status.INVALID.code].tolist():
            outcomes.faults.append((int(self.top_in[slot]), pools.failures[slot]))
        slots = slots[status != Status.INVALID.code]
        tops = self.top_in[slots]
        final = pools.rows_in(slots).T
        outcomes.look(final, tops)
        outcomes.final[:, tops] = final
        place, row = np.nonzero(np.isfinite(pools.rows.states[slots, :, 0]))
        outcomes.rows[tops[place], row] = pools.rows_made(slots[place], row)
        theta = values_of(self.tops, final, tops)["theta"]
        for k in np.flatnonzero(pools.tallies_of["waiting"][slots]).tolist():
            lane = pools.tallies_of[slots[k] : slots[k] + 1]
            count_turnings(Tallies(lane, lane, lane), np.zeros(1), theta[[k]])
        tallies = pools.tallies_of[slots]
        steps = pools.tops["steps"][slots] + tallies["steps"]
        columns["t_end"][tops] = tallies["t"]
        columns["steps"][tops] = steps
        for name in SWINGS:
            columns[name][tops] = tallies[name]
        kept = iter(pools.kept_of[slots].T)
        events = pools.all_events.events
        settled = np.zeros(len(slots), bool)
        for k, event in enumerate(self.tops.base.system.events):
            for number in event.kept:
                columns[number.name][tops] = next(kept)
            if event.lasting:
                side = pools.functions_of["sign"][slots, k] * event.direction
                settled = (side > 0) & ~np.isnan(tallies["lasts_since"])
                settled &= ~slides(self.tops, final, tops)
        outcomes.settled[tops] = settled
        is_force = events["extremes"]
        forces = pools.functions_of["extremes"][slots][:, is_force]
        forces /= events["scale"][is_force, None]
        columns["normal_force_min"][tops] = forces[..., 0].min(axis=1, initial=np.inf)
        columns["normal_force_max"][tops] = forces[..., 1].max(axis=1, initial=-np.inf)
        self.steps += int(steps.sum())
