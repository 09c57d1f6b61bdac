"""One run in doubles, driven by the compiled step."""

import weakref
from typing import Any

import numpy as np

from ..mechanics.operand import leaves
from ..problem import Problem
from .compiled import Compiled
from .driver import Rows, drive, new_motion, no_rows
from .slices import RULES, STATUSES, Driver, Passages, Request, Slice, new_room
from .status import Status


PLACES = 4  # that a thread keeps of an integrator, 0.4 MB each


class Place:
    """The arrays of a run, and the loop that is bound to their addresses: to bind them takes longer than 50 steps, so
    that a run takes those of one that is gone.

    Parameters
    ----------
    compiled
        The integrator, with machine code.
    """

    def __init__(self, compiled: Compiled):
        assert compiled.machine is not None
        self.taken_by: Any = None  # a weak reference to a driver
        self.motion, self.room = new_motion(compiled.integrator, 1), new_room(compiled)
        self.nothing = no_rows(len(self.motion.state))
        machine = compiled.machine
        self.drive = drive.on(machine.step, machine.dense, self.motion, *self.room)
        self.drive_on = drive.on(machine.step, machine.dense, self.motion, *self.room, self.nothing, RULES)


def place_for(driver: "CompiledDriver", compiled: Compiled) -> Place:
    """A place that no other driver of this thread has, as long as there is this one."""
    places: list[Place] = compiled.places.__dict__.setdefault("places", [])
    place = next((place for place in places if place.taken_by() is None), None)
    if place is None:
        place = Place(compiled)
        if len(places) < PLACES:
            places.append(place)
    place.taken_by = weakref.ref(driver)
    return place


class CompiledDriver(Driver):
    """Drives a run by the machine code of its step."""

    def __init__(self, problem: Problem, compiled: Compiled):
        self.place = place_for(self, compiled)
        super().__init__(problem, compiled, self.place.room)
        self.motion = self.place.motion
        for zeroed in (self.motion.state, self.motion.high, self.motion.low):
            zeroed[:] = 0.0
        pars = [float(leaf) for leaf in leaves(problem.internal_body)][: len(self.motion.pars)]
        self.motion.pars[:, 0] = pars  # it reads none beyond
        self.motion.state[: self.variables, 0] = problem.start()
        self.motion.end[0] = float(self.end)

    def prepare(self) -> None:
        """Compiles the loop, if it is not yet compiled."""
        self.place.drive_on(0)

    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps."""
        log, samples = self.log, self.samples
        log.filled[0] = samples.filled[0] = 0
        steps, before = 0, int(self.tally["steps"])
        while True:
            rows = self._asked(request)
            left = most - steps if self.tally["status"] == Status.RUNNING.code else 0
            steps += self.place.drive_on(left) if rows is self.place.nothing else self.place.drive(rows, RULES, left)
            filled = int(rows.filled[0])
            if filled:
                request.take(rows.times[:filled], rows.states[:filled, : self.variables])
            self.times = self.times[filled:]
            if not filled or filled < len(rows.times):
                break
        status = STATUSES[int(self.tally["status"])]
        order = np.argsort(log.time[: log.filled[0]], kind="stable")
        last, when = self.motion.state[None, :, 0].copy(), float(self.tally["t"])
        if self.tally["upto"] < 1.0:  # an event ended the run in the midst of a step: it is the last passage
            last = log.states[order[-1:]]
        columns = log.time, log.event, log.sign, log.at_pole, log.states[:, : self.variables]
        return Slice(
            int(self.tally["steps"]) - before,
            when,
            last[:, : self.variables],
            samples.states[: samples.filled[0], : self.variables].copy(),
            Passages(*(column[order] for column in columns)),
            None if status is Status.RUNNING else status,
        )

    def _asked(self, request: Request) -> Rows:
        if request.steps or not len(self.times):
            self.times = request.wanted()
        if not len(self.times):
            return self.place.nothing
        states = np.empty((len(self.times), len(self.motion.state)))
        return Rows(self.times, states, np.zeros(1, np.int64), request.steps, self.place.nothing.out)

    def end_at(self, end: Any) -> None:
        """Puts the end of the run at an internal time."""
        super().end_at(end)
        self.motion.end[0] = float(end)

    @property
    def clock(self) -> tuple[float, float]:
        """Internal time, in double length."""
        return float(self.motion.high[0]), float(self.motion.low[0])

    @property
    def state(self) -> np.ndarray:
        """All that is integrated."""
        return self.motion.state[:, 0]

    def put(self, state: np.ndarray, clock: tuple[float, float]) -> None:
        """Puts state and time in place."""
        self.motion.state[:, 0] = state
        self.motion.high[0], self.motion.low[0] = clock
