"""One run from start to end: slices go to a sink, the drift monitor and the event log; the end gets
a status.
"""

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..engine.driver import STEPS_PER_SLICE, Extremes, Slice
from ..engine.observables import Observables
from ..engine.settling import SETTLED_FOR, stays
from ..engine.status import Status
from ..engine.taylor import driver_of, fingerprint
from ..mechanics.units import SECOND
from ..problem import Problem
from ..store import hexfloat
from . import keyframes
from .drift import Monitor
from .event_log import EventLog
from .phases import Story
from .reporting import RunProgress
from .sinks import Sink


ROWS_PER_BLOCK = 1 << 16  # 12 MB of 24 columns: what a sink takes at once
SETTLED_SLICE, SETTLED_SLICE_OF_PHASES = 1024, 64
"""Steps between two looks whether a run has settled: the steps of a disc at rest are long."""

State = dict[str, Any]


class Integration:
    """A run between its start and its end: all that an interruption must not lose.

    Parameters
    ----------
    problem
        What is integrated.

    Attributes
    ----------
    driver
        Makes the steps; its state is the last of the run, in internal units.
    last
        The last good state, (1, variables), internal.
    t_end
        How far the run has come [s].
    status
        How it ended; None while it has not.
    seconds
        Where the time went: compile, integrate.
    """

    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        clock = time.perf_counter()
        self.problem, self.driver = problem, driver_of(problem, stop)
        self.seconds = {"compile": time.perf_counter() - clock, "integrate": 0.0}
        self.view = Observables(problem)
        self.settled_slice = SETTLED_SLICE_OF_PHASES if problem.system.is_hybrid else SETTLED_SLICE
        self.second = float(problem.scales.of(SECOND))
        self.first = self.driver.first
        self.last = self.first  # last good state
        self.monitor = Monitor(problem, self.view)
        self.monitor.begin(self.first)
        self.log = EventLog(problem, self.view, self.first, self.driver.tallies)
        self.story = Story(dict(problem.system.tables.get("phases", {})))
        self.filled, self.t_end, self.fresh = 0, 0.0, True
        self.status: Status | None = None
        self.last_slice: State | None = (
            None  # where the last slice began: a longer run continues from there
        )

    def run(self, sink: Sink, progress: Callable[[RunProgress], None] | None = None) -> None:
        """Continues to the end.

        What the sink has taken after a slice is what a snapshot then stands for.

        Parameters
        ----------
        sink
            Takes rows and events as they come.
        progress
            Called after every slice.

        Raises
        ------
        Interrupted
            If the sink does, between two slices.
        """
        problem, request = self.problem, Request(self, sink)
        if self.fresh and not self.filled and problem.output in ("events", "steps"):
            self.write(sink, np.array([0.0]), self.first)
        self.status = self.ended_at_start() if self.fresh else None
        while self.status is None:
            if sink.keeps_rows:
                self.last_slice = self._state()
            clock, before = time.perf_counter(), request.seconds
            piece = self.driver.advance(request, self._steps())
            self.seconds["integrate"] += time.perf_counter() - clock - (request.seconds - before)
            self.fresh = False
            if self.follow(piece, sink) is not None:
                break
            if (
                problem.stop_when == "settled"
                and self._done_of(self.settled_slice) == 0
                and self._settled_long()
            ):
                self.status = Status.SETTLED
                break
            if problem.output == "keyframes" and self._done_of(problem.keyframe_steps) == 0:
                sink.keyframe(
                    keyframes.columns(problem, self.driver, self.t_end, self.monitor.steps)
                )
            present = self.progress()
            sink.slice_done(present, self.snapshot)
            if progress is not None:
                progress(present)
        self.fill(sink)
        sink.events(self.log.empty, self.log.finish(self.last))
        if problem.output == "events":
            self.write(sink, np.array([self.t_end]), self.last)

    def part(self, sink: Sink, steps: int, more: Callable[[], bool]) -> None:
        """Make slices of `steps` steps while `more()`: the rows of a part of a run, or a
        measurement.
        """
        request = Request(self, sink)
        self.status = self.ended_at_start() if self.fresh else None
        while self.status is None and more():
            self.follow(self.driver.advance(request, steps), sink)
            self.fresh = False
        self.fill(sink)

    def _steps(self) -> int:
        """The steps of the next slice: up to a multiple of what one has, so that nothing depends on
        where it began.
        """
        problem = self.problem
        most = self.settled_slice if problem.stop_when == "settled" else STEPS_PER_SLICE
        left = most - self._done_of(most)
        if problem.output != "keyframes":
            return left
        return min(left, problem.keyframe_steps - self._done_of(problem.keyframe_steps))

    def _done_of(self, steps: int) -> int:
        """How many steps were made since the last multiple of so many."""
        return self.monitor.steps % steps

    def ended_at_start(self) -> Status | None:
        """How a run ends before its first step: a quantity that must not be negative is so from the
        start.
        """
        if self.driver.ended is not None:
            return self.driver.ended
        events = self.problem.system.events
        for event, value in zip(events, self.driver.at_start, strict=True):
            if self.problem.on_liftoff == "stop" and event.ends and event.extremes and value < 0:
                self.log.note_at_start(event)
                self.monitor.force = Extremes(value, 0.0, value, 0.0)
                return Status.of_event(event.ends)
        return None

    def follow(self, piece: Slice, sink: Sink) -> Status | None:
        """Takes in a slice; gives how it ended the run, or None.

        Of its states the samples count, and the end of the run: where a slice ends does not show.
        """
        self.status, self.last = piece.status, piece.last
        self.t_end = float(piece.time) * self.second
        seen = piece.samples if self.status is None else np.concatenate([piece.samples, piece.last])
        self.monitor.follow(seen, self.driver.extremes(), piece.steps)
        self.story.follow(piece.tables)
        sink.tables(piece.tables)
        table, marks, states = self.log.take(piece.passages)
        sink.events(table, marks)
        if (
            self.problem.output == "steps" and self.driver.tally["upto"] < 1.0
        ):  # it ended in the midst of a step
            self.write(sink, np.array([self.t_end]), self.last)
        elif self.problem.output == "events" and len(table.time):
            self.write(sink, table.time, states)
        return self.status

    def fill(self, sink: Sink) -> None:
        """Rows at the end of the run that no step has: the last good state."""
        if self.problem.output != "times" or not sink.keeps_rows:
            return
        upto = self.problem.times.count(self.t_end, inclusive=True)
        if upto > self.filled:
            times = self.problem.times[self.filled : upto]
            self.write(sink, times, np.repeat(self.last, len(times), axis=0))

    def write(self, sink: Sink, times: np.ndarray, states: np.ndarray) -> None:
        """Gives rows to a sink: times [s], internal states."""
        sink.rows(times, lambda: states)
        self.filled += len(times)

    def _settled_long(self) -> bool:
        since = self.log.summary().settled_since(self.view, self.last)
        if since is None or not self.t_end - since > SETTLED_FOR * self.second:
            return False
        return stays(self.problem.body(), self.view.evaluate(self.last), self.second)

    def progress(self) -> RunProgress:
        """Return how far the run has come."""
        return RunProgress(
            self.problem,
            self.status,
            self.t_end,
            self.monitor.steps,
            self.last,
            dict(self.monitor.drift),
            self.monitor.force,
            self.log.summary(),
            self.story.report() if self.problem.system.tables else None,
            self.driver.sentence,
            not self.driver.is_called,
        )

    def snapshot(self) -> dict[str, Any]:
        """All that is needed to continue bit by bit, as plain JSON data."""
        return self._encoded(self._state())

    def ending(self) -> dict[str, Any]:
        """What the store of a finished run keeps for those who continue it, as plain JSON data: the
        last slice's beginning, which no end has shortened, and the end.
        """
        end = hexfloat.encode({"state": self.last[0], "t_end": self.t_end})
        return {"slice": self._encoded(self.last_slice) if self.last_slice else {}, "end": end}

    def _state(self) -> State:
        return {
            "driver": self.driver.snapshot(),
            "filled": self.filled,
            "t_end": self.t_end,
            "monitor": self.monitor.snapshot(),
            "log": self.log.snapshot(),
            **({"story": self.story.snapshot()} if self.problem.system.tables else {}),
        }

    def _encoded(self, state: State) -> dict[str, Any]:
        return hexfloat.encode({"equations": fingerprint(self.driver), **state})

    def restore(self, kept: dict[str, Any]) -> None:
        """Continue from a snapshot.

        Parameters
        ----------
        kept
            What `snapshot` gave.

        Raises
        ------
        ValueError
            If it was made of other equations.
        """
        number, driver = self.problem.number, kept["driver"]
        if kept["equations"] != fingerprint(self.driver):
            raise ValueError("the equations must be those of the checkpoint, but are others here")
        exact = {
            name: np.array([hexfloat.from_hex(text, number) for text in driver[name]], dtype=number)
            for name in ("state", "time", "carried")
            if name in driver
        }
        rest = {name: hexfloat.decode(value) for name, value in driver.items() if name not in exact}
        self.driver.restore(rest | exact, exact["state"], tuple(exact["time"]))
        self.last = self.driver.present()
        self.filled, self.t_end = kept["filled"], hexfloat.decode(kept["t_end"])
        self.monitor.restore(hexfloat.decode(kept["monitor"]))
        self.fresh = self.t_end == 0  # it was killed before its first slice
        self.log.restore(hexfloat.decode(kept["log"]))
        if "story" in kept:
            self.story = Story(self.story.words, **hexfloat.decode(kept["story"]))

    def take_up(self, row: dict[str, np.ndarray]) -> None:
        """Continue from a keyframe; what is measured and logged begins anew there.

        Parameters
        ----------
        row
            Of each column the values of one keyframe of the same problem.
        """
        keyframes.restore(self.driver, row)
        self.last = self.driver.present()
        self.t_end, self.fresh = float(row["time"]), False
        self.monitor.steps = int(row["step"])


class Request:
    """The rows that the sink of an integration wants."""

    def __init__(self, integration: Integration, sink: Sink):
        self.integration, self.sink = integration, sink
        self.steps = integration.problem.output == "steps" and sink.keeps_rows
        self.asked, self.seconds = integration.filled, 0.0

    def wanted(self) -> np.ndarray:
        """Internal times of the next rows, or room for so many."""
        integration = self.integration
        if self.steps:
            return np.empty(ROWS_PER_BLOCK)
        if integration.problem.output != "times" or not self.sink.keeps_rows:
            return np.zeros(0)
        times = integration.problem.times[
            self.asked : self.asked + ROWS_PER_BLOCK
        ]  # a step may hold more than memory
        self.asked += len(times)
        return times / integration.second

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Takes rows that were made."""
        integration, clock = self.integration, time.perf_counter()
        filled = integration.filled
        seconds = (
            times * integration.second
            if self.steps
            else integration.problem.times[filled : filled + len(times)]
        )
        integration.write(self.sink, seconds, states)
        self.seconds += time.perf_counter() - clock
