"""Many tops whose contact changes, in lanes.

Each phase has a pool: the lanes of its integrator, and a queue of tops that are in this phase. C
steps the phase in which most tops are until a lane ends, moves its top by a program to the queue of
the next phase, and takes another one. Python makes only the changes that no program makes. The
numbers of a top depend on its own alone, whatever its neighbours, its place and its turn.
"""

import ctypes
import threading
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.form import CLOCK, STALL
from ..mechanics.operand import kinds, leaves, refill
from ..problem import Problem
from .changes import CHATTER, numbers_of
from .driver import ENDLESS, STATUSES
from .expressions import Formulas
from .hybrid import QUIET, HybridDriver, Track
from .integrator import Compiled
from .loop import Loop, filled, library, new_motion
from .settling import SETTLED_FOR
from .status import Status
from .stepper import Loaded
from .tallies import (
    FUNCTION_RECORD,
    LANE_RECORD,
    EventRows,
    PassageLog,
    Rules,
    Samples,
    Tallies,
    new_log,
    new_tallies,
)
from .taylor import compiled_when, internal_end


LANES = 8
EVERY = 64
"""Steps of a top between two samples, and between two looks whether it has settled."""
PATIENCE = 2
"""As in `changes`: many tops make the same changes."""
_, A_CHANGE, A_LOOK, _ = range(4)
"""What a top waits for: a lane; its change, by Python; a look whether it has settled; nothing."""


_REALS = [(name, float) for name in ("high", "low", "end", "until", "began")]
_WHOLE = [(n, int) for n in ("phase", "event", "steps", "waits", "short", "changes")]
TOP_RECORD = np.dtype([*_REALS, *_WHOLE])
"""A top: its clock, the ends of the run and of its phase, and the start of the phase, internal; the
event that ended it; steps before those of its tally; phases in a row that were too short.
"""
POOL_RECORD = np.dtype(
    [("loop", np.uint64), ("parameters", np.uint64), *((n, int) for n in ("first", "n", "taken"))]
)


class _Pools(NamedTuple):
    pools: np.ndarray
    loops: np.ndarray
    changes: np.ndarray
    events: np.ndarray
    queues: np.ndarray
    tops: np.ndarray
    tallies: np.ndarray
    functions: np.ndarray
    kept: np.ndarray
    states: np.ndarray
    bodies: np.ndarray
    called: np.ndarray
    calls: np.ndarray
    chatter: float
    phases: int
    room: int
    numbers: int
    kept_numbers: int
    width: int
    possible: int


class Pools(HybridDriver):
    """Pools for tops of one system; as a driver, the seat in which Python begins and changes one.

    Parameters
    ----------
    problem
        One of the tops.
    room
        How many tops may be under way: places, by number.
    stop
        Set it to give up while equations are being compiled.

    Attributes
    ----------
    tops, tallies_of, functions_of, kept_of, states
        Of the top in each place.
    """

    lanes = LANES

    def __init__(self, problem: Problem, room: int, stop: threading.Event | None = None):
        settled_for = SETTLED_FOR if problem.stop_when == "settled" else np.inf
        self.rules = Rules(settled_for, ENDLESS, EVERY, 0, settled_every=EVERY)
        self.room = room
        super().__init__(problem, stop)

    def begin_run(self) -> None:
        """Make the arrays of all tops; none has begun."""
        room = self.room
        self.request = SimpleNamespace(steps=False)  # type: ignore[assignment]
        self.fresh = [self.tally.copy(), self.functions.copy(), self.tallies.kept[:, 0].copy()]
        self.pattern = kinds(self.world.body)
        self.own_phases = self.assembled(self.problem)[1]
        self.copies.patience = PATIENCE
        found = self.tallies, self.log, self.samples
        self.notes = Loop(
            new_motion(1, 0, 1, 1), self.all_events, *found, self.rules, Loaded(None, 0, 0, False)
        )
        self.failures: dict[int, InputError] = {}
        self.parameters: dict[str, np.ndarray] = {}
        self.worlds: list[Any] = [None] * room
        self.problems: list[Any] = [None] * room
        self.tops = np.zeros(room, TOP_RECORD)
        self.tallies_of = np.zeros(room, LANE_RECORD)
        self.functions_of = np.zeros((room, len(self.numbers)), FUNCTION_RECORD)
        self.kept_of = np.zeros((room, len(self.tallies.kept)))
        self.states = np.zeros((room, self.width))
        self.bodies = np.zeros((room, len(numbers_of(self.world))))
        self.called = np.zeros(room, np.int64)
        self.calls = np.zeros(1, np.int64)
        self.pools = np.zeros(len(self.phases), POOL_RECORD)
        self.queues = np.zeros((len(self.phases), room), np.int64)
        arrays = self.queues, self.tops, self.tallies_of, self.functions_of, self.kept_of
        arrays = *arrays, self.states, self.bodies, self.called, self.calls
        changes = self.copies.loops, self.copies.table, self.all_events.events
        sizes = len(self.phases), room, self.bodies.shape[1], self.kept_of.shape[1], self.width, 0
        self.record: Any = filled(_Pools(self.pools, *changes, *arrays, CHATTER, *sizes))

    # --- places of phases ------------------------------------------------------------------------

    def code_of(self, formulas: Formulas) -> Compiled:
        problem = self.problem
        key = formulas, "double", problem.tolerance, self.lanes, problem.orientation
        return compiled_when(key, self.stop)

    def findings(self, rows: EventRows) -> tuple[Tallies, PassageLog, Samples]:
        tallies = new_tallies(rows, np.ones((len(rows.events), self.lanes)))
        tallies.lane["status"] = Status.FINISHED.code
        return tallies, new_log(0, self.width), self.samples

    def track_of(self, name: str) -> Track:
        is_new = name not in self.tracks
        track = super().track_of(name)
        if is_new:
            motion = track.place.motion
            motion.in_lane[:] = -1
            places = refill(self.world.body, iter(range(len(leaves(self.world.body)))))
            mine = np.array(leaves(track.phase.parameters(places))[: len(motion.pars)], np.int64)
            self.parameters[name] = mine
            loop = ctypes.addressof(track.place.loop.structure)
            self.copies.loops[track.at] = loop
            self.pools["loop"][track.at] = loop
            self.pools["parameters"][track.at] = mine.ctypes.data
        return track

    def work_in(self, place: Any) -> None:
        self.place = place
        self.loop = self.notes

    @property
    def clock(self) -> tuple[Any, Any]:
        return self.at

    @property
    def state(self) -> np.ndarray:
        return self.present_state

    def put(self, state: Sequence[Any] | np.ndarray, clock: tuple[Any, Any]) -> None:
        self.present_state, self.at = np.array(state, float), clock

    def present(self) -> np.ndarray:
        row = np.zeros((1, self.width))
        row[0, : len(self.state)] = self.state
        return self.rows_of(np.array([self.track.at]), row)

    # --- one top -----------------------------------------------------------------------------------

    @QUIET
    def seat(self, place: int, problem: Problem) -> bool:
        """Begin a top in a place. Return whether it runs in these pools: with the same phases, and
        in no phase that Python samples.
        """
        body, phases = self.assembled(problem)
        if phases is not self.own_phases or kinds(body) != self.pattern:
            return False
        self.problem = problem
        self.end = float(internal_end(problem))
        self.worlds[place] = self.world._replace(body=body, rules=problem.contact)
        self.problems[place] = problem
        self._see(place)
        self.tallies.lane[0], self.functions[:], self.tallies.kept[:, 0] = self.fresh
        self.ended = None
        self.short = 0
        self.logged[0] = 0
        self.tops[place] = 0
        self.bodies[place] = numbers_of(self.world)
        super().begin_run()
        self.tops["end"][place] = self.end
        self._keep(place)
        if self.ended is not None:
            self.tallies_of["status"][place] = self.ended.code
        elif not self.track.sampled:
            self.push(place)
        return not self.track.sampled

    def _see(self, place: int) -> None:
        """Let formulas see the body of a top."""
        self.world = self.worlds[place]
        self.problem = self.problems[place]
        for track in self.tracks.values():
            track.b = track.phase.parameters(self.world.body)

    def _keep(self, place: int) -> None:
        """Take the top from the seat to its place, where it waits for a lane."""
        top = self.tops[place]
        top["high"], top["low"] = self.at
        top["until"] = min(self.until, self.end)
        top["began"], top["phase"], top["short"] = self.began, self.track.at, self.short
        self.tallies_of[place] = self.tally
        self.functions_of[place] = self.functions
        self.kept_of[place] = self.tallies.kept[:, 0]
        self.states[place] = 0.0
        self.states[place, : len(self.state)] = self.state
        self.series = None
        self.logged[0] = 0
        self.tables.take()

    def push(self, place: int) -> None:
        """Let a top wait for a lane."""
        library().loop_push(ctypes.byref(self.record), place)

    @QUIET
    def _change_of(self, place: int) -> Status | None:
        """Make the change of a top that no program makes. Return how it ends the run, or None."""
        self._see(place)
        top = self.tops[place]
        self.track = track = self.tracks[[*self.phases][top["phase"]]]
        self.began, self.until, self.short, self.end = top[
            ["began", "until", "short", "end"]
        ].item()
        self.tallies.lane[0] = self.tallies_of[place]
        self.functions[:] = self.functions_of[place]
        self.tallies.kept[:, 0] = self.kept_of[place]
        self.logged[0] = int(self.upto[0] < 1.0)
        self.last = self.states[place, : len(track.place.motion.state)].copy()
        when = float(top["high"])
        self.put(self.last, (when, 0.0))
        event = int(top["event"])
        ending: Any = STALL if event < 0 else CLOCK if event == len(self.numbers) else event
        jump = track.exits.get(ending)
        try:
            ends = self._change(jump, when) if jump else STATUSES[self.status[0]]
        except InputError as error:
            self.failures[place] = error
            ends = Status.INVALID
        self._keep(place)
        if ends is None:
            top["changes"] += 1
        else:
            self.tallies_of["status"][place] = ends.code
        return ends

    # --- all tops ----------------------------------------------------------------------------------

    def step(self, most: int) -> tuple[list[int], list[int], list[int]]:
        """Make about so many steps of lanes. Return the places of tops that have ended, that may
        have settled, and that have come into a phase that Python samples.
        """
        self.calls[0] = 0
        library().loop_pools(ctypes.byref(self.record), most)
        ended, looks, sampled = list[int](), list[int](), list[int]()
        for place in self.called[: self.calls[0]].tolist():
            waits = self.tops["waits"][place]
            if waits == A_CHANGE and self._change_of(place) is None:
                steps, high = self.tops[["steps", "high"]][place].item()
                lasted = high - self.tallies_of["lasts_since"][place]
                if self.track.sampled:
                    sampled.append(place)
                elif steps % EVERY == 0 and lasted > self.rules.settled_for:
                    looks.append(place)
                else:
                    self.push(place)
            else:
                (looks if waits == A_LOOK else ended).append(place)
        return ended, looks, sampled

    @property
    def possible(self) -> int:
        """Return how many steps the lanes could have made."""
        return self.record.possible

    def rows_at(
        self, phases: np.ndarray, states: np.ndarray, places: np.ndarray
    ) -> np.ndarray:
        """Return rows of states (k, width) of phases, by number, of the tops in places (k,)."""
        rows = np.empty((len(phases), self.variables))
        for track in self.tracks.values():
            mine = np.flatnonzero(phases == track.at)
            body = refill(self.world.body, iter(self.bodies[places[mine]].T))
            b = track.phase.parameters(body)
            self.read(rows, mine, track, states, b)
        return rows
