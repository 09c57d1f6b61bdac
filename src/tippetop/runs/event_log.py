"""The event log as it grows: zeros of a slice become rows, with what can only be known later as
marks on older rows.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..columns import Column
from ..engine.driver import Passages
from ..engine.loop import count_turnings
from ..engine.observables import Observables
from ..engine.settling import slides
from ..engine.tallies import Tallies
from ..mechanics.event import Event
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..problem import Problem
from ..scenario.identity import is_user_defined
from .events import EventTable


INVERSION = ("first_equator", "last_equator", "inverted_at")
"""The part of a report about the inversion, by the names of what events keep."""
UNREPORTED = ("equators", "lifted_at", "settled_at")
"""Kept numbers that no report repeats: its counts or its reason contain them."""


class Lines(NamedTuple):
    """Passages as the log has them, (k,) each."""

    states: np.ndarray  # (k, variables), internal
    seconds: np.ndarray  # [s]
    event: np.ndarray  # number of the event in its system
    kind: np.ndarray  # number of the kind, int8
    theta: np.ndarray  # [rad]
    rising: np.ndarray  # sign of theta' just after, int8
    at_pole: np.ndarray  # whether the axis passes a pole


class Known(NamedTuple):
    """Facts about the events of a system; the arrays are by event."""

    events: tuple[Event, ...]
    kinds: tuple[str, ...]
    empty: EventTable
    lasting: int  # number of the lasting event; -1: there is none
    kept: tuple[
        tuple[str, str], ...
    ]  # name and `what` of the kept numbers, in the order of the tallies
    numbers: np.ndarray  # of its kind, int8
    senses: np.ndarray
    is_logged: np.ndarray
    is_open: np.ndarray  # whether a row may become significant later


@lru_cache(maxsize=64)
def _known(system: System, logged: tuple[str, ...]) -> Known:
    every = tuple(system.events)
    return Known(
        every,
        system.kinds,
        EventTable.empty(system.kinds),
        next((number for number, event in enumerate(every) if event.lasting), -1),
        tuple((kept.name, kept.what) for event in every for kept in event.kept),
        np.array([system.kinds.index(event.name) for event in every], dtype=np.int8),
        np.array([event.sense for event in every], dtype=int),
        np.array([event.name in logged for event in every], dtype=bool),
        np.array([bool(event.sense or event.lasting) for event in every], dtype=bool),
    )


class LogReport(NamedTuple):
    """The events of a run so far: the rows of its log, and the tallies of its driver."""

    problem: Problem
    counts: dict[str, int]  # rows of the log, by kind
    tally: Any  # a record of the tallies
    numbers: np.ndarray  # what events keep, (kept,); internal

    @property
    def known(self) -> Known:
        """The events of the system."""
        return _known(self.problem.system, self.problem.events)

    def kept(self) -> dict[str, Any]:
        """Return the numbers that events keep, by name: times [s], None if the event did not
        happen, or counts.
        """
        values = zip(self.known.kept, self.numbers.tolist(), strict=True)
        second = float(self.problem.scales.of(SECOND))
        return {
            name: int(value) if what == "count" else None if math.isnan(value) else value * second
            for (name, what), value in values
        }

    def settled_since(self, view: Observables, last: np.ndarray) -> float | None:
        """Return when the lasting event last happened [s], if in the state `last`, (1, variables),
        it still holds.
        """
        since = float(self.tally["lasts_since"])
        if math.isnan(since):
            return None
        event = self.known.events[self.known.lasting]
        value = float(event.formula(view.moment(last[0]), view.body))
        if not value * event.direction > 0 or slides(view.problem.alone, last.T, [0]).any():
            return None
        return since * float(self.problem.scales.of(SECOND))

    def report(self) -> dict[str, Any]:
        """Return counts, inversion and band, as `info --json` has them, and the numbers that users'
        events keep.
        """
        tally, kept = self.tally, self.kept()
        counts = {name: n for name, n in self.counts.items() if n}
        if any(event.sense and event.name in counts for event in self.known.events):
            counts["turning_significant"] = int(tally["turnings"])
        band = {
            name: float(tally[name]) if tally["turnings"] else None
            for name in ("theta_min", "theta_max")
        }
        own = {name: value for name, value in kept.items() if name not in INVERSION + UNREPORTED}
        return {
            "event_counts": counts,
            "inversion": {name: kept.get(name) for name in INVERSION},
            "nutational_band": band,
            **({"kept": own} if own else {}),
        }


class EventLog:
    """Turns the zeros of slices into rows of the event table.

    An event at t = 0 is never logged: the log covers 0 < t <= t_end, and a run that starts on the
    zero of an event does not find it again. Rows of turnings and of lasting events start as not
    significant; marks make them so later.

    Parameters
    ----------
    problem
        The run.
    view
        Its observables.
    first
        The state at the start, (1, variables), internal.
    tallies
        Those of its driver, with one lane.
    """

    def __init__(self, problem: Problem, view: Observables, first: np.ndarray, tallies: Tallies):
        self.view, self.second = view, float(problem.scales.of(SECOND))
        self.known = known = _known(problem.system, problem.events)
        self.tallies, self.kinds = tallies, known.kinds
        logged = [event for event in known.events if event.name in problem.events]
        self.keeps_states = any(is_user_defined(event.formula) for event in logged)
        self.empty = replace(known.empty, state=self._states(np.zeros(0), first[:0]))
        self.rows = 0  # of the log
        self.counts = dict.fromkeys(self.kinds, 0)  # rows of the log
        self.before = view.theta(first)  # theta where the present swing began
        self.waiting = (
            self.lasting
        ) = -1  # rows of the turning that waits, and of the last lasting event; -1: none

    # --- a slice ---------------------------------------------------------------------------------

    def take(self, zeros: Passages) -> tuple[EventTable, list[int], np.ndarray]:
        """Return the rows of a slice, the rows (old or new) that are now known to be significant,
        and the states (internal) of the new rows.
        """
        keep = self.known.is_logged[zeros.events]
        if not keep.any():
            return self.empty, [], np.zeros((0, 0))
        logged = self._lines(Passages(*(values[keep] for values in zeros)))
        turning = self.known.senses[logged.event] != 0
        table = self._table(logged, turning)
        lasting = np.flatnonzero(logged.event == self.known.lasting)
        if len(lasting):
            self.lasting = self.rows + int(lasting[-1])
        rows = self.rows + np.flatnonzero(turning)
        self.rows += len(turning)
        ways = np.where(logged.at_pole, 0, logged.rising)[turning]
        return table, self._marks(rows, ways, logged.theta[turning]), logged.states

    def _lines(self, zeros: Passages) -> Lines:
        values = self.view.evaluate(zeros.states)
        turns = zeros.signs * self.known.senses[zeros.events]
        return Lines(
            zeros.states,
            zeros.times.astype(float) * self.second,
            zeros.events,
            self.known.numbers[zeros.events],
            values["theta"].astype(float),
            np.where(turns != 0, turns, np.sign(values["theta_dot"].astype(float))).astype(np.int8),
            zeros.at_pole,
        )

    def _table(self, logged: Lines, turning: np.ndarray) -> EventTable:
        """Rows of the log; the swings continue from the turning before."""
        swing = np.full(logged.theta.shape, np.nan)
        if len(angles := logged.theta[turning]):
            swing[turning] = np.abs(angles - np.concatenate([[self.before], angles[:-1]]))
            self.before = float(angles[-1])
        for number, count in enumerate(
            np.bincount(logged.kind, minlength=len(self.kinds)).tolist()
        ):
            self.counts[self.kinds[number]] += count
        known = ~self.known.is_open[logged.event]
        columns = logged.seconds, logged.kind, logged.theta, logged.rising, swing, known
        return EventTable(self.kinds, *columns, state=self._states(logged.seconds, logged.states))

    def _states(self, seconds: np.ndarray, states: np.ndarray) -> dict[str, Column]:
        """Return the columns of a trajectory at events, where the run logs user-defined ones."""
        if not self.keeps_states:
            return {}
        columns = self.view.columns(seconds, states)
        return {name: c._replace(dims=("event", *c.dims[1:])) for name, c in columns.items()}

    def _marks(self, rows: np.ndarray, signs: np.ndarray, theta: np.ndarray) -> list[int]:
        """Count turnings, and return the rows of those that are now confirmed."""
        confirmed, waits = count_turnings(self.tallies, signs, theta)
        waiting = np.maximum.accumulate(np.append(self.waiting, np.where(waits, rows, -1)))
        self.waiting = int(waiting[-1])
        return [row for row in waiting[:-1][confirmed].tolist() if row >= 0]

    # --- the end ---------------------------------------------------------------------------------

    def finish(self, last: np.ndarray) -> list[int]:
        """Return the rows that the end of the run, in the state `last`, shows to be significant."""
        waits = self.tallies.lane["waiting"][0]
        marks = (
            self._marks(np.array([-1]), np.array([0]), np.array([self.view.theta(last)]))
            if waits
            else []
        )
        if self.lasting >= 0 and self.summary().settled_since(self.view, last) is not None:
            marks = [*marks, self.lasting]
        return marks

    def open_rows(self) -> list[int]:
        """Return rows of the log that are not significant yet, and may be so in the end."""
        waiting = self.waiting if self.tallies.lane["waiting"][0] else -1
        return [row for row in (waiting, self.lasting) if row >= 0]

    def note_at_start(self, event: Event) -> None:
        """Keep that an event happened at the start."""
        names = [kept.name for kept in event.kept if kept.what != "count"]
        self.tallies.kept[[name in names for name, _ in self.known.kept], 0] = 0.0

    def summary(self) -> LogReport:
        """Return what is known so far of all events."""
        tally, numbers = self.tallies.lane[0].copy(), self.tallies.kept[:, 0].copy()
        return LogReport(self.view.problem, dict(self.counts), tally, numbers)

    def snapshot(self) -> dict[str, Any]:
        """Return what a checkpoint keeps beside the tallies."""
        names = ("rows", "before", "waiting", "lasting")
        return {"counts": dict(self.counts), **{name: getattr(self, name) for name in names}}

    def restore(self, kept: dict[str, Any]) -> None:
        """Continue from a checkpoint."""
        for name, value in kept.items():
            setattr(self, name, value)
