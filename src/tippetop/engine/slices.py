"""What an engine gives of a run, slice by slice, whichever way its steps are made."""

import contextlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..mechanics.events import ON_ZERO
from ..mechanics.units import SECOND
from ..problem import Problem, Problems
from .compiled import Compiled
from .status import Status
from .tallies import (
    LEAST,
    MOST,
    T_LEAST,
    T_MOST,
    EventRows,
    PassageLog,
    Samples,
    StopRules,
    Tallies,
    mark_bounded,
    new_log,
    new_samples,
    new_tallies,
    reset,
)


STEPS_PER_SLICE = 8192  # about 20 ms of work
PASSAGES = 4096  # that a slice has room for: one every other step
EVERY = 8  # steps between two looks at the invariants: 1 % of the cost of the steps
FIRST = 256  # steps of a run that are all looked at: a short run has no more
ENDLESS = 1 << 62  # steps of a single run, which may take as long as it likes
STATUSES = {status.code: status for status in Status}


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
    """A run of accepted steps."""

    steps: int
    time: Any  # reached, internal, in the working precision
    last: np.ndarray  # (1, variables) the last good state
    samples: np.ndarray  # (k, variables) states on the way
    passages: Passages
    status: Status | None  # None: to be continued
    tables: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)  # new rows of further tables, SI


class Request(Protocol):
    """The rows that somebody wants of a run."""

    steps: bool  # at the ends of steps, rather than at given times

    def wanted(self) -> np.ndarray:
        """Internal times of the rows that are wanted next, (k,) doubles; of steps, room for so many. None are left
        where k = 0."""

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Takes rows: internal times (k,), states (k, variables)."""


class Wanted:
    """The times of rows that a run is asked for, internal, of which the first `made` are there: one for all phases of
    a contact."""

    def __init__(self) -> None:
        self.times, self.made = np.zeros(0), 0

    def ask(self, request: Request) -> None:
        """Asks for more times where none are left; for room, where rows are at the ends of steps."""
        if request.steps or self.made == len(self.times):
            self.times, self.made = request.wanted(), 0

    @property
    def left(self) -> np.ndarray:
        """The times whose rows are still to be made."""
        return self.times[self.made :]


class Room(NamedTuple):
    """What the observer of a run reads and writes: arrays that stay where they are, and serve one run after another."""

    rows: EventRows
    tallies: Tallies
    log: PassageLog
    samples: Samples


def new_room(compiled: Compiled) -> Room:
    """Room for the runs of an integrator."""
    rows = compiled.rows._replace(events=compiled.rows.events.copy())
    n, size = len(compiled.integrator.state), compiled.integrator.order + 1
    log = new_log(PASSAGES + len(rows.events) * size, n)
    samples = new_samples(FIRST + STEPS_PER_SLICE // EVERY + 2, n)
    return Room(rows, new_tallies(rows, 1), log, samples)


RULES = StopRules(-1, 0, 0.0, ENDLESS, EVERY, FIRST)
"""Of a single run: only an event ends it before its time."""


class Driver(ABC):
    """Makes the steps of one run, and knows what the observer found in them.

    Parameters
    ----------
    problem
        The run.
    compiled
        Its integrator.
    room
        Of that integrator, for this run alone while it lasts.
    """

    rules = RULES

    def __init__(self, problem: Problem, compiled: Compiled, room: Room):
        self.problem, self.compiled = problem, compiled
        self.variables = len(problem.variables.names)  # the others are integrals of event functions
        self.end = problem.number(problem.until) / problem.number(float(problem.scales.of(SECOND)))
        self.rows, self.tallies, self.log, self.samples = room
        watch(self.rows.events, compiled.rows.events, problem)
        self.ranged = next((e for e, event in enumerate(problem.system.events) if event.extremes), -1)
        self.scale = float(self.rows.events["scale"][self.ranged]) if self.ranged >= 0 else 1.0
        self.at_start = event_functions(problem.alone)[0]  # the event functions
        self.tallies.functions[:] = 0.0
        reset(self.tallies, self.rows, 0, *signs_of(self.at_start))
        self.wanted = Wanted()

    sentence = ""  # why the contact ended the run, where it did
    ended: Status | None = None  # how it ends the run before its first step

    @property
    def first(self) -> np.ndarray:
        """The state at the start, (1, variables), internal."""
        return self.problem.start()[None, :]

    def present(self) -> np.ndarray:
        """The present state, (1, variables), internal."""
        return self.state[None, : self.variables].copy()

    def equations(self) -> list[tuple]:
        """The equations of motion: pairs of a variable and its rate."""
        return list(self.compiled.integrator.sys)

    def end_at(self, end: Any) -> None:
        """Puts the end of the run at an internal time."""
        self.end = end

    @property
    def tally(self) -> Any:
        """What the observer knows of the run."""
        return self.tallies.lane[0]

    @abstractmethod
    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps; rows go to the request as they come."""

    @property
    @abstractmethod
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""

    @property
    @abstractmethod
    def state(self) -> np.ndarray:
        """All that is integrated, (all variables,), in the working precision."""

    @abstractmethod
    def put(self, state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Puts state and time in place."""

    def extremes(self) -> Extremes:
        """Of the normal force so far, internal units; empty where none is known."""
        if self.ranged < 0:
            return Extremes()
        known = self.tallies.functions[:, self.ranged, 0].tolist()
        return Extremes(known[LEAST] / self.scale, known[T_LEAST], known[MOST] / self.scale, known[T_MOST])

    def snapshot(self) -> dict[str, Any]:
        """What a run needs to continue bit by bit."""
        return {
            "state": self.state.copy(),
            "time": list(self.clock),
            "tally": list(self.tallies.lane[0].item()),
            "functions": self.tallies.functions[:, :, 0].tolist(),
            "kept": self.tallies.kept[:, 0].tolist(),
        }

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continues from a snapshot, of which state and time come in the working precision. Raises ValueError if it is
        of another run."""
        self.put(state, clock)
        self.tallies.lane[0] = tuple(kept["tally"])
        self.tallies.functions[:, :, 0] = kept["functions"]
        self.tallies.kept[:, 0] = kept["kept"]


def watch(records: np.ndarray, events: np.ndarray, problem: Problem) -> None:
    """Puts into `records` the events that a problem asks for: turnings are many, and nothing else needs them; they are
    found if logged."""
    records[:] = events
    records["watched"] = [not event.sense or event.name in problem.events for event in problem.system.events]
    if problem.on_liftoff != "stop":  # then no event ends a run
        records["ends"] = 0
    mark_bounded(records)


def event_functions(problems: Problems) -> np.ndarray:
    """The event functions of every run at its start, (n, events), internal units."""
    start, pars = problems.start.astype(float), problems.pars.astype(float)
    if problems.n == 1:  # numbers take a fifth of the time of arrays, but raise where those have infinities
        with contextlib.suppress(ArithmeticError, ValueError):
            return _event_functions(problems, start[:, 0].tolist(), pars[:, 0].tolist())
    return _event_functions(problems, start, pars)


def _event_functions(problems: Problems, start: Any, pars: Any) -> np.ndarray:
    body = problems.body_of_pars(pars)
    moment = problems.moment(start, body)
    functions = np.empty((problems.n, len(problems.base.system.events)))
    for e, event in enumerate(problems.base.system.events):
        functions[:, e] = np.asarray(event.formula(moment, body), float)
    return functions


def signs_of(functions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Signs of event functions at a start, and which of them are on their zero."""
    return np.where(functions > 0, 1.0, -1.0), np.abs(functions) < ON_ZERO
