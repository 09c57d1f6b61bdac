"""One run, driven by the compiled loop slice by slice."""

import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..columns import Arrays
from .integrator import Compiled
from .loop import MOST_COEFFICIENTS, NO_ROWS, Loop, Rows, new_motion
from .status import Status
from .stepper import Stepper
from .tallies import (
    EventRows,
    PassageLog,
    Rules,
    Samples,
    Tallies,
    new_log,
    new_samples,
    new_tallies,
)


STEPS_PER_SLICE = 8192  # about 20 ms of work
PASSAGES = 4096  # in a slice, at most: one every other step; and those of the last step
EVERY = 8  # steps between two looks at the invariants: 1 % of the cost of the steps
FIRST = 256  # steps of a run that are all looked at: a short run has no more
ENDLESS = 1 << 62  # steps of a single run, which may take as long as it likes
STATUSES = {status.code: status for status in Status}
RUNNING = Status.RUNNING.code


class Extremes(NamedTuple):
    """Smallest and largest value of a quantity and when, in internal units."""

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
    """Accepted steps, one after another."""

    steps: int
    time: Any  # reached, internal, in the working precision
    last: np.ndarray  # (1, variables) the last good state
    samples: np.ndarray  # (k, variables) states on the way
    passages: Passages
    status: Status | None  # None: to be continued
    tables: dict[str, Arrays] = field(default_factory=dict)  # new rows of further tables, SI


class Request(Protocol):
    """The rows that are wanted of a run."""

    steps: bool  # at the ends of steps, rather than at given times

    def wanted(self) -> np.ndarray:
        """Return the internal times of the rows that are wanted next, (k,) doubles; for steps, an
        array with room for k. Empty at the end.
        """

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Take rows: internal times (k,), states (k, variables)."""


def view(array: np.ndarray) -> Any:
    """Return an array as numbers of Python, which takes half the time of NumPy's."""
    return memoryview(array)  # type: ignore[arg-type]


RULES = Rules(np.inf, ENDLESS, EVERY, FIRST)
"""Of a single run: only an event ends it before its time."""


class Place:
    """The arrays of a run in one phase, and the loop that is bound to their addresses.

    Parameters
    ----------
    run
        The driver, whose tallies, log and samples all its places share.
    compiled
        The integrator.
    rows
        The events.
    """

    def __init__(self, run: "Driver", compiled: Compiled, rows: EventRows):
        made = compiled.integrator
        self.compiled = compiled
        self.rows = rows
        self.stepper: Any = run.stepper_of(compiled)
        self.motion = new_motion(len(made.state), len(made.pars), made.order + 1, run.lanes)
        found = run.findings(rows)
        self.loop = Loop(self.motion, rows, *found, run.rules, self.stepper)


class Driver:
    """Steps of one run in doubles, and the findings of the observer.

    Parameters
    ----------
    compiled
        The integrator.
    rows
        The events as this run looks for them: see `tallies.looked_for`.
    body
        The parameters of the integrator, perhaps with others behind.
    start
        The state at the start, (variables,), internal.
    functions
        The event functions there, (events,).
    end
        Internal time of the end.
    """

    lanes = 1
    rules = RULES
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
        self.at_start = functions
        self.end = end
        self.variables = len(start)
        self.number = start.dtype.type
        self.share(rows, functions[:, None], len(compiled.integrator.state))
        self.work_in(Place(self, compiled, rows))
        self.first = start[None, :].copy()
        self.take(self.place, body)
        self.put(start, (self.number(0), self.number(0)))
        self.end_at(end)

    def stepper_of(self, code: Compiled) -> Stepper:
        """Return the stepper of a new place."""
        return code.machine

    def share(self, rows: EventRows, functions: np.ndarray, width: int) -> None:
        """Make the arrays of all phases of a run that starts with these event functions,
        (events, 1), and has at most `width` variables.
        """
        room = PASSAGES + len(rows.events) * MOST_COEFFICIENTS
        number = self.number
        self.all_events = rows
        self.tallies = new_tallies(rows, functions)
        self.log = new_log(room, width, number)
        self.samples = new_samples(STEPS_PER_SLICE + 2, width, number)
        is_double = number in (float, np.float64)
        # of passages, in the working precision
        self.times = self.log.rows["time"] if is_double else np.zeros(room, number)
        names = "status", "steps", "upto", "tiny", "t"
        self.status, self.steps, self.upto, self.tiny, self.time = (
            view(self.tallies.lane[name]) for name in names
        )
        self.logged, self.sampled_so_far = map(view, (self.log.filled, self.samples.filled))
        self.want(NO_ROWS)

    def findings(self, rows: EventRows) -> tuple[Tallies, PassageLog, Samples]:
        """Return what the observer of a new place writes."""
        return self.tallies, self.log, self.samples

    def want(self, rows: Rows) -> None:
        """Make these rows from now on."""
        self.wanted = rows
        self.made = view(rows.filled)
        self.given = 0

    def work_in(self, place: Place) -> None:
        """Make the next steps in a place."""
        self.place = place
        self.compiled = place.compiled
        self.motion = place.motion
        self.loop = place.loop
        self.stepper = place.stepper

    def take(self, place: Place, body: Sequence[Any]) -> None:
        """Take the parameters of an integrator, perhaps with others behind."""
        pars = place.motion.pars[:, 0]
        pars[:] = body[: len(pars)]

    # --- steps -----------------------------------------------------------------------------------

    def advance(self, request: Request, most: int) -> Slice:
        """Make at most `most` steps; rows go to the request."""
        self.request = weakref.proxy(request)  # no cycle: arrays are free when the run is gone
        steps, when, last, ended = self.run(most)
        logged = slice(self.logged[0])
        sampled = slice(self.sampled_so_far[0])
        events = self.log.rows[logged]
        self.give()
        phases = events["phase"], self.samples.top[sampled], self.motion.in_lane
        states = (
            self.log.states[logged],
            self.samples.states[sampled],
            np.resize(last, (1, self.width)),
        )
        rows = self.rows_of(np.concatenate(phases), np.concatenate(states))
        at_passages, samples, last = np.split(rows, [len(events), -1])
        columns = self.times[logged], events["event"], events["sign"], events["at_pole"]
        passages = Passages._make([*(column.copy() for column in columns), at_passages])
        self.forget()
        return Slice(steps, when, last, samples, passages, ended)

    def run(self, most: int) -> tuple[int, Any, np.ndarray, Status | None]:
        """Make at most `most` steps. Return their number, the time and the state reached, and how
        the run ends there; None if it continues.
        """
        before = self.steps[0]
        self.drive(most)
        code = self.status[0]
        steps = self.steps[0] - before
        return steps, *self.reached(), None if code == RUNNING else STATUSES[code]

    def begin(self) -> None:
        """Mark the run as one that has made no step."""
        self.status[0], self.upto[0], self.tiny[0], self.steps[0] = RUNNING, 1.0, 0, 0

    def forget(self) -> None:
        """Forget samples and passages."""
        self.logged[0] = self.sampled_so_far[0] = 0

    def drive(self, most: int) -> int:
        """Make at most `most` steps and their rows, and return the number of steps."""
        steps = 0
        while True:
            if self.made[0] == self.wanted.length:
                self.ask()
            steps += self.make(most - steps if self.status[0] == RUNNING else 0)
            if self.made[0] < max(1, self.wanted.length):
                return steps

    def ask(self) -> None:
        """Give the rows that exist, and go on with those that are wanted next, or with room for
        some at the ends of steps.
        """
        self.give()
        times = self.request.wanted()
        n = len(times)
        filled = np.zeros(1, np.int64)
        states = np.empty((n, self.width), self.number)
        phases = np.empty(n, np.int64)
        self.want(Rows(times, states, phases, filled, self.request.steps, n))

    def give(self) -> None:
        """Give the rows that were made since the last time."""
        wanted = self.wanted
        made = slice(self.given, self.made[0])
        rows = self.rows_of(wanted.phases[made], wanted.states[made])
        self.given = made.stop
        if len(rows):
            self.request.take(wanted.times[made], rows)

    def rows_of(self, phases: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the rows of states (k, all variables), of which the numbers of phases are (k,)."""
        return states[:, : self.variables]

    def make(self, most: int) -> int:
        """Make at most `most` steps, write their rows, and return the number of steps."""
        self.loop.fill(self.wanted)
        return self.loop.drive(most)

    def reached(self) -> tuple[Any, np.ndarray]:
        """Return the internal time reached, and the state: of the last passage, if it ended the run
        within a step.
        """
        if self.upto[0] < 1.0:
            last = self.logged[0] - 1
            return self.times[last], self.log.states[last]
        return self.now, self.state

    # --- where the run is ------------------------------------------------------------------------

    @property
    def now(self) -> Any:
        """Internal time reached."""
        return self.time[0]

    @property
    def tally(self) -> Any:
        """The tally of the run."""
        return self.tallies.lane[0]

    @property
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""
        return float(self.motion.high[0]), float(self.motion.low[0])

    @property
    def state(self) -> np.ndarray:
        """All that is integrated, (all variables,), in the working precision."""
        return self.motion.state[:, 0]

    def put(self, state: Sequence[Any] | np.ndarray, clock: tuple[Any, Any]) -> None:
        """Put state and time in place."""
        self.motion.state[: len(state), 0], self.motion.state[len(state) :] = state, 0.0
        self.motion.high[0], self.motion.low[0] = clock

    def end_at(self, end: Any) -> None:
        """Put the end of the next steps at an internal time, `goal` in the working precision."""
        self.goal = end
        self.motion.end[0] = float(end)

    def last_rows(self) -> dict[str, Arrays]:
        """Return the rows of further tables that an end of the run here completes."""
        return {}

    def present(self) -> np.ndarray:
        """Return the present state, (1, variables), internal."""
        return self.rows_of(self.motion.in_lane, np.resize(self.state, (1, self.width)))

    def codes(self) -> tuple[Compiled, ...]:
        """Return the integrators of all phases."""
        return (self.compiled,)

    def extremes(self) -> Extremes:
        """Return those of the normal force so far, internal units; empty where none is known."""
        records = self.all_events.events
        functions = self.tallies.functions[:, 0]
        kept = records["extremes"]
        values = functions["extremes"][kept] / records["scale"][kept, None]
        pairs = np.stack([values, functions["times"][kept]], axis=-1)
        least = min(pairs[:, 0].tolist(), default=(np.inf, np.nan))
        most = max(pairs[:, 1].tolist(), default=(-np.inf, np.nan))
        return Extremes(*least, *most)

    @property
    def width(self) -> int:
        """The greatest number of variables of a phase, with those of event functions."""
        return self.log.states.shape[1]

    def snapshot(self) -> dict[str, Any]:
        """Return the state from which a run continues bit by bit."""
        return {
            "state": self.state.copy(),
            "time": list(self.clock),
            "tally": list(self.tallies.lane[0].item()),
            "functions": self.tallies.functions.view(float).tolist(),
            "kept": self.tallies.kept[:, 0].tolist(),
        }

    def joint(self, names: Iterable[str]) -> dict[str, Any]:
        """Return what a run that starts here needs in addition to the state: signs of the functions
        of these events, 0 if unknown, which decide whether a zero here has been passed.
        """
        signs = self.tallies.functions["sign"][:, 0] * self.place.rows.events["watched"]
        return {"signs": dict(zip(names, signs.astype(int).tolist(), strict=False))}

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot, of which state and time come in the working precision."""
        self.put(state, clock)
        self.forget()
        self.tallies.lane[0] = tuple(kept["tally"])
        self.tallies.functions.view(float)[:] = kept["functions"]
        self.tallies.kept[:, 0] = kept["kept"]
