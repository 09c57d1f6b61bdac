"""The event log of a run while it grows.

`Passages` of a `Slice` go in; out come rows of an `EventTable`, and marks of rows.

Zeros of event functions become rows immediately. Whether a turning or a lasting event is
significant is known only later: a turning counts once theta has come back from it by more than
rounding, so that one true turning which rounding splits into three counts once, and a decay that
ends in noise not at all. Such rows are marked when this is known.
"""

import math
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Column, counted
from ..engine.driver import Passages
from ..engine.loop import count_turnings
from ..engine.observables import Observables
from ..engine.settling import slides
from ..engine.tallies import Tallies
from ..errors import owner
from ..mechanics.event import Event, Kept
from ..mechanics.units import SECOND
from .events import EventTable, event_table


def settled_since(view: Observables, tally: Any, last: np.ndarray) -> float | None:
    """Return when the lasting event last happened [s]; None if it is over in state `last`.

    `view` are the observables of the run, `tally` the record of its counters, and `last`
    (1, variables) is internal.
    """
    since = float(tally["lasts_since"])
    if math.isnan(since):
        return None
    problem = view.problem
    event = next(event for event in problem.system.events if event.lasting)
    value = float(event.formula(view.moment(last[0]), view.body))
    # still on the side to which the event crossed 0, and nothing slides again
    if not value * event.direction > 0 or slides(problem.alone, last.T, [0]).any():
        return None
    return since * problem.unit(SECOND)


class EventLog:
    """Convert the zeros of slices to rows of the event table.

    `Integration` makes it, and calls `add_zeros` after each slice and `finish` at the end;
    `ensembles.top_events` does so for each top, with tallies that keep no numbers.

    The log covers 0 < t <= t_end, and what jumps log at t = 0: a run that starts on the zero of an
    event function does not find it, but one that starts where another run has ended does, if that
    one has not. Rows of turnings and of lasting events start as not significant; marks make them so
    later.

    Parameters
    ----------
    view
        The observables of the run.
    first
        The state at the start, (1, variables), internal.
    tallies
        Those of its driver, with one lane.
    """

    def __init__(self, view: Observables, first: np.ndarray, tallies: Tallies):
        """Number the events of the system, and start with an empty table."""
        problem = view.problem
        self.view = view
        self.second = problem.unit(SECOND)
        self.events = tuple(problem.system.events)
        self.tallies = tallies
        self.kinds = problem.system.kinds
        # in the order of the rows of `tallies.kept`: see `engine.tallies.event_rows`
        self.kept = [kept for event in self.events for kept in event.kept]
        logged = (event for event in self.events if event.name in problem.events)
        self.keeps_states = any(owner(event.formula) for event in logged)
        # by event
        self.is_logged = np.array([event.name in problem.events for event in self.events], bool)
        self.kind = np.array([self.kinds.index(event.name) for event in self.events], np.int8)
        self.senses = np.array([event.sense for event in self.events], int)
        self.lasts = np.array([event.lasting for event in self.events], bool)
        state = self._states(np.zeros(0), first[:0])
        self.empty = event_table(self.kinds, state)
        self.rows = 0
        self.counts = dict.fromkeys(self.kinds, 0)
        self.before = view.theta(first)  # theta where the present swing began
        # rows of the turning that waits, and of the last lasting event; -1: none
        self.waiting = self.lasting = -1

    # --- a slice ---------------------------------------------------------------------------------

    def add_zeros(self, zeros: Passages) -> tuple[EventTable, list[int], np.ndarray]:
        """Add the zeros of a slice.

        Returns
        -------
        EventTable, list of int, array
            New rows; rows, old or new, that are now known to be significant; states of the new
            rows (internal).
        """
        keep = self.is_logged[zeros.events]
        zeros = Passages(*(values[keep] for values in zeros))
        values = self.view.evaluate(zeros.states)
        kind = self.kind[zeros.events]
        theta = values["theta"].astype(float)
        seconds = zeros.times.astype(float) * self.second
        senses = self.senses[zeros.events]
        lasts = self.lasts[zeros.events]
        # +1 where theta' becomes positive, at a minimum of theta: see `Event.sense`
        rising = zeros.signs * senses
        turning = senses != 0
        rising = np.where(turning, rising, np.sign(values["theta_dot"].astype(float)))
        rising = rising.astype(np.int8)
        swing = np.full(theta.shape, np.nan)
        if len(angles := theta[turning]):
            swing[turning] = np.abs(angles - np.concatenate([[self.before], angles[:-1]]))
            self.before = float(angles[-1])
        for name, count in counted(kind, self.kinds).items():
            self.counts[name] += count
        state = self._states(seconds, zeros.states)
        is_known = ~(turning | lasts)  # the others may become significant later
        rows = seconds, kind, theta, rising, swing, is_known  # in the order of `event_table`
        table = event_table(self.kinds, state, rows)
        lasting = np.flatnonzero(lasts)
        if len(lasting):
            self.lasting = self.rows + int(lasting[-1])
        turnings = self.rows + np.flatnonzero(turning)
        self.rows += len(theta)
        ways = np.where(zeros.at_pole, 0, rising)[turning]
        return table, self._marks(turnings, ways, angles), zeros.states

    def _states(self, seconds: np.ndarray, states: np.ndarray) -> dict[str, Column]:
        """Return the columns of a trajectory at events, by name; {} without user-defined events.

        `seconds` are the times of the events [s], `states` (events, variables), internal.
        """
        if not self.keeps_states:
            return {}
        columns = self.view.columns(seconds, states)
        return {name: c._replace(dims=("event", *c.dims[1:])) for name, c in columns.items()}

    def _marks(self, rows: np.ndarray, signs: np.ndarray, theta: np.ndarray) -> list[int]:
        """Count turnings in the tally, and return the rows of those that are now confirmed.

        A turning is confirmed by a later one, so each call has an effect on those that follow.

        Parameters
        ----------
        rows, signs, theta
            (k,) Rows in the log, +1 for a minimum of theta and -1 for a maximum, and theta [rad].
            Sign 0, of a passage of a pole and of the end of a run (row -1), may confirm the turning
            that waits, and never waits itself; see `count_turnings`.
        """
        confirmed, waits = count_turnings(self.tallies.lane, signs, theta)
        waiting = np.maximum.accumulate(np.append(self.waiting, np.where(waits, rows, -1)))
        self.waiting = int(waiting[-1])
        return [row for row in waiting[:-1][confirmed].tolist() if row >= 0]

    # --- the end ---------------------------------------------------------------------------------

    def finish(self, last: np.ndarray) -> list[int]:
        """Return the rows that the end of the run, in the state `last`, shows to be significant.

        It also counts the turning that waits, in the tally. A longer run may decide otherwise:
        `resume` unmarks exactly `open_rows`, so no other row may be returned.
        """
        marks = []
        if self.tallies.lane["waiting"][0]:
            marks = self._marks(np.array([-1]), np.array([0]), np.array([self.view.theta(last)]))
        tally = self.tallies.lane[0]
        if self.lasting >= 0 and settled_since(self.view, tally, last) is not None:
            marks.append(self.lasting)
        return marks

    def open_rows(self) -> list[int]:
        """Return rows of the log that are not significant yet, and may be so in the end.

        `resume` removes their marks, which the end of a shorter run set: see `finish`.
        """
        waiting = self.waiting if self.tallies.lane["waiting"][0] else -1
        return [row for row in (waiting, self.lasting) if row >= 0]

    def note_at_start(self, event: Event) -> None:
        """Set the times that an event keeps to 0, because it happened at the start; logs no row."""
        is_time = [kept in event.kept and kept.what != "count" for kept in self.kept]
        self.tallies.kept[is_time, 0] = 0.0

    def numbers(self) -> list[tuple[Kept, float]]:
        """Return each Kept of the events with its number so far: an internal time, or a count."""
        return list(zip(self.kept, self.tallies.kept[:, 0].tolist(), strict=True))

    def snapshot(self) -> PlainData:
        """Return the data of a checkpoint, apart from the tallies; its keys are a stored format."""
        names = ("rows", "before", "waiting", "lasting")
        return {"counts": dict(self.counts), **{name: getattr(self, name) for name in names}}

    def restore(self, kept: PlainData) -> None:
        """Continue from a checkpoint: the inverse of `snapshot`, whose keys are attributes here."""
        vars(self).update(kept)
