"""One run from start to end: slices go to a sink, the drift monitor and the event log; the end gets a status."""

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..engine.driver import STEPS_PER_SLICE, Extremes, Slice
from ..engine.observables import Observables
from ..engine.settling import CLASSES, SETTLED_FOR, classes_of, stays, with_phases
from ..engine.status import Status
from ..engine.taylor import driver_of, fingerprint
from ..mechanics.events import Event
from ..mechanics.units import SECOND
from ..problem import Problem
from ..scenario.own_records import is_users
from ..store import hexfloat
from . import keyframes
from .drift import Monitor
from .event_log import EventLog
from .phases import Story
from .sinks import Sink


ROWS_PER_BLOCK = 1 << 16  # 12 MB of 24 columns: what a sink takes at once
SETTLED_SLICE = 1024  # steps between two looks whether a run has settled

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
        self.second = float(problem.scales.of(SECOND))
        self.first = self.driver.first
        self.last = self.first  # last good state
        self.monitor = Monitor(problem, self.view)
        self.monitor.begin(self.first)
        self.log = EventLog(problem, self.view, self.first, self.driver.tallies)
        self.story = Story()
        self.filled, self.t_end, self.fresh = 0, 0.0, True
        self.status: Status | None = None
        self.last_slice: State | None = None  # where the last slice began: a longer run continues from there

    def run(self, sink: Sink, progress: Callable[["Integration"], None] | None = None) -> None:
        """Continues to the end. What the sink has taken after a slice is what a snapshot then stands for.

        Parameters
        ----------
        sink
            Takes rows and events as they come.
        progress
            Called with this integration after every slice.

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
            if problem.stop_when == "settled" and self._done_of(SETTLED_SLICE) == 0 and self._settled_long():
                self.status = Status.SETTLED
                break
            if problem.output == "keyframes" and self._done_of(problem.keyframe_steps) == 0:
                sink.keyframe(keyframes.columns(self))
            sink.slice_done(self)
            if progress is not None:
                progress(self)
        self.fill(sink)
        sink.events(self.log.empty, self.log.finish(self.last))
        if problem.output == "events":
            self.write(sink, np.array([self.t_end]), self.last)

    def _steps(self) -> int:
        """The steps of the next slice: up to a multiple of what one has, so that nothing depends on where it began."""
        problem = self.problem
        most = SETTLED_SLICE if problem.stop_when == "settled" else STEPS_PER_SLICE
        left = most - self._done_of(most)
        if problem.output != "keyframes":
            return left
        return min(left, problem.keyframe_steps - self._done_of(problem.keyframe_steps))

    def _done_of(self, steps: int) -> int:
        """How many steps were made since the last multiple of so many."""
        return self.monitor.steps % steps

    def ended_at_start(self) -> Status | None:
        """How a run ends before its first step: a quantity that must not be negative is so from the start."""
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
        """Takes in a slice; gives how it ended the run, or None. Of its states the samples count, and the end of the
        run: where a slice ends does not show."""
        self.status, self.last = piece.status, piece.last
        self.t_end = float(piece.time) * self.second
        seen = piece.samples if self.status is None else np.concatenate([piece.samples, piece.last])
        self.monitor.follow(seen, self.driver.extremes(), piece.steps)
        self.story.follow(piece.tables)
        sink.more(piece.tables)
        table, marks, states = self.log.take(piece.passages)
        sink.events(table, marks)
        if self.problem.output == "steps" and self.driver.tally["upto"] < 1.0:  # it ended in the midst of a step
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
        since = self.log.settled_since(self.last)
        if since is None or not self.t_end - since > SETTLED_FOR * self.second:
            return False
        return stays(self.problem.body(), self.view.evaluate(self.last), self.second)

    def report(self) -> dict[str, Any]:
        """The measured part of `info --json`, as far as the run has come."""
        theta_end = self.view.theta(self.last)
        return {
            "t_end": self.t_end,
            **self.monitor.report(),
            **self.log.report(),
            "theta_end": theta_end,
            **({"contact_phases": self.story.report()} if self.problem.contact is not None else {}),
            **({"steps_by": "heyoka"} if self.driver.is_called and self.problem.precision == "double" else {}),
            **self._outcome(),
        }

    def _outcome(self) -> dict[str, str]:
        """What has become of the body by now, a name of CLASSES; nothing of a system that friction cannot turn over."""
        system = self.problem.system
        if self.driver.sentence or not (system.inverts and system.classes):
            return {}
        if self.log.kept().get("lifted_at") is not None and self.problem.on_liftoff != "fly":
            return {"outcome": "lifted-off"}
        values = self.view.evaluate(self.last)
        theta, omega3 = (values[name].astype(float) for name in ("theta", "omega3"))
        settled = np.array([self.log.settled_since(self.last) is not None])
        kinds = classes_of(system, theta, omega3 / self.second, settled, self.problem.body())
        kind = with_phases(kinds, theta, values)
        return {"outcome": CLASSES[kind[0]]}

    def reason(self) -> str:
        """The sentence that the user reads about the end."""
        t, status = self.t_end, self.status
        lifted = self.log.kept().get("lifted_at") if self._may_lift_off() else None
        beyond = f", but outside the model since the liftoff at t = {lifted:.9g} s" if lifted is not None else ""
        if status is None:
            return f"interrupted or running: t = {t:.6g} s of {self.problem.until:.6g} s"
        if self.driver.sentence:
            return f"{self.driver.sentence}: stopped at t = {t:.9g} s; the last good state is kept"
        if status is Status.FINISHED:
            return f"finished at t = {t:.6g} s{beyond}"
        if status is Status.SETTLED:
            settled = self.log.settled_since(self.last)
            return f"settled: sliding died at t = {settled:.6g} s, stopped at t = {t:.6g} s{beyond}"
        if status in (Status.LIFTOFF, Status.FALLEN) and (own := self._own_ending()):
            return f"`{own.name}` ended the run as {status.value} at t = {t:.9g} s: {own.long_name}"
        if status is Status.LIFTOFF and t == 0:
            return "the body lifts off at the start (g_n < 0): the model does not hold there"
        if status is Status.LIFTOFF:
            return f"the body lifted off at t = {t:.9g} s (g_n = 0): the model ends there"
        if status is Status.FALLEN:
            return f"the top fell at t = {t:.9g} s (theta = pi/2): the plane is in its way"
        if status is Status.ENDED:
            return f"an event of the system ended the run at t = {t:.9g} s: {self._last_ending()}"
        domains = self.view.domains(self.last)
        meaning, least = min(domains.items(), key=lambda item: item[1]) if domains else ("no known cause", math.inf)
        stiff = "the coordinates are regular there, so the friction law is singular or too stiff (large mu, small eps)"
        if any(is_users(event.formula) for event in self.problem.system.events):
            stiff += ", or the formula of an event of yours is singular"
        if t == 0 and status is Status.NON_FINITE:
            stiff += ", or a number of the start, the body or the law is too large"
        what = "the state is not finite after" if status is Status.NON_FINITE else "the step size vanishes at"
        return f"{what} t = {t:.9g} s: {meaning if least < 1e-3 else stiff}. The last good state is kept."

    def _may_lift_off(self) -> bool:
        """Whether the model of this system ends at liftoff (a fixed tip holds on)."""
        return any(event.ends == Status.LIFTOFF.value for event in self.problem.system.events)

    def _own_ending(self) -> Event | None:
        """The event of the user that ended the run, if it was one: of those that may have, the nearest to its zero."""
        events = [e for e in self.problem.system.events if e.ends and Status.of_event(e.ends) is self.status]
        if not any(hasattr(e.formula, "of") for e in events):
            return None
        state, body = self.view.moment(self.last), self.view.body
        last = min(events, key=lambda e: abs(float(np.min(e.formula(state, body)))))
        return last if hasattr(last.formula, "of") else None

    def _last_ending(self) -> str:
        """What the system says of the event that ended the run."""
        events = self.problem.system.events
        return next(e.long_name for e in events if e.ends and Status.of_event(e.ends) is self.status)

    def snapshot(self) -> dict[str, Any]:
        """All that is needed to continue bit by bit, as plain JSON data."""
        return self._encoded(self._state())

    def ending(self) -> dict[str, Any]:
        """What the store of a finished run keeps for those who continue it, as plain JSON data: the last slice's
        beginning, which no end has shortened, and the end."""
        end = hexfloat.encode({"state": self.last[0], "t_end": self.t_end})
        return {"slice": self._encoded(self.last_slice) if self.last_slice else {}, "end": end}

    def _state(self) -> State:
        return {
            "driver": self.driver.snapshot(),
            "filled": self.filled,
            "t_end": self.t_end,
            "monitor": self.monitor.snapshot(),
            "log": self.log.snapshot(),
            **({"story": self.story.snapshot()} if self.problem.contact is not None else {}),
        }

    def _encoded(self, state: State) -> dict[str, Any]:
        return hexfloat.encode({"equations": fingerprint(self.driver), **state})

    def restore(self, kept: dict[str, Any]) -> None:
        """Continues from a snapshot. Raises ValueError if it was made of other equations.

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
            self.story = Story(**hexfloat.decode(kept["story"]))


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
        times = integration.problem.times[self.asked : self.asked + ROWS_PER_BLOCK]  # a step may hold more than memory
        self.asked += len(times)
        return times / integration.second

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Takes rows that were made."""
        integration, clock = self.integration, time.perf_counter()
        filled = integration.filled
        seconds = times * integration.second if self.steps else integration.problem.times[filled : filled + len(times)]
        integration.write(self.sink, seconds, states)
        self.seconds += time.perf_counter() - clock
