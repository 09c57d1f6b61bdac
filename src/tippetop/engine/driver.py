"""One run, which the compiled loop integrates slice by slice.

A compiled integrator, the start and the end of a run go in (`taylor.driver_of` makes a driver);
`Driver.advance` returns a `Slice`: the state reached, events, samples; rows go to its `Request`. A
slice is the steps between two moments at which Python is called. Within it C steps, finds events
and fills arrays; after it Python logs events, compares invariants, writes rows and may commit or
stop. A slice ends after a fixed number of steps or changes of phase, or when the log is full, never
after a time: a stored run that is resumed has the slices of an undisturbed one, hence its bits.

Symbols
    state     the integrated variables and integrals, (variables,), in internal units; an integrator
              has more behind them, for event functions: "all variables", at most `width`
    row       a state at a time that the caller requested; a sample: at every EVERY-th step
    passage   a zero of an event function; the log contains those of a slice
    tally     counters and extreme values of a run, see `tallies`
    high, low the time in double length, their sum
    most      the greatest number of steps
"""

import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..columns import Arrays
from .integrator import Compiled
from .loop import MOST_COEFFICIENTS, NO_ROWS, Loop, Rows, new_motion
from .status import Status
from .tallies import (
    EventRows,
    Log,
    Rules,
    Tallies,
    new_log,
    new_tallies,
)


# about 20 ms of work; a stored run that another version resumes has its bits only with this number
STEPS_PER_SLICE = 8192
PASSAGES = 4096  # in a slice, at most: one every other step; `is_full` in loop.c ends it there
EVERY = 8  # steps between two looks at the invariants: 1 % of the cost of the steps
FIRST = 256  # steps of a run that are all looked at: a short run has no more
ENDLESS = 1 << 62  # steps of a single run, which may take as long as it likes
STATUSES = {status.code: status for status in Status}
RUNNING = Status.RUNNING.code


class Extremes(NamedTuple):
    """The smallest and the largest value of a quantity with their times, in internal units."""

    least: float = np.inf
    t_least: float = np.nan
    most: float = -np.inf
    t_most: float = np.nan


class Passages(NamedTuple):
    """Zeros of event functions, ascending in time."""

    times: np.ndarray  # (k,) internal, in the working precision
    events: np.ndarray  # (k,) numbers of the events of the system
    signs: np.ndarray  # (k,) of the crossings, +1 rising
    at_pole: np.ndarray  # (k,) whether the axis passes a pole there
    states: np.ndarray  # (k, variables) internal


@dataclass
class Slice:
    """The result of `Driver.advance`: the state after some steps, and the events in them.

    `runs.integration.Integration.add_slice` measures and logs it. All states are rows of the run,
    whatever the phase integrates.
    """

    steps: int
    time: Any  # reached, internal, in the working precision
    last: np.ndarray  # (1, variables) the last good state
    samples: np.ndarray  # (k, variables) states on the way
    passages: Passages
    status: Status | None  # None: to be continued
    tables: dict[str, Arrays] = field(default_factory=dict)  # new rows of further tables, SI


class Request(Protocol):
    """The caller of `Driver.advance`, from which it gets times of rows, and which receives them.

    `runs.integration.Integration` implements it.
    """

    rows_at_steps: bool  # whether rows are at the ends of steps, rather than at given times

    def next_times(self) -> np.ndarray:
        """Return the internal times of the rows that are wanted next, (k,) doubles; for steps, an
        array with room for k. Empty at the end.
        """

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Receive rows: internal times (k,), states (k, variables)."""


def view(array: np.ndarray) -> Any:
    """Return a view of an array that reads and writes numbers of Python, in half NumPy's time.

    It shares the memory of the array, which the loop in C writes too.
    """
    return memoryview(array)  # type: ignore[arg-type]


RULES = Rules(np.inf, ENDLESS, EVERY, FIRST)
"""Rules of a single run: only an event ends it before its time."""


class Workspace:
    """The integrator of one phase with its arrays, and the loop that is bound to them.

    `Driver` makes one, `HybridDriver` one for each phase, `PoolOfOne` one for its lanes.

    Parameters
    ----------
    run
        A `Driver` or `PoolOfOne`. It has `found`, the tallies, log and samples that all its
        workspaces share, `rules`, `lanes`, and `stepper_of`, where there is no machine code.
    compiled
        The integrator.
    rows
        The events, as numbered in `found`: of a hybrid run, all of them in each phase.
    """

    def __init__(self, run: Any, compiled: Compiled, rows: EventRows):
        """Allocate the arrays of an integrator, and bind the loop to them."""
        made = compiled.integrator
        self.compiled = compiled
        self.rows = rows
        self.stepper: Any = compiled.machine or run.stepper_of(compiled)
        self.motion = new_motion(len(made.state), len(made.pars), made.order + 1, run.lanes)
        found: tuple[Tallies, Log, Log] = run.found
        self.loop = Loop(self.motion, rows, *found, run.rules, self.stepper)


class Driver:
    """Integrate one run in doubles, and find its events and rows.

    `runs.integration.Integration` calls `advance`, and `impacts` calls `make_steps`; subclasses add
    phases and numbers wider than doubles.

    Parameters
    ----------
    compiled
        The integrator.
    rows
        The events as this run looks for them: see `tallies.looked_for`.
    body
        The parameters of the integrator, `leaves` of the body, perhaps with others behind.
    start
        The state at the start, (variables,), internal.
    functions
        The event functions there, (events,).
    end
        Internal time of the end.
    """

    lanes = 1
    rules = RULES
    found: tuple[Tallies, Log, Log]  # what the loops of all phases write
    ended: Status | None = None  # how the run ends before its first step
    sentence = ""  # why the contact ended the run, where it did

    def __init__(
        self,
        compiled: Compiled,
        rows: EventRows,
        body: Sequence[Any],
        start: np.ndarray,
        functions: np.ndarray,
        end: Any,
    ):
        """Allocate the arrays of the run, and set body, start, time 0 and end."""
        self.at_start = functions
        self.end = end
        self.variables = len(start)
        self.number = start.dtype.type
        self.allocate_tallies(rows, functions[:, None], len(compiled.integrator.state))
        self.set_workspace(Workspace(self, compiled, rows))
        self.first = start[None, :].copy()
        self.set_parameters(self.workspace, body)
        self.set_state(start, (self.number(0), self.number(0)))
        self.set_end(end)

    def allocate_tallies(self, rows: EventRows, functions: np.ndarray, width: int) -> None:
        """Allocate the tallies, log and samples that all phases of a run share.

        `functions` are the event functions at the start, (events, 1); those of a hybrid run are
        dummies, as `_enter` sets their signs. `width` is the length of the longest state of an
        integrator, the variables that are added for event functions included: C copies that many
        numbers, with this stride.
        """
        # `is_full` in loop.c keeps free what one step may find, a zero for each coefficient
        room = PASSAGES + len(rows.events) * MOST_COEFFICIENTS
        number = self.number
        self.all_events = rows
        self.set_tallies(new_tallies(rows, functions))
        self.log = new_log(room, width, number)
        # in short phases every step is a sample (`FIRST`); a full array would end the slice
        self.samples = new_log(STEPS_PER_SLICE + 2, width, number, np.int64)
        self.found = self.tallies, self.log, self.samples
        is_double = number in (float, np.float64)
        # of passages, in the working precision
        self.times = self.log.rows["time"] if is_double else np.zeros(room, number)
        self.logged, self.sampled_so_far = map(view, (self.log.filled, self.samples.filled))
        self.set_output(NO_ROWS)

    def set_tallies(self, tallies: Tallies) -> None:
        """Set the arrays into which the loop counts; `status`, `steps`, ... are views of them.

        `HybridPools._load` calls it with those of one of its tops.
        """
        self.tallies = tallies
        self.functions = tallies.functions[:, 0]
        names = "status", "steps", "upto", "tiny", "t"
        self.status, self.steps, self.upto, self.tiny, self.time = (
            view(tallies.lane[name]) for name in names
        )

    def set_output(self, rows: Rows) -> None:
        """Set the arrays into which the next steps write their rows; none are delivered yet."""
        self.output = rows
        self.made = view(rows.filled)
        self.delivered = 0

    def set_workspace(self, workspace: Workspace) -> None:
        """Make the next steps with the integrator and arrays of this phase; it copies no state."""
        self.workspace = workspace
        self.motion = workspace.motion
        self.loop = workspace.loop
        self.stepper = workspace.stepper

    def set_parameters(self, workspace: Workspace, body: Sequence[Any]) -> None:
        """Copy the numbers of the body, or as many as an integrator has, to its parameters.

        Wider numbers are not copied to the arrays of the loop but to heyoka: an override.
        """
        pars = workspace.motion.pars[:, 0]
        pars[:] = body[: len(pars)]

    # --- steps -----------------------------------------------------------------------------------

    def advance(self, request: Request, most: int) -> Slice:
        """Make a slice of at most `most` steps; rows go to the request.

        Everything in the slice is copied: the arrays of the loop are used again by the next one.
        """
        self.request = weakref.proxy(request)  # no cycle: arrays are free when the run is gone
        steps, when, last, ended = self.run(most)
        logged = slice(self.logged[0])
        sampled = slice(self.sampled_so_far[0])
        events = self.log.rows[logged]
        self.deliver_rows()
        # passages, samples, and behind them the one last state, of the present phase
        phases = events["phase"], self.samples.rows[sampled], self.motion.in_lane
        states = (
            self.log.states[logged],
            self.samples.states[sampled],
            np.resize(last, (1, self.width)),
        )
        rows = self.rows_of(np.concatenate(phases), np.concatenate(states))
        at_passages, samples, last = np.split(rows, [len(events), -1])
        columns = self.times[logged], events["event"], events["sign"], events["at_pole"]
        passages = Passages._make([*(column.copy() for column in columns), at_passages])
        self.clear_findings()
        return Slice(steps, when, last, samples, passages, ended)

    def run(self, most: int) -> tuple[int, Any, np.ndarray, Status | None]:
        """Advance by at most `most` steps; subclasses go through phases. `advance` calls it.

        Return the number of steps, the internal time and the state reached, and how the run ends
        there, or None if it continues.
        """
        before = self.steps[0]
        self.drive(most)
        code = self.status[0]
        steps = self.steps[0] - before
        return steps, *self.reached(), None if code == RUNNING else STATUSES[code]

    def clear_counts(self) -> None:
        """Reset status, `upto`, `tiny` and `steps` before a phase or a piece of an impact.

        Steps 0 mark its first step, in which loop.c and `WideSteps` drop the root at the start.
        """
        self.status[0], self.upto[0], self.tiny[0], self.steps[0] = RUNNING, 1.0, 0, 0

    def clear_findings(self) -> None:
        """Empty the log and the samples, after their content was copied."""
        self.logged[0] = self.sampled_so_far[0] = 0

    def drive(self, most: int) -> int:
        """Make at most `most` steps, with new room for rows when it is full; return their number.

        The loop stops where its room is full, and goes on after `request_rows`; a run that has
        ended may still have rows in its last step.
        """
        steps = 0
        while True:
            if self.made[0] == self.output.length:
                self.request_rows()
            steps += self.make_steps(most - steps if self.status[0] == RUNNING else 0)
            if self.made[0] < max(1, self.output.length):  # 1: no rows are wanted, none are made
                return steps

    def request_rows(self) -> None:
        """Hand over the rows that are filled, and make room for the next ones, as requested.

        Each block has arrays of its own, so the request may keep the rows it receives without a
        copy. Room of length 0 means that no further rows are wanted.
        """
        self.deliver_rows()
        times = self.request.next_times()
        n = len(times)
        filled = np.zeros(1, np.int64)
        states = np.empty((n, self.width), self.number)
        phases = np.empty(n, np.int64)
        self.set_output(Rows(times, states, phases, filled, self.request.rows_at_steps, n))

    def deliver_rows(self) -> None:
        """Hand the rows that were filled since the last call to the request.

        `advance` calls it at the end of each slice, which may be within a block.
        """
        output = self.output
        made = slice(self.delivered, self.made[0])
        rows = self.rows_of(output.phases[made], output.states[made])
        self.delivered = made.stop
        if len(rows):
            self.request.add_rows(output.times[made], rows)

    def rows_of(self, phases: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return states (k, width) as rows of the run (k, variables).

        `phases` are the numbers of their phases, (k,). A run with one phase ignores them, and has
        its integrated state, without the variables added for event functions, as row.
        """
        return states[:, : self.variables]

    def make_steps(self, most: int) -> int:
        """Let the loop in C make at most `most` steps and their rows; return their number.

        Of a run of several phases it also makes changes of phase: an override.
        """
        self.loop.fill(self.output)
        return self.loop.drive(most)

    def reached(self) -> tuple[Any, np.ndarray]:
        """Return the internal time reached and the state there.

        They are those of the last passage, if it ended the run within a step (`upto` < 1): loop.c
        logs the event that ends a run after all others. `follow_motion` there takes the same state.
        """
        if self.upto[0] < 1.0:
            last = self.logged[0] - 1
            return self.times[last], self.log.states[last]
        return self.now, self.state

    # --- where the run is ------------------------------------------------------------------------

    @property
    def now(self) -> Any:
        """Return the internal time at the end of the last step."""
        return self.time[0]

    @property
    def tally(self) -> Any:
        """Return the record of counters of the run: see `tallies.LANE_RECORD`."""
        return self.tallies.lane[0]

    @property
    def clock(self) -> tuple[Any, Any]:
        """Return the internal time in double length, as the pair (high, low)."""
        return float(self.motion.high[0]), float(self.motion.low[0])

    @property
    def state(self) -> np.ndarray:
        """Return all integrated variables, those added for event functions included.

        Of a run in doubles it is a view of the array of the loop.
        """
        return self.motion.state[:, 0]

    def set_state(self, state: Sequence[Any] | np.ndarray, clock: tuple[Any, Any]) -> None:
        """Set the state, internal, padded with zeros, and the internal time as (high, low)."""
        self.motion.state[: len(state), 0], self.motion.state[len(state) :] = state, 0.0
        self.motion.high[0], self.motion.low[0] = clock

    def set_end(self, end: Any) -> None:
        """Let the next steps end at an internal time, kept as `goal` in the working precision."""
        self.goal = end
        self.motion.end[0] = float(end)

    def last_rows(self) -> dict[str, Arrays]:
        """Return the rows of the tables of phases and impacts that end with the run.

        A run without phases has none. `Integration` calls it for a run that ends between slices.
        """
        return {}

    def present(self) -> np.ndarray:
        """Return the present state, (1, variables), internal."""
        return self.rows_of(self.motion.in_lane, np.resize(self.state, (1, self.width)))

    def codes(self) -> tuple[Compiled, ...]:
        """Return the integrators of all phases, whose equations identify the run in a store."""
        return (self.workspace.compiled,)

    def extremes(self) -> Extremes:
        """Return the extremes of the normal force so far, internal units; NaN times if unknown.

        They are those of all events with `extremes`: each phase may have its own function for it.
        """
        records = self.all_events.events
        functions = self.functions
        kept = records["extremes"]
        # from the scale of the coefficients, as in `ensembles.lanes`
        values = functions["extremes"][kept] / records["scale"][kept, None]
        pairs = np.stack([values, functions["times"][kept]], axis=-1)
        least = min(pairs[:, 0].tolist(), default=(np.inf, np.nan))
        most = max(pairs[:, 1].tolist(), default=(-np.inf, np.nan))
        return Extremes(*least, *most)

    @property
    def width(self) -> int:
        """Return the length of stored states: the most variables that a phase integrates."""
        return self.log.states.shape[1]

    def snapshot(self) -> dict[str, Any]:
        """Return plain data from which a run continues bit by bit, for `restore`.

        Stores contain them: another name, or another order of numbers (that of `LANE_RECORD` and
        `FUNCTION_RECORD` in `tallies`), is another format of stores. Keyframes join the values in
        the order of the keys, too, and each entry in the precision of the run must be in
        `runs.keyframes.EXACT`.
        """
        return {
            "state": self.state.copy(),
            "time": list(self.clock),
            "tally": list(self.tallies.lane[0].item()),
            "functions": self.tallies.functions.view(float).tolist(),
            "kept": self.tallies.kept[:, 0].tolist(),
        }

    def joint(self, names: Iterable[str]) -> dict[str, Any]:
        """Return data for another run that begins in the present state, as `Problem.joint`.

        They are the signs of the functions of these events, 0 if unknown: they decide whether a
        zero in this state has been passed. `names` are those of the system, in its order. Stores
        contain the keys; `driver_of` and `HybridDriver` read them.
        """
        # a function without a search for zeros keeps its first sign
        signs = self.functions["sign"] * self.workspace.rows.events["watched"]
        return {"signs": dict(zip(names, signs.astype(int).tolist(), strict=False))}

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot `kept`, of a run with the same equations.

        Its `state` and `clock` (high, low) are passed in the working precision, which plain data
        do not have.
        """
        self.set_state(state, clock)
        self.clear_findings()
        self.tallies.lane[0] = tuple(kept["tally"])
        self.tallies.functions.view(float)[:] = kept["functions"]
        self.tallies.kept[:, 0] = kept["kept"]
