"""The event log as it grows: zeros of a slice become rows, with what can only be known later as marks on older rows."""

from typing import Any

import numpy as np

from ..engine.observables import Observables
from ..engine.taylor import Slice
from ..engine.zeros import Zero
from ..mechanics.system import KINDS
from ..mechanics.units import SECOND
from ..problem import Problem
from .events import Confirmation, EventTable


AT_START = 1e-9  # an event function that is smaller than this at t = 0, of order one, starts on its zero
TURNING, SETTLED = KINDS.index("turning"), KINDS.index("settled")


class EventLog:
    """Turns the zeros of slices into rows of the event table, and keeps the tally that a run reports.

    An event at t = 0 is never logged: the log covers 0 < t <= t_end, and a run that starts on the zero of an event does
    not find it again. Rows of turnings and of settling start as not significant; marks make them so later.
    """

    def __init__(self, problem: Problem, view: Observables, first: np.ndarray):
        self.view, self.second = view, float(problem.scales.of(SECOND))
        self.formulas = {event.name: event.formula for event in problem.system.events}
        self.directions = {event.name: event.direction for event in problem.system.events}
        self.sense = {event.name: event.sense for event in problem.system.events}
        self.logged = problem.events
        scalars = view.scalars(first)
        on_zero = {name: abs(float(f(scalars, view.body)[0])) < AT_START for name, f in self.formulas.items()}
        self.starts_on = {name for name, is_zero in on_zero.items() if is_zero}
        self.confirmation = Confirmation()
        self.tally: dict[str, Any] = {
            "rows": 0,
            "counts": dict.fromkeys(KINDS, 0),
            "turning_significant": 0,
            "before": view.theta(first),  # where the present swing began
            "theta_min": None,
            "theta_max": None,
            "first_equator": None,
            "last_equator": None,
            "inverted_at": None,
            "lifted_at": None,
            "settled": None,  # [row, time] of the last moment when sliding died
        }

    def take(self, piece: Slice) -> tuple[EventTable, list[int], np.ndarray]:
        """Rows of a slice, indices of rows (old or new) that are now known to be significant, and the states (internal)
        of the new rows."""
        zeros = [zero for zero in piece.zeros if zero.time > 0]
        if self.starts_on and len(piece.times) > 1:
            zeros = self._first_step(piece, zeros)
            self.starts_on = set()
        if not zeros:
            return EventTable.empty(), [], np.zeros((0, 0))
        times = np.array([z.time for z in zeros])
        states = np.array(piece.output(times), copy=True)
        values = self.view.evaluate(states)
        kind = np.array([KINDS.index(z.kind) for z in zeros], dtype=np.int8)
        crossing = np.array([z.sign * self.sense[z.kind] for z in zeros])
        rising = np.where(crossing != 0, crossing, np.sign(values["theta_dot"].astype(float))).astype(np.int8)
        theta, seconds = values["theta"].astype(float), times.astype(float) * self.second
        self._count(seconds, kind)
        keep = np.isin(kind, [KINDS.index(name) for name in self.logged])
        states, kind, rising = states[keep], kind[keep], rising[keep]
        theta, seconds = theta[keep], seconds[keep]
        first = self.tally["rows"]
        turning = kind == TURNING
        swing = np.full(theta.shape, np.nan)
        swing[turning] = np.abs(np.diff(theta[turning], prepend=self.tally["before"]))
        if turning.any():
            self.tally["before"] = float(theta[turning][-1])
        for i in range(len(KINDS)):
            self.tally["counts"][KINDS[i]] += int(np.sum(kind == i))
        if (kind == SETTLED).any():
            last = int(np.flatnonzero(kind == SETTLED)[-1])
            self.tally["settled"] = [first + last, float(seconds[last])]
        table = EventTable(seconds, kind, theta, rising, swing, ~(turning | (kind == SETTLED)))
        marks = self.confirmation.take(first + np.flatnonzero(turning), theta[turning], rising[turning])
        self.tally["rows"] += len(theta)
        return table, self._confirmed(marks), states

    def _first_step(self, piece: Slice, zeros: list[Zero]) -> list[Zero]:
        """The zeros of the first slice, with those of the first step found anew for events that start on their zero.

        heyoka finds the zero at t = 0 (twice), and then misses another one in the same step.
        """
        start, end = (float(t) for t in piece.times[:2])
        kept = [zero for zero in zeros if zero.kind not in self.starts_on or zero.time > end]
        grid = np.linspace(start, end, 130)[1:]

        def value(kind: str, times: np.ndarray) -> np.ndarray:
            wide = np.asarray(times, dtype=piece.ends.dtype)
            scalars = self.view.scalars(np.array(piece.output(wide), copy=True))
            return np.broadcast_to(np.asarray(self.formulas[kind](scalars, self.view.body), float), times.shape)

        for kind in self.starts_on:
            values = value(kind, grid)
            if np.max(np.abs(values)) < AT_START:
                continue  # zero all the way, like z' of a top that spins upright
            for i in np.flatnonzero(values[1:] * values[:-1] < 0):
                low, high, sign = grid[i], grid[i + 1], int(np.sign(values[i + 1]))
                while (middle := (low + high) / 2) not in (low, high):
                    beyond = value(kind, np.array([middle]))[0] * sign > 0
                    low, high = (low, middle) if beyond else (middle, high)
                if self.directions[kind] in (0, sign):
                    kept.append(Zero(piece.ends.dtype.type(high), kind, sign))
        return sorted(kept, key=lambda zero: zero.time)

    def settled(self, last: np.ndarray) -> bool:
        """Whether sliding has died and not returned in the state `last`, (1, variables)."""
        if self.tally["settled"] is None:
            return False
        return float(self.formulas["settled"](self.view.scalars(last), self.view.body)[0]) < 0

    def finish(self, last: np.ndarray) -> list[int]:
        """Rows that the end of the run, in the state `last`, shows to be significant."""
        marks = self._confirmed(self.confirmation.reached(self.view.theta(last)))
        return [*marks, self.tally["settled"][0]] if self.settled(last) else marks

    def _count(self, seconds: np.ndarray, kind: np.ndarray) -> None:
        """First and last passages, whatever kinds are logged."""
        for name, earliest, latest in (
            ("equator", "first_equator", "last_equator"),
            ("inverted", "inverted_at", None),
            ("liftoff", "lifted_at", None),
        ):
            found = seconds[kind == KINDS.index(name)]
            if len(found):
                self.tally[earliest] = found[0] if self.tally[earliest] is None else self.tally[earliest]
                if latest is not None:
                    self.tally[latest] = float(found[-1])

    def _confirmed(self, marks: list[tuple[int, float]]) -> list[int]:
        """Adds confirmed turnings to the band; gives their rows."""
        if not marks:
            return []
        angles = [theta for _, theta in marks]
        low, high = self.tally["theta_min"], self.tally["theta_max"]
        self.tally["theta_min"] = min(angles) if low is None else min(low, *angles)
        self.tally["theta_max"] = max(angles) if high is None else max(high, *angles)
        self.tally["turning_significant"] += len(marks)
        return [row for row, _ in marks]

    def report(self) -> dict[str, Any]:
        """Counts, inversion and band, as `info --json` has them."""
        counts = {name: n for name, n in self.tally["counts"].items() if n}
        if "turning" in counts:
            counts["turning_significant"] = self.tally["turning_significant"]
        return {
            "event_counts": counts,
            "inversion": {name: self.tally[name] for name in ("first_equator", "last_equator", "inverted_at")},
            "nutational_band": {name: self.tally[name] for name in ("theta_min", "theta_max")},
        }

    def snapshot(self) -> dict[str, Any]:
        """What a checkpoint keeps."""
        waiting = self.confirmation
        return {"tally": self.tally, "waiting": [waiting.row, waiting.theta, waiting.sign]}

    def restore(self, kept: dict[str, Any], *, fresh: bool) -> None:
        """Goes on from a checkpoint; unless fresh, the first step of the run is over."""
        self.starts_on = self.starts_on if fresh else set()
        self.tally = kept["tally"]
        self.confirmation.row, self.confirmation.theta, self.confirmation.sign = kept["waiting"]
