"""Many tops whose contact changes, in lanes.

Each phase has a pool: the lanes of its integrator, and a queue of tops that are in this phase. C
steps the phase in which most tops are until a lane ends, moves its top by a program to the queue of
the next phase, and takes another one. Python makes only the changes that no program makes. The
numbers of a top depend on its own alone, whatever its neighbours, its slot and its turn.
"""

import math
import threading
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.form import CLOCK, STALL
from ..mechanics.operand import kinds, leaves, refill
from ..problem import Problem
from .changes import CHATTER, Changes, numbers_of
from .driver import ENDLESS, STATUSES
from .expressions import Formulas
from .hybrid import QUIET, HybridDriver, Track
from .integrator import Compiled
from .loop import (
    Loop,
    Rows,
    address_of,
    count_turnings,
    filled,
    library,
    new_motion,
    rows_of_tops,
)
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
A_CHANGE, A_LOOK, AN_END, NOTHING = range(1, 5)
"""What a top waits for: a lane; its change, by Python; a look whether it has settled; the end of
its next step, in a phase that Python samples; nothing."""


_REALS = [(name, float) for name in ("high", "low", "end", "until", "stop", "began")]
_NAMES = "stops_by", "phase", "event", "steps", "waits", "short", "changes"
TOP_RECORD = np.dtype([*_REALS, *((name, int) for name in _NAMES)])
"""A top: its clock, the ends of the run, of its phase and of its next steps, and the start of the
phase, internal; the event at the end of the next steps; the phase, and the event that ended it;
steps before those of its tally; phases in a row that were too short.
"""
_PLACES = [(name, np.uint64) for name in ("loop", "parameters")]
_COUNTS = [(name, int) for name in ("by_steps", "count", "occupied")]
POOL_RECORD = np.dtype([*_PLACES, *_COUNTS])


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
    """Pools for tops of one system; as a driver, it holds the top that Python begins or changes.

    Parameters
    ----------
    problem
        One of the tops.
    room
        Number of slots: tops that may be under way.
    stop
        Set it to give up while equations are being compiled.
    row_count
        Number of rows of each top, at times that `begin_top` is given.

    Attributes
    ----------
    tops, tallies_of, functions_of, kept_of, states, bodies
        Arrays over slots: the top there, its tallies, its state and the numbers of its body.
    rows
        Those of the tops in the slots.
    """

    lanes = LANES

    def __init__(
        self,
        problem: Problem,
        room: int,
        stop: threading.Event | None = None,
        row_count: int = 0,
    ):
        settled_for = SETTLED_FOR if problem.stop_when == "settled" else np.inf
        self.rules = Rules(settled_for, ENDLESS, EVERY, 0, settled_every=EVERY)
        self.room = room
        self.row_count = row_count
        super().__init__(problem, stop)

    def begin_run(self) -> None:
        """Make the arrays of all tops; none has begun."""
        room = self.room
        copies = self.programs
        copies.patience = PATIENCE
        self.request: Any = SimpleNamespace(steps=False)
        self.fresh = self.tally.copy(), self.functions.copy(), self.tallies.kept[:, 0].copy()
        self.pattern = kinds(self.world.body)
        self.own_phases = self.assembled(self.problem)[1]
        found = self.tallies, self.log, self.samples
        no_steps = Loaded(None, 0, 0, False, 0)
        nowhere = new_motion(1, 0, 1, 1)
        self.notes = Loop(nowhere, self.all_events, *found, self.rules, no_steps)
        times = np.zeros((room, self.row_count))
        self.rows = rows_of_tops(times, self.width, len(self.phases))
        self.over: list[int] = []  # slots of tops that ended where they began
        self.failures: dict[int, str] = {}  # by slot, of invalid tops
        self.parameters: dict[str, np.ndarray] = {}
        self.worlds: list[Any] = [None] * room
        self.problems: list[Any] = [None] * room
        self.tops = np.zeros(room, TOP_RECORD)
        self.tops["waits"] = NOTHING
        self.tallies_of = np.zeros(room, LANE_RECORD)
        self.functions_of = np.zeros((room, len(self.numbers)), FUNCTION_RECORD)
        self.kept_of = np.zeros((room, len(self.tallies.kept)))
        self.states = np.zeros((room, self.width))
        self.bodies = np.zeros((room, len(copies.body)))
        self.called = np.zeros(room, np.int64)
        self.calls = np.zeros(1, np.int64)
        self.pools = np.zeros(len(self.phases), POOL_RECORD)
        queues = np.zeros((len(self.phases), room), np.int64)
        record = _Pools(
            *(self.pools, copies.loops, copies.table, self.all_events.events, queues),
            *(self.tops, self.tallies_of, self.functions_of, self.kept_of, self.states),
            *(self.bodies, self.called, self.calls, CHATTER),
            *(len(self.phases), room, *self.bodies.shape[1:], *self.kept_of.shape[1:]),
            *(self.width, 0),
        )
        self.arrays = record  # must outlive the structure
        self.record: Any = filled(record)
        self.record_at = address_of(self.record)

    @property
    def programs(self) -> Changes:
        """Return the programs of the changes."""
        assert self.copies is not None
        return self.copies

    # --- lanes of phases -------------------------------------------------------------------------

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
            body = self.world.body
            order = track.phase.parameters(refill(body, iter(range(len(leaves(body))))))
            mine = np.array(leaves(order)[: len(motion.pars)], np.int64)
            self.parameters[name] = mine
            loop = address_of(track.place.loop.structure)
            self.programs.loops[track.at] = loop
            track.place.loop.fill(self.rows)
            self.pools[track.at] = loop, mine.ctypes.data, bool(track.sampled), 0, 0
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
        self.at = clock
        self.present_state = np.zeros(len(self.place.motion.state))
        self.present_state[: len(state)] = state

    # --- one top ---------------------------------------------------------------------------------

    @QUIET
    def begin_top(self, slot: int, problem: Problem, times: np.ndarray) -> bool:
        """Begin a top in a slot, with rows at these internal times. Return whether it has the same
        phases as the others.
        """
        body, phases = self.assembled(problem)
        if phases is not self.own_phases or kinds(body) != self.pattern:
            return False
        self.end = float(internal_end(problem))
        self.worlds[slot] = self.world._replace(body=body, rules=problem.contact)
        self.problems[slot] = problem
        self._use_body(slot)
        self.tallies.lane[0], self.functions[:], self.tallies.kept[:, 0] = self.fresh
        vars(self).pop("ended", None)
        self.short = 0
        self.logged[0] = 0
        self.tops[slot] = 0
        self.bodies[slot] = numbers_of(self.world)
        self.rows.times[slot], self.rows.states[slot] = times, np.nan
        self.rows.filled[slot] = (times < 0).sum()
        self._use_rows(slot)
        self._start(tuple(problem.start().tolist()))
        self.tops["end"][slot] = self.end
        self._store(slot)
        if self.ended is None:
            self.push(slot)
        else:
            self.tallies_of["status"][slot] = self.ended.code
            self.over.append(slot)
        return True

    def _use_body(self, slot: int) -> None:
        """Use the body of a top in formulas."""
        self.world = self.worlds[slot]
        self.problem = self.problems[slot]
        for track in self.tracks.values():
            track.b = track.phase.parameters(self.world.body)

    def _use_rows(self, slot: int) -> None:
        """Write the rows of a top."""
        arrays = (array[slot] for array in self.rows[:3])
        self.want(Rows(*arrays, self.rows.filled[slot : slot + 1], False))

    def _store(self, slot: int) -> None:
        """Store the top that the driver holds in its slot."""
        self.add_in_jump()
        top = self.tops[slot]
        top["high"], top["low"] = self.at
        top["until"] = min(self.until, self.end)
        self._set_end(slot)
        top["began"], top["phase"], top["short"] = self.began, self.track.at, self.short
        self.tallies_of[slot] = self.tally
        self.functions_of[slot] = self.functions
        self.kept_of[slot] = self.tallies.kept[:, 0]
        self.states[slot] = 0.0
        self.states[slot, : len(self.state)] = self.state
        self.series = None
        self.logged[0] = 0
        self.tables.rows.clear()

    def _set_end(self, slot: int) -> None:
        """Set where the next steps of the top that the driver holds end."""
        when, ending = self.next_end()
        by = len(self.numbers) if ending in (None, CLOCK) else ending
        self.tops["stop"][slot], self.tops["stops_by"][slot] = when, by

    def push(self, slot: int) -> None:
        """Let a top wait for a lane."""
        library().loop_push(self.record_at, slot)

    def _note(self, number: int, time: Any, sign: int, phase: int, state: np.ndarray) -> None:
        super()._note(number, time, sign, phase, state)
        sense = self.all_events.events["sense"][number]
        if sense:  # of a single run the log counts turnings
            axis = self.tracks[[*self.phases][phase]].place.rows.axis
            x, y, z = state[axis].tolist()
            theta = math.atan2(math.sqrt(x * x + y * y), z)
            count_turnings(self.tallies, np.array([sense * sign]), np.array([theta]))

    def _load(self, slot: int) -> None:
        """Take a top from its slot into the driver."""
        self._use_body(slot)
        self._use_rows(slot)
        top = self.tops[slot]
        self.track = self.tracks[[*self.phases][top["phase"]]]
        names = ["began", "until", "short", "end", "high", "low"]
        self.began, self.until, self.short, self.end, *clock = top[names].item()
        self.tallies.lane[0] = self.tallies_of[slot]
        self.functions[:] = self.functions_of[slot]
        self.tallies.kept[:, 0] = self.kept_of[slot]
        self.logged[0] = int(self.upto[0] < 1.0)
        self.last = self.states[slot, : len(self.track.place.motion.state)].copy()
        self.place = self.track.place
        self.put(self.last, clock)

    def _change_of(self, slot: int) -> Status | None:
        """Make the change of a top that no program makes. Return how it ends the run, or None."""
        self._load(slot)
        top = self.tops[slot]
        when = float(top["high"])
        event = int(top["event"])
        ending: Any = STALL if event < 0 else CLOCK if event == len(self.numbers) else event
        jump = self.track.exits.get(ending)
        try:
            ends = self._change(jump, when) if jump else STATUSES[self.status[0]]
        except InputError as error:
            self.failures[slot] = error.sentences[0]
            ends = Status.INVALID
        self._store(slot)
        if ends is None:
            top["changes"] += 1
        else:
            self.tallies_of["status"][slot] = ends.code
        return ends

    # --- all tops --------------------------------------------------------------------------------

    @QUIET
    def step(self, most: int) -> tuple[list[int], list[int]]:
        """Make about this many steps of lanes. Return the slots of tops that have ended, and of
        those that may have settled.
        """
        self.calls[0] = 0
        library().loop_pools(self.record_at, most)
        ended, looks = self.over, list[int]()
        self.over = []
        for slot in self.called[: self.calls[0]].tolist():
            waits = self.tops["waits"][slot]
            if waits == AN_END:
                self._load(slot)
                self._set_end(slot)
                self.push(slot)
            elif waits == A_CHANGE and self._change_of(slot) is None:
                steps, high = self.tops[["steps", "high"]][slot].item()
                lasted = high - self.tallies_of["lasts_since"][slot]
                if steps % EVERY == 0 and lasted > self.rules.settled_for:
                    looks.append(slot)
                else:
                    self.push(slot)
            else:
                (looks if waits == A_LOOK else ended).append(slot)
        return ended, looks

    def rows_in(self, slots: np.ndarray) -> np.ndarray:
        """Return the rows of the present states of the tops in slots (k,)."""
        return self.rows_at(self.tops["phase"][slots], self.states[slots], slots)

    def rows_made(self, slots: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """Return rows at given times of the tops in slots, by their numbers, (k,) each."""
        phases = self.rows.phases[slots, numbers] % len(self.phases)
        return self.rows_at(phases, self.rows.states[slots, numbers], slots)

    def rows_at(self, phases: np.ndarray, states: np.ndarray, slots: np.ndarray) -> np.ndarray:
        """Return rows of states (k, width) of phases, by number, of the tops in slots (k,)."""
        rows = np.empty((len(phases), self.variables))
        for track in self.tracks.values():
            mine = np.flatnonzero(phases == track.at)
            body = refill(self.world.body, iter(self.bodies[slots[mine]].T))
            b = track.phase.parameters(body)
            self.read(rows, mine, track, states, b)
        return rows
