"""Integrate one run from start to end; slices go to a sink, the event log and the drift.

A `Problem` goes in; rows (times [s], internal states), events and tables go to a `Sink`, and
`progress()` returns the measurements. A slice is the steps that the driver makes in one call.
"""

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..engine.driver import STEPS_PER_SLICE, Driver, Extremes, Slice
from ..engine.integrator import compiling
from ..engine.observables import Observables
from ..engine.settling import SETTLED_FOR, stays
from ..engine.status import Status
from ..engine.taylor import driver_of, fingerprint
from ..mechanics.units import SECOND
from ..problem import Problem
from ..store import hexfloat
from . import keyframes
from .drift import Drift
from .event_log import EventLog, settled_since
from .phases import PhaseHistory
from .reporting import Progress, RunProgress
from .sinks import Sink


# Most rows that a sink takes in one call: 12 MB of 24 columns.
ROWS_PER_BLOCK = 1 << 16
WIDE = {"double": 1, "longdouble": 8, "quad": 64}
"""Time of a step, roughly, in those of doubles: slices have fewer wide steps, so that a run commits
and stops in time. A fixed count, not a time limit, keeps stores reproducible.
"""
SETTLED_SLICE, SETTLED_SLICE_OF_PHASES = 1024, 64
"""Steps between two checks whether a run has settled: the steps of a disc at rest are long."""


class Integration:
    """Integrate a run slice by slice, and measure it.

    It also implements `engine.driver.Request`, by which the driver gets the times of rows and hands
    the rows over.

    Parameters
    ----------
    problem
        The run.
    stop
        Raise Interrupted if this is set while the equations are compiled.
    driver
        That of the problem, at its start; by default it is made.

    Attributes
    ----------
    driver
        Makes the steps.
    first, last
        The state at the start and the last good one, (1, variables), internal.
    steps_made
        Steps since the start of the run, also of a run that was restored.
    t_end
        How far the run has come [s].
    status
        How it ended; None while it has not.
    seconds
        Times of compiling and of integrating.
    last_slice
        The state at the start of the last slice: a longer run continues from there.
    filled
        The number of rows that the sink has.
    fresh
        Whether no slice was made yet, here or before the run was restored.
    log, phases, drift, force
        Measurements so far: events, phases, drift of invariants, extremes of the normal force.
    """

    def __init__(
        self, problem: Problem, stop: threading.Event | None = None, driver: Driver | None = None
    ):
        """Compile the problem, unless a driver is passed, and begin at its start."""
        clock = time.perf_counter()
        self.problem = problem
        self.driver = driver or driver_of(problem, stop)
        self.seconds = {"compile": time.perf_counter() - clock, "integrate": 0.0}
        self.view = Observables(problem)
        self.settled_slice = SETTLED_SLICE_OF_PHASES if problem.system.is_hybrid else SETTLED_SLICE
        self.second = problem.unit(SECOND)
        self.first = self.last = self.driver.first
        self.drift = Drift(problem.alone, self.first.T)
        self.force = Extremes()
        self.steps_made = 0
        self.log = EventLog(self.view, self.first, self.driver.tallies)
        self.phases = PhaseHistory(dict(problem.system.tables.get("phases", {})))
        self.filled = 0
        self.t_end = 0.0
        self.fresh = True
        self.status: Status | None = None
        self.last_slice: dict[str, Any] | None = None

    def run(self, sink: Sink, progress: Progress | None = None) -> None:
        """Integrate to the end.

        Parameters
        ----------
        sink
            Receives rows and events; after each slice a snapshot corresponds to its rows.
        progress
            Called after every slice.

        Raises
        ------
        Interrupted
            If the sink does, between two slices.
        """
        problem = self.problem
        self.begin(sink)
        # rows at events and at steps include the start; times contain it if it is wanted
        if self.fresh and not self.filled and problem.output in ("events", "steps"):
            self._write(np.array([0.0]), self.first)
        while self.status is None:
            if sink.keeps_rows:
                self.last_slice = self._state()
            clock = time.perf_counter()
            before = compiling.seconds
            piece = self.driver.advance(self, self._steps())
            compiled = compiling.seconds - before  # phases, when they are first entered
            self.seconds["compile"] += compiled
            self.seconds["integrate"] += time.perf_counter() - clock - compiled
            if self.add_slice(piece) is None and self._has_settled():
                self.status = Status.SETTLED
                self._take_tables(self.driver.last_rows())
            if self.status is not None:
                break
            if problem.output == "keyframes" and self.steps_made % problem.keyframe_steps == 0:
                row = keyframes.columns(problem, self.driver, self.t_end, self.steps_made)
                sink.add_tables(
                    {"keyframes": {name: column.values for name, column in row.items()}}
                )
            present = self.progress()
            sink.slice_done(present, self.snapshot)
            if progress is not None:
                progress(present)
        self.fill()
        sink.add_events(self.log.empty, self.log.finish(self.last))  # marks only
        if problem.output == "events":
            self._write(np.array([self.t_end]), self.last)

    def part(self, sink: Sink, steps: int, more: Callable[[], bool]) -> None:
        """Integrate a part of a run, in slices of `steps` steps, as long as `more()` is true.

        Nothing is committed, and no progress reported: `run` does both. Replays and `cost` call it.
        """
        self.begin(sink)
        while self.status is None and more():
            self.add_slice(self.driver.advance(self, steps))
        self.fill()

    def begin(self, sink: Sink) -> None:
        """Connect the run to a sink, which gets rows from now on; call it before any slice.

        It sets `status`: how the run ends at its start, or None.
        """
        # `requested`: rows whose times the driver has; the sink has the first `filled` of them
        self.sink, self.requested = sink, self.filled
        self.rows_at_steps, self.at_times = (
            sink.keeps_rows and self.problem.output == output for output in ("steps", "times")
        )
        self.status = self._ended_at_start() if self.fresh else None

    def _steps(self) -> int:
        """Return the number of steps of the next slice, up to a multiple of the usual numbers.

        Multiples are counted from the start of the run, so that slices, and hence bits, do not
        depend on where a run was continued.
        """
        problem = self.problem
        most = [max(1, STEPS_PER_SLICE // WIDE[problem.precision])]
        if problem.stop_when == "settled":
            most.append(self.settled_slice)
        if problem.output == "keyframes":
            most.append(problem.keyframe_steps)
        return min(steps - self.steps_made % steps for steps in most)

    def _ended_at_start(self) -> Status | None:
        """Return how a run ends before its first step, or None: a force is negative at its start.

        It logs the event, and sets `force`.
        """
        if self.driver.ended is not None:
            return self.driver.ended
        events = self.problem.system.events
        for event, value in zip(events, self.driver.at_start, strict=True):
            if self.problem.on_liftoff == "stop" and event.ends and event.extremes and value < 0:
                self.log.note_at_start(event)
                self.force = Extremes(value, 0.0, value, 0.0)
                return Status.of_event(event.ends)
        return None

    def _has_settled(self) -> bool:
        """Return whether a run that ends once it has settled has done so.

        It looks after every `settled_slice` steps only: a later look would end the run elsewhere.
        """
        if self.problem.stop_when != "settled" or self.steps_made % self.settled_slice:
            return False
        since = settled_since(self.view, self.driver.tally, self.last)
        if since is None or not self.t_end - since > SETTLED_FOR * self.second:
            return False
        return stays(self.problem, self.view.evaluate(self.last))

    # --- rows ------------------------------------------------------------------------------------

    def next_times(self) -> np.ndarray:
        """Return the internal times of the next rows; see `Request.next_times`.

        For rows at the ends of steps the array is only room for them: its numbers do not count.
        """
        if self.rows_at_steps:
            return np.empty(ROWS_PER_BLOCK)
        if not self.at_times:
            return np.zeros(0)
        times = self.problem.times[self.requested : self.requested + ROWS_PER_BLOCK]
        self.requested += len(times)
        return times / self.second

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Pass rows at these internal times, (k,), to the sink; `states` are (k, variables).

        Rows at given times get the times of the problem [s], which were not rounded by conversion.
        """
        rows = slice(self.filled, self.filled + len(times))
        self._write(times * self.second if self.rows_at_steps else self.problem.times[rows], states)

    def fill(self) -> None:
        """Write the rows up to the end of the run that lie in no step, with the last good state."""
        if not self.at_times:
            return
        times = self.problem.times[self.filled : self.problem.times.count(self.t_end)]
        if len(times):
            self._write(times, np.repeat(self.last, len(times), axis=0))

    def _write(self, times: np.ndarray, states: np.ndarray) -> None:
        """Pass rows to the sink and count them: times [s], (k,), internal states (k, variables)."""
        self.sink.add_rows(times, states)
        self.filled += len(times)

    # --- slices ----------------------------------------------------------------------------------

    def add_slice(self, piece: Slice) -> Status | None:
        """Measure and log a slice; return how it ended the run, or None.

        Slices must come in the order of time, once each: all measurements are sums so far. The rows
        of the slice are in the sink already (`add_rows`); rows at its events, or at an end within a
        step (`upto` < 1), are added here. Afterwards the run is no longer `fresh`: it has left its
        start, so that `begin` does not end it there.

        Drift is measured at samples and at the end of the run, but not at the ends of slices, so
        that it does not depend on their number.
        """
        self.status = piece.status
        self.last = piece.last
        self.fresh = False
        self.t_end = float(piece.time) * self.second
        seen = piece.samples if self.status is None else np.concatenate([piece.samples, piece.last])
        if len(seen):
            self.drift.look(seen.T, np.zeros(len(seen), int))
        self.force = self.driver.extremes()
        self.steps_made += piece.steps
        self._take_tables(piece.tables)
        table, marks, states = self.log.add_zeros(piece.passages)
        self.sink.add_events(table, marks)
        if self.problem.output == "steps" and self.driver.tally["upto"] < 1.0:  # within a step
            self._write(np.array([self.t_end]), self.last)
        elif self.problem.output == "events" and len(table.time):
            self._write(table.time, states)
        return self.status

    def _take_tables(self, tables: dict) -> None:
        """Pass rows of phases and impacts, by table and column, to the sink and `phases`."""
        self.phases.add(tables)
        self.sink.add_tables(tables)

    def progress(self) -> RunProgress:
        """Return the present progress and measurements as an immutable record."""
        return RunProgress(
            self.problem,
            self.status,
            self.t_end,
            self.steps_made,
            self.last,
            self._worst(),
            self.force,
            dict(self.log.counts),
            self.driver.tally.copy(),
            self.log.numbers(),
            self.phases.report() if self.problem.system.tables else None,
            self.driver.sentence,
        )

    def _worst(self) -> dict[str, float]:
        """Return the worst drift so far, by invariant."""
        return {name: float(worst[0]) for name, worst in self.drift.worst.items()}

    # --- snapshots -------------------------------------------------------------------------------

    def snapshot(self) -> PlainData:
        """Return the data from which the run continues bit by bit, as plain JSON data."""
        return self._encoded(self._state())

    def ending(self) -> dict[str, Any]:
        """Return states from which a run can continue: at the start of the last slice, and last.

        The end has shortened the last step, so a longer run repeats the last slice from its start.
        Another run may start from the last state, with the `joint`, unless an event ended this one.
        The keys are a stored format: `resume` reads `slice`, `starting` reads `end`.
        """
        end = {"state": self.last[0], "t_end": self.t_end}
        if self.status in (Status.FINISHED, Status.SETTLED):
            end["joint"] = self.driver.joint(event.name for event in self.problem.system.events)
        return {"slice": self.last_slice, "end": end}

    def encoded(self, ending: dict[str, Any]) -> PlainData:
        """Return an ending, as `ending` returns it, as plain JSON data with exact numbers.

        `slice` is empty in a run without a slice, which ended at its start.
        """
        start = ending["slice"]
        end = hexfloat.encode(ending["end"])
        return {"slice": self._encoded(start) if start else {}, "end": end}

    def _state(self) -> dict[str, Any]:
        """Return what decides how the run continues: of the driver, the monitors and the log.

        The keys are a stored format, which `restore` reads; `log` and `story` have those of
        `EventLog.snapshot` and `PhaseHistory.report`.
        """
        return {
            "driver": self.driver.snapshot(),
            "filled": self.filled,
            "t_end": self.t_end,
            "monitor": {
                "drift": self._worst(),
                "force": list(self.force),
                "steps": self.steps_made,
            },
            "log": self.log.snapshot(),
            "story": self.phases.report(),
        }

    def _encoded(self, state: dict[str, Any]) -> PlainData:
        """Return a state, as `_state` returns it, as plain JSON data for `restore`.

        It includes the fingerprint of the equations, by which `restore` rejects others.
        """
        return hexfloat.encode({"equations": fingerprint(self.driver), **state})

    def restore(self, kept: PlainData) -> None:
        """Continue from a snapshot, before any slice was made: the inverse of `snapshot`.

        Raises ValueError if it was made with other equations.
        """
        if kept["equations"] != fingerprint(self.driver):
            raise ValueError("the equations must be those of the checkpoint, but are others here")
        number = self.problem.number
        state = hexfloat.decode(kept)
        if state["t_end"] == 0:  # before the first slice: as it is
            return
        exact = {
            name: np.array([hexfloat.from_hex(text, number) for text in texts], dtype=number)
            for name, texts in kept["driver"].items()
            if name in keyframes.EXACT
        }
        self.driver.restore(state["driver"] | exact, exact["state"], tuple(exact["time"]))
        self.last = self.driver.present()
        self.filled = state["filled"]
        self.t_end = state["t_end"]
        self.fresh = False
        for name, worst in state["monitor"]["drift"].items():
            self.drift.worst[name][:] = worst
        self.force = Extremes(*state["monitor"]["force"])
        self.steps_made = state["monitor"]["steps"]
        self.log.restore(state["log"])
        self.phases = PhaseHistory(self.phases.words, **state["story"])

    def start_at_keyframe(self, row: dict[str, np.ndarray]) -> None:
        """Continue from a keyframe, before any slice was made; measurements and log begin anew.

        `row` is a row of the table of keyframes by column: numbers, SI.
        """
        keyframes.restore(self.driver, row)
        self.last = self.driver.present()
        self.t_end = float(row["time"])
        self.fresh = False
        self.steps_made = int(row["step"])
