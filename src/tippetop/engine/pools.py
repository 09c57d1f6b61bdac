"""Integrate many tops in SIMD lanes.

Starts of tops go into `new_tops`, whose arrays the `Pools` of several threads share; each thread
begins other tops by `Pools.start`, and `step` returns those that have ended, whose rows and tallies
`ensembles.lanes` then reads. Each phase has a pool: the lanes of its integrator, and a queue of
tops that are in this phase. The loop steps the phase in which most tops are until a lane ends,
moves its top by a program to the queue of the next phase, and fills the lane from its queue. Python
makes only the jumps that have no program. The result of a top does not depend on its neighbours,
its number or its turn.

The start of a top is a jump too, to its first phase, and there are as many starts as tops. So it
has programs like any other jump, those of a phase after the last one, and only the first few tops
start by Python.

Symbols
    slot      number of a top, its index in all arrays; lane: index in a SIMD integrator
    phase     index of a phase; width: most variables of a state, padded with zeros
    numbers   of a body: those that formulas take, and of its contact
"""

import ctypes
import threading
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.operand import leaves, refill
from ..problem import Problem, Problems
from .driver import ENDLESS, RUNNING, STATUSES
from .hybrid import QUIET, HybridDriver, PhaseSolver, assembled
from .jump_programs import TOP_RECORD, Jumps
from .loop import (
    Loop,
    Rows,
    filled,
    library,
    new_motion,
)
from .settling import SETTLED_FOR
from .status import Status
from .stepper import Loaded
from .tallies import (
    EventRows,
    Log,
    Rules,
    Tallies,
    lasts_from_start,
    new_log,
    new_tallies,
    record_type,
)


LANES = 8
"""As fast as 32, and they compile in 1 s instead of 6."""
EVERY = 64
"""Steps of a top between two samples, and between two looks whether it has settled; a power of two.
"""
SETTLED = Status.SETTLED.code
NO_EXIT = -2
"""The event of a top whose phase has not ended by an exit, as in the loop."""
PATIENCE = 2
"""As in `jump_programs`, but lower: many tops make the same jumps."""


POOL_RECORD = record_type(uint="loop parameters", int="by_steps first count occupied")
"""The struct `Pool` of loop.c; `add_pool` fills it by position: addresses of the `Loop` and of the
indices of its parameters; 1 if Python sets the end of each step; the first slot in the ring of its
queue, and how many are in it; the number of lanes with a top.
"""


class _Pools(NamedTuple):
    """The structure `Pools` of `loop.c`, field by field."""

    jumps: Jumps
    pools: np.ndarray  # (phases,) POOL_RECORD
    queues: np.ndarray  # (phases, room) rings of slots
    tops: np.ndarray  # (n,) TOP_RECORD
    called: np.ndarray  # (room,) slots of tops that wait for Python
    phases: int
    room: int  # length of a ring; also the slot of empty lanes, see `leave_lane` in loop.c
    calls: int  # how many slots `called` has


class Tops(NamedTuple):
    """The arrays of n tops, which several threads share; each integrates other tops.

    Records contain addresses of states and bodies, so none of the arrays may be replaced.
    """

    records: np.ndarray  # (n,) TOP_RECORD
    states: np.ndarray  # (n, width)
    bodies: np.ndarray  # (n, numbers)
    tallies: Tallies  # of the tops, then of the empty lanes of each thread
    rows: Rows  # at given times


def new_tops(
    pools: "Pools",
    threads: int,
    problems: Problems,
    functions: np.ndarray,
    bodies: np.ndarray,
    times: np.ndarray,
) -> Tops:
    """Return the arrays of tops that have not begun.

    Parameters
    ----------
    pools
        Those of one of the threads, for the events and the width of states.
    threads
        Number of threads. Each gets one more tally, which has ended, for its empty lanes.
    problems
        The tops.
    functions
        Their event functions at the start, (n, events); (n, 1) NaN where the first phase is chosen.
    bodies
        The numbers of their bodies, (numbers, n), internal: `bodies_of`, or the parameters `pars`
        of a system of one phase.
    times
        Internal times of rows, (n, k), ascending; a top gets no row at a time below 0.
    """
    n, count = times.shape
    rows = pools.all_events
    every = np.ones((len(rows.events), n + threads))  # dummies for empty lanes
    every[:, :n] = functions.T
    tallies = new_tallies(rows, every)
    tallies.lane["status"][n:] = Status.FINISHED.code
    records = np.zeros(n, TOP_RECORD)
    records["end"] = records["stop"] = problems.end
    width = pools.log.states.shape[1]
    states = np.zeros((n, width))
    states[:, : len(problems.start)] = problems.start.T
    bodies = np.ascontiguousarray(bodies.T)
    for name, array in ("state", states), ("body", bodies):
        records[name] = array.ctypes.data + array.strides[0] * np.arange(n)
    phases = np.zeros((n, count), np.int64)
    made = (times < 0).sum(axis=1)
    output = Rows(times, np.full((n, count, width), np.nan), phases, made, False, count)
    return Tops(records, states, bodies, tallies, output)


class Pools:
    """Integrate tops in the pools of their phases, on one thread.

    The base of `ensembles.lanes` (one phase) and of `HybridPools` (several).

    Attributes
    ----------
    tops, states, bodies, of_tops, rows
        The arrays of `Tops`.
    log, samples
        Events and states on the way; their number `in_lane` is the top times phases plus the phase,
        as `enter_lane` in loop.c sets it.
    failures
        Why tops are invalid.
    """

    lanes = LANES
    variables: int
    all_events: EventRows
    log: Log
    samples: Log
    found: tuple[Tallies, Log, Log]
    rows_of: Any

    def share(self, tops: Tops, thread: int, phases: int = 1, programs: Any = None) -> None:
        """Set the arrays of the tops; none has begun.

        Parameters
        ----------
        tops
            All tops of an ensemble.
        thread
            Number of this thread.
        phases
            Number of phases.
        programs
            The `JumpPrograms` of tops that have several phases.
        """
        self.tops, self.states, self.bodies, self.of_tops, self.rows = tops
        self.failures: dict[int, str] = {}
        self.possible = 0  # steps of lanes
        self.parameters: dict[int, np.ndarray] = {}
        self.empty = len(self.tops) + thread  # place of the tally of empty lanes
        self.called = np.zeros(self.empty, np.int64)
        self.pools = np.zeros(phases, POOL_RECORD)
        queues = np.zeros((phases, self.empty), np.int64)
        none = np.zeros(0)
        jumps = programs.jumps if programs else Jumps(none, none, none, none, none, 0.0, 0, 0, 0)
        arrays = self.pools, queues, self.tops, self.called
        # must outlive the structure; with `made` NULL the loop keeps no rows of changes
        self.arrays = _Pools(jumps._replace(made=none), *arrays, phases, self.empty, calls=0)
        self.record: Any = filled(self.arrays)
        self.record_at = ctypes.addressof(self.record)

    def add_pool(self, phase: int, loop: Loop, parameters: Any, *, by_steps: bool = False) -> None:
        """Add the pool of a phase, whose parameters are these numbers of a body, by index.

        Its lanes are empty. `by_steps`: the loop makes one step at a time, because Python sets the
        end of each, in a phase with sampled events.
        """
        # of empty lanes, as `leave_lane` in loop.c sets them
        loop.record.motion.in_lane[:], loop.record.motion.slots[:] = -1, self.empty
        loop.fill(self.rows)
        self.parameters[phase] = mine = np.array(parameters, np.int64)
        self.pools[phase] = ctypes.addressof(loop.structure), mine.ctypes.data, by_steps, 0, 0, 0

    def start(self, new: np.ndarray) -> list[int]:
        """Begin the first phases of the tops in some slots, (k,); return those that end there.

        A system of one phase has no jump to it, so its tops are only queued.
        """
        for slot in new.tolist():
            self.push(slot)
        return []

    def push(self, slot: int) -> None:
        """Append the top in a slot to the queue of its phase, `tops["phase"]`.

        If it may have settled, the next `step` returns it instead.
        """
        library().loop_push(self.record_at, slot)

    def attend(self, slot: int) -> bool:
        """Make a jump that the loop cannot make; return whether the top has ended.

        A system of one phase has no jumps, so the top has ended.
        """
        return True

    @QUIET
    def step(self, most: int) -> tuple[list[int], list[int]]:
        """Make about this many steps of lanes.

        Return the tops that have ended, and those that may have settled, which the caller pushes
        again if they have not (`ensembles.lanes.run_tops`).
        """
        self.possible += self.lanes * library().loop_pools(self.record_at, most)
        called = self.called[: self.record.calls].tolist()
        self.record.calls = 0
        ended = list[int]()
        looks = list[int]()
        for slot in called:
            status = self.of_tops.lane["status"][slot]
            # a phase that an exit has ended has the status of a run that has ended
            goes_on = status == RUNNING or self.tops["event"][slot] != NO_EXIT
            if status == SETTLED:
                looks.append(slot)
            elif not goes_on or self.attend(slot):
                ended.append(slot)
        return ended, looks

    def rows_in(self, tops: np.ndarray) -> np.ndarray:
        """Return the rows of the present states of tops (k,)."""
        return self.rows_of(self.tops["phase"][tops], self.states[tops], tops)


def bodies_of(tops: Problems) -> np.ndarray:
    """Return the numbers of the bodies of tops, (numbers, n), as the inputs of programs.

    They are the leaves of the body and e_n, in the order of `JumpPrograms.body`.
    """
    body, _ = assembled(tops.base.system, tops, lambda value: value.astype(float))
    numbers = *leaves(body), tops.contact.e_n
    return np.array([np.broadcast_to(v, tops.n) for v in numbers], float)


class HybridPools(Pools, HybridDriver):
    """Pools of tops whose contact may change its phase.

    It is also the driver of one top at a time, that for which Python makes a jump: `_load` reads it
    from the arrays of all, `_store` writes it back.

    Parameters
    ----------
    problem
        One of the tops.
    stop
        Set it to give up while equations are being compiled.
    """

    learns_start = True

    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        """Set how long the loop steps between two looks at its tops."""
        settled_for = SETTLED_FOR if problem.stop_when == "settled" else np.inf
        self.rules = Rules(settled_for, ENDLESS, EVERY, 0, settled_every=EVERY)
        super().__init__(problem, stop)

    def begin_run(self) -> None:
        """Begin no run: `start` begins tops."""
        self.jump_programs.patience = PATIENCE

    def join(self, tops: Tops, thread: int) -> None:
        """Set the arrays of the tops; see `Pools.share`.

        `before` takes the place of the phase before the first one: its number is the last row of
        the table of programs, and its exit, `START`, has the number of the clock. `notes` is the
        loop by which C notes events of that jump.
        """
        phases = len(self.phases)
        self.share(tops, thread, phases, self.jump_programs)
        self.tops["event"], self.tops["phase"] = self.clock_number, phases
        motion = new_motion(self.variables, 0, 1, 1)
        self.found = self.of_tops, new_log(0, self.width), self.samples
        none = Loaded(None, 0, 0, False, 0)
        self.notes = Loop(motion, self.all_events, *self.found, self.rules, none)
        variables = SimpleNamespace(names=())
        self.before: Any = SimpleNamespace(
            at=phases, workspace=self.notes.record, variables=variables, sampled={}
        )

    # --- lanes of phases -------------------------------------------------------------------------

    def add_solver(self, solver: PhaseSolver) -> None:
        """Add a phase, which gets a pool.

        Its parameters are called with the indices of the numbers of the body: those of a contact
        select numbers, and compute none.
        """
        super().add_solver(solver)
        body = self.world.body
        order = solver.phase.parameters(refill(body, iter(range(len(leaves(body))))))
        mine = leaves(order)[: len(solver.workspace.motion.pars)]  # as `Driver.set_parameters`
        self.add_pool(solver.at, solver.workspace.loop, mine, by_steps=bool(solver.sampled))

    def set_workspace(self, workspace: Any) -> None:
        """Make the next steps in this phase; state and time remain those of the top."""
        super().set_workspace(workspace)
        self.motion = self.of_top

    # --- one top ---------------------------------------------------------------------------------

    def start(self, new: np.ndarray) -> list[int]:
        """Make the jumps of tops to their first phases, by programs or by Python.

        Both push a top that goes on. Return those that end there.
        """
        begin = partial(library().loop_start, self.record_at, self.notes.place)
        over = [slot for slot in new.tolist() if not begin(slot) and self.attend(slot)]
        # the tops stay at the start of their first phase, which `lanes.run_tops` reads next by
        # `rows_in`; this overwrites a time that the jump noted, as the end of `HybridDriver._start`
        # does: a change of one is a change of both
        signs = self.of_tops.functions[:, new]
        self.of_tops.lane["lasts_since"][new] = lasts_from_start(signs, self.all_events)
        return over

    def _load(self, slot: int) -> None:
        """Load a top from its slot into the driver: the methods of `HybridDriver` act on it.

        Tallies, rows, state and clock are views of the arrays of all tops; `_store` writes back the
        rest. Every attribute that a jump reads must be set here, or the last top's remains.
        """
        *numbers, e_n = self.bodies[slot].tolist()
        body = refill(self.world.body, iter(numbers))
        self.world = self.world._replace(body=body, rules=self.world.rules._replace(e_n=e_n))
        solvers = list(self.solvers.values())
        for solver in solvers:
            solver.b = solver.phase.parameters(body)
        part = slice(slot, slot + 1)
        times, states, phases = (array[slot] for array in self.rows[:3])
        self.set_output(Rows(times, states, phases, self.rows.filled[part], False))
        self.slot = slot
        self.top = top = self.tops[slot]
        clock = {name: self.tops[name][part] for name in ("high", "low")}
        self.motion = self.of_top = self.notes.record.motion._replace(
            state=self.states[slot][:, None], **clock
        )
        self.solver = next((one for one in solvers if one.at == top["phase"]), self.before)
        self.ended = None
        names = ["began", "until", "short_phases", "end"]
        self.began, self.until, self.short_phases, self.end = top[names].item()
        self.set_tallies(Tallies(*(array[..., part] for array in self.of_tops)))
        self.last = self.state.copy()

    def _store(self) -> None:
        """Write the top that was loaded back to its slot, after a jump.

        Rows at times within the jump are written first; rows of tables are dropped.
        """
        self.add_in_jump()
        top = self.top
        # these fields as `change` in loop.c sets them; a change of one is a change of both
        top["until"] = min(self.until, self.end)
        top["stop"], top["stops_by"] = self.next_end()
        top["began"], top["phase"] = self.began, self.solver.at
        top["short_phases"] = self.short_phases
        self.series = None
        self.tables.rows.clear()

    def attend(self, slot: int) -> bool:
        """Start a top, make its jump, or set the end of its next step in a sampled phase.

        Return whether it has ended; otherwise it is in a queue. An InputError makes this top
        invalid, with its first sentence in `failures`; others go on.
        """
        self._load(slot)
        ends = None
        try:
            if self.solver is self.before:
                self._start(tuple(self.last.tolist()))
                ends = self.ended
            elif self.status[0] != RUNNING:
                jump = self.solver.exits.get(self.top["event"])
                ends = self._change(jump, self.clock[0]) if jump else STATUSES[self.status[0]]
        except InputError as error:
            self.failures[slot] = error.sentences[0]
            ends = Status.INVALID
        self._store()
        if ends is None:
            self.push(slot)
            return False
        self.status[0] = ends.code
        return True

    def parameters_in(self, slots: np.ndarray, solver: PhaseSolver) -> Any:
        """Return the parameters b of the phase of a solver for the tops in slots: numbers (k,)."""
        return solver.phase.parameters(refill(self.world.body, iter(self.bodies[slots].T)))
