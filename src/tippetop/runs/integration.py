"""One run from start to end: slices go to a sink, the drift monitor and the event log; the end gets a status."""

import math
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..engine.extremes import Extremes
from ..engine.normal_force import grazing, normal_force
from ..engine.observables import Observables
from ..engine.settling import CLASSES, SETTLED_FOR, classes_of, stays
from ..engine.status import Status
from ..engine.taylor import Slice, endings_of, fingerprint, integrator_of, rows_at, slices
from ..mechanics.units import SECOND
from ..problem import Problem
from ..store import hexfloat
from .drift import SAMPLES_PER_SLICE, Monitor
from .event_log import EventLog
from .sinks import Sink


ROWS_PER_BLOCK = 1 << 16  # 12 MB of 24 columns: what a sink takes at once
SETTLED_SLICE = 1024  # steps between two looks whether a run has settled


class Integration:
    """A run between its start and its end: all that an interruption must not lose.

    Parameters
    ----------
    problem
        What is integrated.

    Attributes
    ----------
    integrator
        heyoka's; its state is the last of the run, in internal units.
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
        self.problem, self.integrator = problem, integrator_of(problem, stop)
        self.seconds = {"compile": time.perf_counter() - clock, "integrate": 0.0}
        self.view = Observables(problem)
        self.second = float(problem.scales.of(SECOND))
        self.first = problem.start()[None, :]
        self.last = self.first  # last good state
        self.monitor = Monitor(problem, self.view)
        self.monitor.begin(self.first)
        self.log = EventLog(problem, self.view, self.first)
        self.filled, self.t_end, self.fresh = 0, 0.0, True
        self.status: Status | None = None

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
        problem = self.problem
        end = problem.number(problem.until) / problem.number(self.second)
        if self.fresh and problem.output != "times":
            self._write(sink, np.array([0.0]), self.first)
        steps = SETTLED_SLICE if problem.stop_when == "settled" else None
        for part in slices(self.integrator, end, endings_of(problem), steps):
            force = normal_force(part, problem) if len(part.times) > 1 else Extremes()
            piece = grazing(part, force, problem)
            self.seconds["integrate"] += piece.wall
            self.fresh = False
            self._follow(piece, force, sink)
            if self.status is not None:
                break
            if problem.stop_when == "settled" and self._settled_long():
                self.status = Status.SETTLED
                break
            sink.slice_done(self)
            if progress is not None:
                progress(self)
        sink.events(self.log.empty, self.log.finish(self.last))
        if problem.output == "events":
            self._write(sink, np.array([self.t_end]), self.last)

    def _follow(self, piece: Slice, force: Extremes, sink: Sink) -> None:
        problem, self.status = self.problem, piece.status
        steps = len(piece.times) - 1
        ends = piece.ends
        while steps and not np.all(np.isfinite(ends[steps - 1].astype(float))):  # never let a bad state in
            steps -= 1
        reached = float(piece.times[steps])
        self.t_end = reached * self.second
        upto = problem.times.count(self.t_end, inclusive=self.status is not None)
        if steps:
            ends = ends[:steps]
            self.last = ends[-1:].copy()
            every = max(1, steps // SAMPLES_PER_SLICE)
            self.monitor.follow(np.concatenate([ends[::every], ends[-1:]]), force, steps)
            table, marks, states = self.log.take(piece)
            sink.events(table, marks)
            if problem.output == "steps":
                self._write(sink, np.asarray(piece.times[1 : steps + 1], float) * self.second, ends)
            elif problem.output == "events" and len(table.time):
                self._write(sink, table.time, states)
        if problem.output == "times" and upto > self.filled:
            if not sink.keeps_rows:
                self.filled = upto
            last = self.last if not steps else None
            while self.filled < upto:  # in blocks: a step may hold more rows than memory does
                times = problem.times[self.filled : min(upto, self.filled + ROWS_PER_BLOCK)]
                self.filled += len(times)
                # the dense output of the slice is not used again here: another thread may have it
                sink.rows(times, partial(self._rows, piece, times, last))

    def _rows(self, piece: Slice, times: np.ndarray, last: np.ndarray | None) -> np.ndarray:
        """The states at times [s] of a slice; `last`, if the slice has no step."""
        if last is not None:
            return np.repeat(last, len(times), axis=0)
        return rows_at(piece, times / self.second, self.problem)

    def _write(self, sink: Sink, times: np.ndarray, states: np.ndarray) -> None:
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
            **self._outcome(),
        }

    def _outcome(self) -> dict[str, str]:
        """What has become of the body by now, a name of CLASSES; nothing of a system that friction cannot turn over."""
        system = self.problem.system
        if not (system.inverts and system.classes):
            return {}
        if self.log.tally.kept.get("lifted_at") is not None:
            return {"outcome": "lifted-off"}
        values = self.view.evaluate(self.last)
        theta, omega3 = (values[name].astype(float) for name in ("theta", "omega3"))
        settled = np.array([self.log.settled_since(self.last) is not None])
        kind = classes_of(system, theta, omega3 / self.second, settled, self.problem.body())
        return {"outcome": CLASSES[kind[0]]}

    def reason(self) -> str:
        """The sentence that the user reads about the end."""
        t, status = self.t_end, self.status
        lifted = self.log.tally.kept["lifted_at"] if self._may_lift_off() else None
        beyond = f", but outside the model since the liftoff at t = {lifted:.9g} s" if lifted is not None else ""
        if status is None:
            return f"interrupted or running: t = {t:.6g} s of {self.problem.until:.6g} s"
        if status is Status.FINISHED:
            return f"finished at t = {t:.6g} s{beyond}"
        if status is Status.SETTLED:
            settled = self.log.settled_since(self.last)
            return f"settled: sliding died at t = {settled:.6g} s, stopped at t = {t:.6g} s{beyond}"
        if status is Status.LIFTOFF:
            return f"the top lifted off at t = {t:.9g} s (g_n = 0): the model ends there"
        if status is Status.FALLEN:
            return f"the top fell at t = {t:.9g} s (theta = pi/2): the plane is in its way"
        if status is Status.ENDED:
            return f"an event of the system ended the run at t = {t:.9g} s: {self._last_ending()}"
        domains = self.view.domains(self.last)
        meaning, least = min(domains.items(), key=lambda item: item[1]) if domains else ("no known cause", math.inf)
        stiff = "no singularity is near, so the equations are too stiff (large mu, small eps)"
        what = "the state is not finite after" if status is Status.NON_FINITE else "the step size vanishes at"
        return f"{what} t = {t:.9g} s: {meaning if least < 1e-3 else stiff}. The last good state is kept."

    def _may_lift_off(self) -> bool:
        """Whether the model of this system ends at liftoff (a fixed tip holds on)."""
        return any(event.ends == Status.LIFTOFF.value for event in self.problem.system.events)

    def _last_ending(self) -> str:
        """What the system says of the event that ended the run."""
        events = self.problem.system.events
        return next(e.long_name for e in events if e.ends and Status.of_event(e.ends) is self.status)

    def snapshot(self) -> dict[str, Any]:
        """All that is needed to continue bit by bit, as plain JSON data."""
        integrator = self.integrator
        return hexfloat.encode(
            {
                "equations": fingerprint(integrator),
                "state": integrator.state,
                "time": list(integrator.dtime),
                "filled": self.filled,
                "t_end": self.t_end,
                "monitor": self.monitor.snapshot(),
                "log": self.log.snapshot(),
            }
        )

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
        integrator, number = self.integrator, self.problem.number
        if kept["equations"] != fingerprint(integrator):
            raise ValueError("the equations must be those of the checkpoint, but this release has others")
        integrator.state[:] = [hexfloat.from_hex(text, number) for text in kept["state"]]
        integrator.dtime = tuple(hexfloat.from_hex(text, number) for text in kept["time"])
        self.last = integrator.state.copy()[None, :]
        self.filled, self.t_end = kept["filled"], hexfloat.decode(kept["t_end"])
        self.monitor.restore(hexfloat.decode(kept["monitor"]))
        self.fresh = self.t_end == 0  # it was killed before its first slice
        self.log.restore(hexfloat.decode(kept["log"]), fresh=self.fresh)
