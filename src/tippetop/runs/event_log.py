"""The event log as it grows: zeros of a slice become rows, with what can only be known later as marks on older rows."""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..columns import Column
from ..engine.observables import Observables
from ..engine.settling import slides
from ..engine.slices import Passages
from ..mechanics.events import Event
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..problem import Problem
from ..scenario.own_records import is_users
from .events import Confirmation, EventTable


INVERSION = ("first_equator", "last_equator", "inverted_at")
"""What a report says of the inversion, by the names of what events keep."""
UNREPORTED = ("equators", "lifted_at", "settled_at")
"""What no report says apart: its counts, its reason do."""


class Lines(NamedTuple):
    """Passages as the log has them, (k,) each."""

    states: np.ndarray  # (k, variables), internal
    seconds: np.ndarray  # [s]
    event: np.ndarray  # number of the event in its system
    kind: np.ndarray  # number of the kind, int8
    sign: np.ndarray  # of the crossing
    theta: np.ndarray  # [rad]
    rising: np.ndarray  # sign of theta' just after, int8
    at_pole: np.ndarray  # whether the axis passes a pole

    def where(self, keep: np.ndarray) -> "Lines":
        """Some of them."""
        if keep.all():
            return self
        return Lines(*(values[keep] for values in self))


class Known(NamedTuple):
    """What a log knows of the events of a system; the arrays are by event."""

    events: dict[str, Event]
    kinds: tuple[str, ...]
    empty: EventTable
    lasting: list[Event]
    kept: dict[str, Any]  # what events keep, before any has happened
    numbers: np.ndarray  # of its kind, int8
    senses: np.ndarray
    is_logged: np.ndarray
    is_open: np.ndarray  # whether a row may become significant later


@lru_cache(maxsize=64)
def _known(system: System, logged: tuple[str, ...]) -> Known:
    every = list(system.events)
    return Known(
        {event.name: event for event in every},
        system.kinds,
        EventTable.empty(system.kinds),
        [event for event in every if event.lasting],
        {k.name: 0 if k.what == "count" else None for event in every for k in event.kept},
        np.array([system.kinds.index(event.name) for event in every], dtype=np.int8),
        np.array([event.sense for event in every], dtype=int),
        np.array([event.name in logged for event in every], dtype=bool),
        np.array([bool(event.sense or event.lasting) for event in every], dtype=bool),
    )


@dataclass
class Tally:
    """What a run keeps of its events, whatever it logs. Times in seconds, angles in radians; None: did not happen."""

    before: float  # theta where the present swing began
    rows: int = 0  # of the log
    counts: dict[str, int] = field(default_factory=dict)  # rows of the log, by kind
    confirmed: int = 0  # turnings that are more than rounding
    theta_min: float | None = None  # their band
    theta_max: float | None = None
    kept: dict[str, Any] = field(default_factory=dict)  # what events keep, by name
    lasting: dict[str, list] = field(default_factory=dict)  # by kind: row (-1: not logged) and time of its last passage


class EventLog:
    """Turns the zeros of slices into rows of the event table, and keeps the tally that a run reports.

    An event at t = 0 is never logged: the log covers 0 < t <= t_end, and a run that starts on the zero of an event does
    not find it again. Rows of turnings and of lasting events start as not significant; marks make them so later.
    """

    def __init__(self, problem: Problem, view: Observables, first: np.ndarray):
        self.view, self.second = view, float(problem.scales.of(SECOND))
        self.known = known = _known(problem.system, problem.events)
        self.events, self.kinds, self.lasting = known.events, known.kinds, known.lasting
        logged = [event for event in problem.system.events if event.name in problem.events]
        self.keeps_states = any(is_users(event.formula) for event in logged)
        self.empty = replace(known.empty, state=self._states(np.zeros(0), first[:0]))
        self.confirmation = Confirmation()
        self.tally = Tally(
            before=view.theta(first),
            counts=dict.fromkeys(self.kinds, 0),
            kept=known.kept.copy(),
        )

    def _value(self, kind: str, state: np.ndarray) -> float:
        """The function of an event in a state (variables,), internal units."""
        return float(self.events[kind].formula(self.view.moment(state), self.view.body))

    # --- a slice --------------------------------------------------------------------------------------------------

    def take(self, zeros: Passages) -> tuple[EventTable, list[int], np.ndarray]:
        """Rows of a slice, indices of rows (old or new) that are now known to be significant, and the states (internal)
        of the new rows."""
        if not len(zeros.times):
            return self.empty, [], np.zeros((0, 0))
        passages = self._lines(zeros)
        keep = self.known.is_logged[passages.event]
        self._remember(passages, np.where(keep, self.tally.rows + np.cumsum(keep) - 1, -1))
        logged = passages.where(keep)
        turning = self.known.senses[logged.event] != 0
        table = self._table(logged, turning)
        rows = self.tally.rows + np.flatnonzero(turning)
        self.tally.rows += len(turning)
        ways = np.where(logged.at_pole, 0, logged.rising)[turning]
        confirmed = self.confirmation.take(rows, logged.theta[turning], ways)
        return table, self._marks(confirmed), logged.states

    def _lines(self, zeros: Passages) -> Lines:
        values = self.view.evaluate(zeros.states)
        turns = zeros.signs * self.known.senses[zeros.events]
        return Lines(
            zeros.states,
            zeros.times.astype(float) * self.second,
            zeros.events,
            self.known.numbers[zeros.events],
            zeros.signs,
            values["theta"].astype(float),
            np.where(turns != 0, turns, np.sign(values["theta_dot"].astype(float))).astype(np.int8),
            zeros.at_pole,
        )

    def _remember(self, passages: Lines, rows: np.ndarray) -> None:
        """What events keep of their passages, whatever kinds are logged; `rows` are those of the log, or -1."""
        happened = set(passages.event.tolist())
        for number, event in enumerate(self.events.values()):
            if number not in happened or not (event.kept or event.lasting):
                continue
            mine = passages.event == number
            for kept in event.kept:
                meant = mine & (passages.sign == kept.direction) if kept.direction else mine
                self._keep(kept.name, kept.what, passages.seconds[meant])
            if event.lasting:
                last = int(np.flatnonzero(mine)[-1])
                self.tally.lasting[event.name] = [int(rows[last]), float(passages.seconds[last])]

    def _keep(self, name: str, what: str, seconds: np.ndarray) -> None:
        if what == "count":
            self.tally.kept[name] += len(seconds)
        elif len(seconds) and (what == "last" or self.tally.kept[name] is None):
            self.tally.kept[name] = float(seconds[-1 if what == "last" else 0])

    def _table(self, logged: Lines, turning: np.ndarray) -> EventTable:
        """Rows of the log; the swings continue from the turning before."""
        swing = np.full(logged.theta.shape, np.nan)
        if len(angles := logged.theta[turning]):
            swing[turning] = np.abs(angles - np.concatenate([[self.tally.before], angles[:-1]]))
            self.tally.before = float(angles[-1])
        for number, count in enumerate(np.bincount(logged.kind, minlength=len(self.kinds)).tolist()):
            self.tally.counts[self.kinds[number]] += count
        known = ~self.known.is_open[logged.event]
        columns = logged.seconds, logged.kind, logged.theta, logged.rising, swing, known
        return EventTable(self.kinds, *columns, state=self._states(logged.seconds, logged.states))

    def _states(self, seconds: np.ndarray, states: np.ndarray) -> dict[str, Column]:
        """Return the columns of a trajectory at events, where the run logs user-defined ones."""
        if not self.keeps_states:
            return {}
        columns = self.view.columns(seconds, states)
        return {name: c._replace(dims=("event", *c.dims[1:])) for name, c in columns.items()}

    def _marks(self, confirmed: list[tuple[int, float]]) -> list[int]:
        """Adds confirmed turnings to the band; gives their rows."""
        if not confirmed:
            return []
        angles, tally = [theta for _, theta in confirmed], self.tally
        tally.theta_min = min(angles) if tally.theta_min is None else min(tally.theta_min, *angles)
        tally.theta_max = max(angles) if tally.theta_max is None else max(tally.theta_max, *angles)
        tally.confirmed += len(confirmed)
        return [row for row, _ in confirmed]

    # --- the end --------------------------------------------------------------------------------------------------

    def settled_since(self, last: np.ndarray) -> float | None:
        """When the lasting event last happened [s], if in the state `last`, (1, variables), it still holds."""
        times = [self.tally.lasting[event.name][1] for event in self.lasting if self._holds(event, last)]
        return max(times) if times and len(times) == len(self.lasting) else None

    def _holds(self, event: Event, last: np.ndarray) -> bool:
        """Whether a lasting event has happened, and its function is still beyond its zero."""
        beyond = event.name in self.tally.lasting and self._value(event.name, last[0]) * event.direction > 0
        return beyond and not slides(self.view.problem.alone, last.T, [0]).any()

    def finish(self, last: np.ndarray) -> list[int]:
        """Rows that the end of the run, in the state `last`, shows to be significant."""
        marks = self._marks(self.confirmation.reached(self.view.theta(last)))
        rows = [self.tally.lasting[event.name][0] for event in self.lasting if self._holds(event, last)]
        return [*marks, *(row for row in rows if row >= 0)]

    def open_rows(self) -> list[int]:
        """Rows of the log that are not significant yet, and may be so in the end."""
        waiting = [self.confirmation.row] if self.confirmation.sign else []
        return [row for row in (*waiting, *(row for row, _ in self.tally.lasting.values())) if row >= 0]

    def report(self) -> dict[str, Any]:
        """Counts, inversion and band, as `info --json` has them; and what events of a system's own keep."""
        tally = self.tally
        counts = {name: n for name, n in tally.counts.items() if n}
        if any(event.sense and event.name in counts for event in self.events.values()):
            counts["turning_significant"] = tally.confirmed
        own = {name: value for name, value in tally.kept.items() if name not in INVERSION + UNREPORTED}
        return {
            "event_counts": counts,
            "inversion": {name: tally.kept.get(name) for name in INVERSION},
            "nutational_band": {"theta_min": tally.theta_min, "theta_max": tally.theta_max},
            **({"kept": own} if own else {}),
        }

    def snapshot(self) -> dict[str, Any]:
        """What a checkpoint keeps."""
        waiting, tally = self.confirmation, self.tally
        tables = {
            "counts": dict(tally.counts),
            "kept": dict(tally.kept),
            "lasting": {name: list(last) for name, last in tally.lasting.items()},
        }
        return {"tally": vars(tally) | tables, "waiting": [waiting.row, waiting.theta, waiting.sign]}

    def restore(self, kept: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self.tally = Tally(**kept["tally"])
        self.confirmation.row, self.confirmation.theta, self.confirmation.sign = kept["waiting"]
