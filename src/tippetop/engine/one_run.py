"""One run in doubles, driven by the compiled step."""

import weakref
from typing import Any

import numpy as np

from ..mechanics.operand import leaves
from ..problem import Problem
from .compiled import Compiled
from .loop import Loop, Rows, new_motion
from .slices import RULES, STATUSES, Driver, Passages, Request, Slice, new_room
from .status import Status


RUNNING = Status.RUNNING.code
PLACES = 4  # that a thread keeps of an integrator, 1 MB each of which a short run fills a part
NO_ROWS = Rows(np.zeros(0), np.zeros((0, 0)), np.zeros(1, np.int64), False)


class Place:
    """The arrays of a run, and the loop that is bound to their addresses: to bind them takes as long as 50 steps, so
    that a run takes those of one that is gone.

    Parameters
    ----------
    compiled
        The integrator, with machine code.
    """

    def __init__(self, compiled: Compiled):
        self.taken_by: Any = None  # a weak reference to a driver
        integrator = compiled.integrator
        sizes = len(integrator.state), len(integrator.pars), integrator.order + 1
        self.motion, self.room = new_motion(*sizes, 1), new_room(compiled)
        self.loop = Loop(self.motion, *self.room, RULES, compiled.machine)


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
        self.filling = NO_ROWS
        super().__init__(problem, compiled, self.place.room)
        self.motion = self.place.motion
        for zeroed in (self.motion.state, self.motion.high, self.motion.low):
            zeroed[:] = 0.0
        pars = [float(leaf) for leaf in leaves(problem.internal_body)][: len(self.motion.pars)]
        self.motion.pars[:, 0] = pars  # it reads none beyond
        self.motion.state[: self.variables, 0] = problem.start()
        self.motion.end[0] = float(self.end)

    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps."""
        log, samples, wanted, tally = self.log, self.samples, self.wanted, self.tally
        log.filled[0] = samples.filled[0] = 0
        steps, before, n = 0, int(tally["steps"]), self.variables
        loop = self.place.loop
        while True:
            wanted.ask(request)
            left = most - steps if tally["status"] == RUNNING else 0
            if not len(wanted.times):
                loop.fill(NO_ROWS)
                steps += loop.drive(left)
                break
            rows = self._filling(wanted.times, request.steps)
            first = wanted.made
            rows.filled[0] = first
            loop.fill(rows)
            steps += loop.drive(left)
            wanted.made = int(rows.filled[0])
            if wanted.made > first:
                request.take(rows.times[first : wanted.made], rows.states[:, first : wanted.made].T)
            if wanted.made == first or wanted.made < len(rows.times):
                break
        code, when, after, _, upto, *_ = tally.item()
        status, count = STATUSES[code], int(log.filled[0])
        last = self.motion.state[None, :, 0]
        columns = log.time[:count], log.event[:count], log.sign[:count], log.at_pole[:count], log.states[:count, :n]
        if count > 1:
            order = np.argsort(columns[0], kind="stable")
            passages = Passages(*(column[order] for column in columns))
        else:
            passages = Passages(*(column.copy() for column in columns))
        if upto < 1.0:  # an event ended the run in the midst of a step: it is the last passage
            last = passages.states[-1:]
        return Slice(
            after - before,
            when,
            last[:, :n].copy(),
            samples.states[: int(samples.filled[0]), :n].copy(),
            passages,
            None if status is Status.RUNNING else status,
        )

    def _filling(self, times: np.ndarray, steps: bool) -> Rows:
        """Rows at these times: the same ones as long as these times are wanted."""
        if self.filling.times is not times:
            states, filled = np.empty((self.variables, len(times))), np.zeros(1, np.int64)
            self.filling = Rows(times, states, filled, steps, self.compiled.rounding)
        return self.filling

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
