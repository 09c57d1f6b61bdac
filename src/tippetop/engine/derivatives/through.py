"""Derivatives of a run through every change of its contact.

A plain run decides which phases follow each other. They are then followed once more: the flow of
each by its variational equations, one number in each lane; the start, times of events, jumps and
columns by dual numbers, which the formulas take like any numbers. The end of a phase so moves with
the numbers, which is the saltation matrix of the textbooks, and no jump needs written derivatives.
Whole steps in dual numbers would need step control and events a second time.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ...awaiting import awaited
from ...errors import InputError
from ...mechanics.contact.contact_phases import STICK
from ...mechanics.contact.surroundings import by_table, dotted_numbers
from ...mechanics.dual import COMPARED, Dual, parts_of, plain
from ...mechanics.form import CLOCK, Exit, Phase
from ...mechanics.operand import cos, kinds, leaves, refill, sin
from ...mechanics.units import SECOND, Scales, Unit
from ...mechanics.variables import Variables, variables_of
from ...problem import Problem
from ..driver import STEPS_PER_SLICE
from ..expressions import Formulas, formulas_of
from ..hybrid import QUIET, HybridDriver, PhaseInterval, PhaseSolver, begin_in_first, completed
from ..impacts import formulas_of_impact
from ..integrator import awaited_once
from ..variational import compiled_flow, expressions_of, in_motion
from .tape import Tape


MOST_LANES = 8
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state
EXACT = 1e-14  # tolerance of a step, of a phase that takes few
COARSE = 1e-12  # tolerance of an integrator from which on rounding is no part of its error
BRANCHES = 32
AHEAD = 1e-6
PER_INTERVAL, PER_TIME = 3, 6
"""States in a phase, and in a unit of time, by which it is seen what nearly happens."""
BRIEF_PHASE = 1e-4
"""Duration of a phase, such as one of the last hops of a ball, whose event function is zero where
it begins. The derivatives of this function are integrated: those of the state have lost digits.
"""
BOOLE = np.array([7, 32, 12, 32, 7]) / 90
BRIEF = 1e-9
"""Time of a jump in which the state stays; there are no derivatives in a longer one."""
NOISE = 1e-12
"""Event functions nearer to zero are rounding: of the last hops of a ball, nobody knows the number.
"""
PROJECTED_AT = 1e-2, 1e-5, 1e-9
"""Speeds before sliding stops at which derivatives are those at a fixed speed, not time.

beta' = Q/w is singular where w vanishes: the derivative at a fixed time is the difference of two
huge numbers there, and six digits would be lost.
"""


class Numbers(NamedTuple):
    """The numbers of a run, in its units, with derivatives by the relative changes of some."""

    scales: Scales
    first: Any  # the body
    body: Any  # the body as jumps take it
    rules: Any
    state: tuple  # the start
    sizes: np.ndarray  # [SI] what a relative change of 1 is


def numbers_of(
    problem: Problem, wrt: Sequence[str], of_world: Any, ways: np.ndarray, order: int = 1
) -> Numbers:
    """Return the numbers of a run, whose world has the body `of_world`, with derivatives along
    directions, (numbers, directions).
    """
    system = problem.system
    given: dict[str, Any] = {name: 0.0 for name in wrt if name.startswith("initial.")}
    for table, numbers in problem.tables.items():
        given |= {f"{table}.{name}": value for name, value in numbers.items()}
    sizes = np.array([abs(given[n]) or problem.unit(problem.rules[n].unit) for n in wrt])
    for name, size, way in zip(wrt, sizes, ways, strict=True):
        given[name] = Dual(float(given[name]), size * way, *[0 * way] * (order - 1))
    tables: dict[str, Any] = {t: {} for t in ("initial", "friction", "contact", "stem")}
    tables |= by_table(given)
    friction = problem.friction._replace(**tables["friction"])
    b = system.body_of(tables["parameters"] | dotted_numbers(tables), friction)
    mass, length = system.scales(b)
    scales = Scales(mass, length * problem.form.length_unit, problem.unit(SECOND))

    def internal(value: Any, unit: Any) -> Any:
        return value / scales.of(unit)

    units = leaves(system.body_units(problem.law.units()))
    first = refill(b, map(internal, leaves(b), units))._replace(**system.folds(problem.form))
    body = first
    rules = problem.contact
    if rules is not None:
        rules = rules._replace(**(tables["contact"] | tables["stem"]))
    if system.assembled is not None:
        body, _ = system.assembled(first, rules, internal)
    data = tables["initial"]
    theta = data.get("theta", 0.0)
    s = sin(theta)
    z = cos(theta)
    angles = system.start(data, s, z, b)
    variables = problem.variables
    q, carried = variables.start(data, angles, s, z, b)
    values = [*map(internal, (*q, *carried), variables.units.values())]
    state = variables.join(values[: variables.moving], values[variables.moving :])
    return Numbers(
        scales,
        valued(first, leaves(problem.internal_body)),
        valued(body, leaves(of_world)),
        rules,
        valued(tuple(state), problem.start()),
        sizes,
    )


def valued(record: Any, values: Any) -> Any:
    """Return a record with other values, and its derivatives."""
    pairs = zip(leaves(record), values, strict=True)
    made = (
        Dual(float(value), *one.parts[1:]) if isinstance(one, Dual) else float(value)
        for one, value in pairs
    )
    return refill(record, made)


def joined(values: Any, moves: np.ndarray) -> list[Dual]:
    """Return dual numbers of these values (n, ...) and derivatives (n, directions, ...)."""
    return [Dual(*pair) for pair in zip(values, moves, strict=True)]


def parted(numbers: Sequence, directions: int, order: int = 1) -> Any:
    """Return the values (n,) and derivatives (n, directions) of numbers."""
    values, *moves = zip(*(parts_of(one, order) for one in numbers), strict=True)
    none = np.zeros(directions)
    return np.array(values, float), *(np.array([by + none for by in move]) for move in moves)


class Motion(NamedTuple):
    """The equations of a phase or of an impact, and the numbers of the body in them."""

    formulas: Formulas
    variables: Variables
    pars: np.ndarray
    moves: np.ndarray
    bends: tuple[np.ndarray, ...] = ()  # their second derivatives
    tolerance: float = EXACT
    careful: bool = False

    def flow(
        self, times: np.ndarray, values: np.ndarray, *moves: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """Return the state after each of these times, ascending, with its derivatives.

        They are (n, times) and (n, directions, times).
        """
        order = len(moves)
        directions = moves[0].shape[1]
        lanes = 1 << min(directions - 1, MOST_LANES - 1).bit_length()
        key = self.formulas, self.variables, lanes, order, self.tolerance, self.careful
        ta = awaited_once(compiled_flow, key, "the variational equations are being compiled")
        sizes = np.abs(moves[0]).max(axis=0).clip(min=1.0)  # the largest decide the errors

        def scaled(values: np.ndarray, *moves: np.ndarray) -> np.ndarray:
            each = (move / sizes**k for k, move in enumerate(moves, 1))
            return np.array([np.repeat(values[:, None], directions, axis=1), *each])

        known = scaled(self.pars, self.moves, *self.bends).swapaxes(0, 1).reshape(-1, directions)
        state = scaled(values, *moves).reshape(-1, directions)
        found = np.empty((*state.shape, len(times)))
        grid = times if times[0] == 0 else np.append(0.0, times)
        for first in range(0, directions, lanes):
            some = np.arange(first, first + lanes).clip(max=directions - 1)
            with _one_at_a_time:
                ta.set_time(0.0)
                ta.state[:] = state[:, some]
                ta.pars[:] = known[: len(ta.pars), some]
                _, rows = ta.propagate_grid(np.repeat(grid[:, None], lanes, axis=1))
            found[:, some] = np.moveaxis(rows[-len(times) :], 0, -1)
        parts = found.reshape(order + 1, -1, directions, len(times))
        moved = (part * sizes[:, None] ** k for k, part in enumerate(parts[1:], 1))
        return parts[0, :, 0], *moved

    def rates(self, values: np.ndarray, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rates of the variables and of their derivatives."""

        def rates(_: Any, pars: tuple, state: tuple) -> tuple:
            q, carried = self.variables.split(state)
            return self.variables.rates(q, carried, self.formulas.body(iter(pars))), None

        return self._evaluated(None, rates, values, self.moves[:, : moves.shape[1]], moves)

    def slopes(
        self, event: Any, values: np.ndarray, moves: np.ndarray, rates: np.ndarray, order: int = 0
    ) -> np.ndarray:
        """Return the derivatives of an event function, and last that by time; of order 1, those of
        its rate.
        """
        events = self.formulas.events

        def function(_: Any, pars: tuple, state: tuple) -> tuple:
            b = self.formulas.body(iter(pars))
            now = in_motion(self.variables, state, b, order) if order else state
            q, carried = self.variables.split(now)
            if event in events:
                h = self.formulas.functions(q, carried, b)[events.index(event)]
            else:
                h = event.formula(self.formulas.form.scalars(q, b), b)
            return [parts_of(h, 1)[1] if order else h], None

        ways = np.concatenate([moves, rates[:, None]], axis=1)
        of_pars = np.concatenate([self.moves, 0 * self.pars[:, None]], axis=1)
        return self._evaluated((event, order), function, values, of_pars, ways)[1][0]

    def gains(self, event: Any, states: Any, time: float) -> np.ndarray:
        """Return by how much the derivatives of an event function change along five states, which
        are evenly spaced in a time.
        """
        paces = [
            self.slopes(event, values, moves, self.rates(values, moves[:, :0])[0], 1)[:-1]
            for values, moves in states
        ]
        return time * (BOOLE @ np.array(paces))

    def _evaluated(self, what: Any, function: Callable, values: np.ndarray, *moves: Any) -> tuple:
        """Return numbers that are function(_, numbers of the body, state), and derivatives."""
        records = tuple(self.pars), tuple(values)
        key = self.formulas, self.variables, what
        given = np.concatenate([self.pars, values]), np.concatenate(moves)
        return evaluated(key, function, records, *given)[:2]

    def happens(
        self, event: Any, values: np.ndarray, moves: np.ndarray, known: Any = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivative of the time at which an event happens, and the state there.

        `known`: the derivatives of its function, where they are known better than from the state.
        """
        rates, _ = self.rates(values, moves[:, :0])
        *by, pace = self.slopes(event, values, moves, rates)
        shift = -np.array(by if known is None else known) / pace
        return shift, moves + np.outer(rates, shift)

    def lost(self, event: Any, values: np.ndarray, moves: np.ndarray) -> np.ndarray:
        """Return the change along each direction at which an event no longer happens.

        There the next extreme of its function comes to zero.
        """
        rates, turns = self.rates(values, moves)
        now = self.slopes(event, values, moves, rates)
        ahead = values + AHEAD * rates
        later = self.slopes(event, ahead, moves + AHEAD * turns, self.rates(ahead, moves[:, :0])[0])
        *turns, bend = (later - now) / AHEAD
        *by, pace = now
        extreme = pace**2 / (2 * abs(bend))
        least = extreme / abs(np.array(by) - pace / bend * np.array(turns))
        return least if extreme > NOISE else np.inf * least


@contextmanager
def noting(directions: int) -> Iterator[list[np.ndarray]]:
    """Collect the changes along each direction at which comparisons turn out otherwise."""
    least = [np.full(directions, np.inf)]

    def note(one: Dual) -> None:
        if np.shape(one.first) == (directions,):  # otherwise it is along another line
            least.append(abs(one.value) / abs(one.first))

    token = COMPARED.set(note)
    try:
        yield least
    finally:
        COMPARED.reset(token)


@lru_cache(maxsize=1024)
def tapes_of(key: tuple) -> list[Tape]:
    """Return the tapes of a function, one for each branch on which it was called so far."""
    return []


def evaluated(
    key: tuple,
    function: Callable,
    records: tuple,
    values: np.ndarray,
    moves: np.ndarray,
    follow: Any = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Any]:
    """Call a function with derivatives, by a tape of it if possible.

    Return its numbers, their derivatives, the least change along each direction at which a
    comparison turns out otherwise, and its second result.

    Parameters
    ----------
    key
        Identifies the function.
    function
        function(call, *records) -> numbers, and what they depend on; call(place, function, *inputs)
        follows a motion.
    records, values, moves
        The inputs: as records, their values, and derivatives (inputs, directions).
    follow
        follow(place, values, moves) of a motion.
    """
    tapes = tapes_of(key)
    for tape in tapes:
        if made := tape(values, moves, follow):
            return *made, tape.about
    if len(tapes) < BRANCHES:
        with suppress(Exception):  # whatever it does that is no line of a tape
            tape = Tape(function, *records)
            if made := tape(values, moves, follow):
                tapes.append(tape)
                return *made, tape.about

    def call(place: int, _: Any, *given: Any) -> list:
        return joined(*follow(place, *parted(leaves(given), moves.shape[1])))

    with noting(moves.shape[1]) as least:
        results, about = function(call, *refill(records, iter(joined(values, moves))))
    return *parted(results, moves.shape[1]), np.fmin.reduce(least), about


# --- the pass -------------------------------------------------------------------------------------


class Note(NamedTuple):
    """How far numbers may change before a comparison or an exit differs: see `Pass.notes`."""

    time: float
    what: str
    least: np.ndarray  # relative change along each direction


class Samples(NamedTuple):
    """States in a phase at some times since it began.

    `shift` is the derivative of these times, as the beginning moves.
    """

    solver: PhaseSolver
    shift: np.ndarray
    which: np.ndarray  # of the times, or the number of the phase for each of them
    values: np.ndarray  # (n, times)
    moves: np.ndarray  # (n, directions, times)


class Pass:
    """Repeat a run with derivatives.

    Parameters
    ----------
    problem
        The run.
    wrt
        Dotted names of numbers.
    times
        Internal times of states, ascending; the run is followed to the last.
    ways
        Directions, (numbers, directions); by default one number each.
    order
        1, or 2 for second derivatives of a smooth run.

    Attributes
    ----------
    intervals, shifts
        The phases that end in this time, and the derivatives of the times at which they do.
    samples
        States with derivatives at the times.
    notes
        What could turn out otherwise.
    """

    steps = False
    states: np.ndarray | None = None  # of a smooth run, as rows

    @QUIET
    def __init__(
        self,
        problem: Problem,
        wrt: Sequence[str],
        times: np.ndarray,
        ways: np.ndarray | None = None,
        order: int = 1,
    ):
        ways = np.eye(len(wrt)) if ways is None else ways
        self.problem = problem
        self.times = times
        self.directions = ways.shape[1]
        self.order = order
        self.motions = dict[str, Motion]()
        self.intervals = list[PhaseInterval]()
        self.shifts = list[np.ndarray]()
        self.samples = list[Samples]()
        if not problem.system.is_hybrid:
            self.numbers = numbers_of(problem, wrt, problem.internal_body, ways, order)
            self._flow()
            return
        self.driver = driver = HybridDriver(problem)
        self.runs = driver.intervals = list[PhaseInterval]()
        status = driver.ended
        while status is None and driver.clock[0] <= times[-1]:
            status = driver.advance(self, STEPS_PER_SLICE).status
        if not self.runs or (self.runs[-1].jump is not None and status is None):
            driver.last_rows()
        with noting(self.directions) as least:
            self.numbers = numbers_of(problem, wrt, driver.world.body, ways)
        rules = self.numbers.rules
        given = self.numbers.body, () if rules is None else (rules.e_n,)
        self.plain = plain(given)
        self.known = parted(leaves(given), self.directions)
        self.regions = [*driver.impacts.stages] if rules else []
        self.notes = [Note(0.0, "the law of friction", np.fmin.reduce(least))]
        self.between = list[Samples]()  # states in each phase, for what nearly happened
        self._follow()

    def _flow(self) -> None:
        """Follow a smooth run."""
        problem = self.problem
        numbers = self.numbers
        formulas = formulas_of(problem.system, problem.form.name, problem.friction.__class__)
        pars, moves, *bends = parted(leaves(numbers.body), self.directions, self.order)
        careful = problem.tolerance < COARSE
        motion = Motion(
            formulas, problem.variables, pars, moves, tuple(bends), problem.tolerance, careful
        )
        self.motions[""] = motion
        start = parted(numbers.state, self.directions, self.order)
        values, *every = motion.flow(self.times, *start)
        solver: Any = SimpleNamespace(name="")
        which = np.arange(len(self.times))
        self.samples = [Samples(solver, np.zeros(self.directions), which, values, every[0])]
        whole = np.broadcast_to(values[:, None], every[0].shape)
        self.states = np.stack([whole, *every], axis=1)

    def next_times(self) -> np.ndarray:
        """Request no rows of the plain run."""
        return np.zeros(0)

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Ignore rows of the plain run."""

    @QUIET
    def _follow(self) -> None:
        """Repeat all phases and jumps of the plain run with derivatives."""
        begin = Exit("start", (), self.problem.system.begin or begin_in_first)
        phase = completed(self.problem.system.phase, self.problem.variables)
        now = Dual(0.0, np.zeros(self.directions))
        state = parted(self.numbers.state, self.directions)
        (name, _), delay, lasts, state = self._jumped(phase, begin, state, now)
        zeros: Any = ()  # of events that a number of the start may move
        for interval in self.runs:
            if name != interval.solver.name:
                self.notes.append(Note(now.value, "what follows", 0 * now.first))
                return
            began = now + delay
            which = self._within(now.value, interval.began)
            if interval.began - now.value < BRIEF:
                rows = (np.repeat(one[..., None], len(which), axis=-1) for one in state)
                self.samples.append(Samples(interval.solver, began.first, which, *rows))
            state, now = self._ended(interval, state, began, lasts, zeros)
            if interval.jump is None or not interval.ended <= self.times[-1]:
                return
            self.intervals.append(interval)
            self.shifts.append(now.first)
            made = self._jumped(interval.solver.phase, interval.jump.exit, state, now)
            (name, zeros), delay, lasts, state = made
            if not name:
                return

    def _jumped(self, phase: Phase, exit: Exit, state: tuple, now: Dual) -> tuple:
        """Make a jump with derivatives.

        Return the next phase, the time until it begins, the longest time that it lasts, and its
        variables.
        """
        driver = self.driver
        world = driver.world._replace(phase=phase)
        impacts: Any = getattr(driver, "impacts", None)

        def jumped(call: Callable, body: Any, rules: tuple, left: tuple, state: tuple) -> tuple:
            def piece(region: str, *given: Any) -> list:
                place = self.regions.index(region)
                return call(place, partial(impacts.piece, region), *given)

            now = world._replace(body=body, left=left[0])
            if rules:
                e_n = world.rules._replace(e_n=rules[0])
                now = now._replace(rules=e_n, struck=partial(impacts.struck, piece=piece))
            q, carried = variables_of(phase.form).split(state)
            x = phase.leave(q, phase.parameters(body))
            if hasattr(x, "carried"):
                x = x._replace(carried=carried)
            n = exit.jump(x, now)
            if n.ends:
                return [n.delay, 0.0], ("", ())
            to = driver.solver_of(n.phase)
            carried = getattr(n.x, "carried", carried)
            q = to.phase.enter(n.x, to.phase.parameters(body))
            return [n.delay, n.lasts, *to.variables.join(q, carried)], (n.phase, (*n.zeros,))

        left = float(driver.end) - now
        of_left = np.array([left.value]), left.first[None]
        inputs = [*map(np.concatenate, zip(self.known, of_left, state, strict=True))]
        records = *self.plain, tuple(of_left[0]), tuple(state[0])
        restitution = self.numbers.rules and self.numbers.rules.restitution
        key = phase, exit.jump, restitution, kinds(world.body)
        try:
            made = evaluated(key, jumped, records, inputs[0], inputs[1], self._motion)
        except ArithmeticError as error:
            self.notes.append(Note(now.value, f"what follows `{exit.event}`", 0 * now.first))
            return (str(error), ()), now, now, state
        except (TypeError, AttributeError, ValueError) as error:
            raise InputError(
                f"the jump by `{exit.event}` of `{self.problem.system.name}` must take numbers "
                "with derivatives: use operators and NumPy's functions, not `math` or `float`, but "
                f"{type(error).__name__}: {error}"
            ) from error
        values, moves, least, name = made
        if not exit.smooth:
            self.notes.append(Note(now.value, f"what follows `{exit.event}`", least))
        return name, *joined(values[:2], moves[:2]), (values[2:], moves[2:])

    def _motion_of(self, solver: PhaseSolver) -> Motion:
        """Return the equations of a phase."""
        if solver.name not in self.motions:
            b = solver.phase.parameters(self.numbers.body)
            known = parted(leaves(b), self.directions)
            self.motions[solver.name] = Motion(solver.formulas, solver.variables, *known)
        return self.motions[solver.name]

    def _within(self, began: float, ended: float) -> np.ndarray:
        """Return which of the times lie after one time, or at the start, and not after another."""
        first = 0 if began == 0 else np.searchsorted(self.times, began, side="right")
        return np.arange(first, np.searchsorted(self.times, ended, side="right"))

    def _ended(
        self, interval: PhaseInterval, state: tuple, began: Dual, lasts: Any, zeros: Any
    ) -> tuple[Any, Dual]:
        """Return the state where a phase ends, and the time, of the state where it begins.

        `zeros`: the events whose functions are zero there.
        """
        solver = interval.solver
        motion = self._motion_of(solver)
        values, moves = state
        more = np.zeros(self.directions)
        done = interval.began
        end = min(interval.ended, self.times[-1])
        exit = interval.jump and interval.jump.exit
        last = np.array(interval.last)
        stops = []
        if exit and exit.event == STICK.name:
            w = motion.variables.names.index("w")
            pace = motion.rates(last, moves[:, :0])[0][w]
            stops = [interval.ended + speed / pace for speed in PROJECTED_AT]
            stops = [stop for stop in stops if (done + end) / 2 < stop < end]
        for stop in (*stops, end) if end > done else ():
            which = self._within(done, stop)
            count = PER_INTERVAL + int(PER_TIME * (stop - done))
            apart = np.linspace(done, stop, count + 2)[1:]
            every = np.concatenate([self.times[which], apart])
            times, back = np.unique(every, return_inverse=True)
            values, moves = motion.flow(times - done, values, moves)
            for found, some, of, shift in (
                (self.samples, back[: len(which)], which, began.first + more),
                (
                    self.between,
                    back[len(which) : -1],
                    np.full(count, len(self.intervals)),
                    0 * more,
                ),
            ):
                found.append(Samples(solver, shift, of, values[:, some], moves[..., some]))
            values = values[:, -1]
            moves = moves[..., -1]
            done = stop
            if stop < end:
                rates, _ = motion.rates(values, moves[:, :0])
                by = -moves[w] / rates[w]
                moves = moves + np.outer(rates, by)
                more = more + by
        by = 0 * more
        if exit and end == interval.ended:
            if exit.event == CLOCK:
                by = lasts.first - more
                moves = moves + np.outer(motion.rates(last, moves[:, :0])[0], by)
            else:
                ending = next(one for one in solver.phase.events if one.name == exit.event)
                if not exit.smooth:
                    least = motion.lost(ending, last, moves)
                    self.notes.append(Note(interval.ended, f"`{exit.event}`", least))
                known = None
                if exit.event in zeros and end - interval.began < BRIEF_PHASE:
                    *_, within = self.between
                    three = zip(*(np.moveaxis(one, -1, 0) for one in within[-2:]), strict=True)
                    known = motion.gains(
                        ending, (state, *three, (last, moves)), end - interval.began
                    )
                by, moves = motion.happens(ending, last, moves, known)
        of = np.full(1, len(self.intervals))
        self.between.append(Samples(solver, 0 * by, of, last[:, None], moves[..., None]))
        return (last, moves), Dual(interval.ended, began.first + more + by)

    def _motion(self, place: int, values: np.ndarray, moves: np.ndarray) -> tuple:
        """Integrate a piece of an impact with derivatives; see `ImpactMotions.piece`."""
        impacts = self.driver.impacts
        region = self.regions[place]
        formulas = formulas_of_impact(impacts.law, region, *impacts.pattern)
        variables = variables_of(formulas.form, False)
        count = len(formulas.events)
        size = len(variables.names)
        end, most = values[:2]
        signs, zeros, state, pars = np.split(
            values[2:], [count, 2 * count, 2 * count + impacts.driver(region).width]
        )
        given: Any = signs, zeros, state, pars
        made = impacts.piece(region, end, int(most), *given)
        results = np.zeros((len(made), self.directions))
        at = 2 + 2 * count
        motion = Motion(formulas, variables, pars, moves[-len(pars) :])
        elapsed = float(impacts.driver(region).reached()[0])
        _, after = motion.flow(np.array([elapsed]), state[:size], moves[at : at + size])
        after = after[..., 0]
        if made[2] >= 0:
            last = np.array(made[3 : 3 + size])
            _, after = motion.happens(formulas.events[int(made[2])], last, after)
        results[3 : 3 + size] = after
        return np.array(made, float), results

    # --- what was found ---------------------------------------------------------------------------

    def _together(self, samples: list[Samples]) -> Iterator[tuple]:
        """Yield each phase, the body in it, and all samples there as state and numbers."""
        for solver in self.driver.solvers.values():
            if mine := [one for one in samples if one.solver is solver]:
                which, values, moves = (
                    np.concatenate([one[k] for one in mine], axis=-1) for k in (2, 3, 4)
                )
                split = solver.variables.split
                rates = np.array(
                    [
                        rate + 0 * values[0]
                        for rate in solver.variables.rates(*split(values), solver.b)
                    ]
                )
                shifts = [np.repeat(one.shift[:, None], len(one.which), axis=1) for one in mine]
                moves = moves - rates[:, None] * np.concatenate(shifts, axis=-1)
                b = _columned(solver.phase.parameters(self.numbers.body))
                yield solver, b, split(joined(values, moves)), which

    @QUIET
    def rows(self) -> np.ndarray:
        """Return the values and derivatives of the variables of the run at all times.

        The array is (variables, order + 1, directions, times), in internal units.
        """
        if self.states is not None:
            return self.states
        variables = self.problem.variables
        shape = self.directions, len(self.times)
        rows = np.full((len(variables.names), 2, *shape), np.nan)
        if self.times[0] == 0:  # a phase may begin later
            values, moves = parted(self.numbers.state, self.directions)
            rows[:, 0, :, 0] = values[:, None]
            rows[:, 1, :, 0] = moves
        for solver, b, (q, carried), which in self._together(self.samples):
            read, _ = self.problem.system.read(solver.phase, q, carried, b)
            every = variables.join(read[: variables.moving], carried)
            for row, one in zip(rows, every, strict=True):
                for part, values in zip(row, parts_of(one, 1), strict=True):
                    part[:, which] = values
        return rows

    @QUIET
    def read(self) -> dict[str, np.ndarray]:
        """Return the columns and other functions of the state at all times, by name.

        Each is (order + 1, times, directions): values and derivatives.
        """
        state = [Dual(value[0], *moves) for value, *moves in self.rows()]
        first = _columned(self.numbers.first)
        found = expressions_of(self.problem.system, self.problem.variables, state, first)
        shape = self.directions, len(self.times)
        return {
            name: np.array([np.broadcast_to(part, shape).T for part in parts_of(value, self.order)])
            for name, value in found.items()
        }

    def in_units(self, table: np.ndarray, unit: Unit) -> np.ndarray:
        """Return values and derivatives in units that do not change with the numbers."""
        ratio = self.numbers.scales.of(unit) / self.problem.unit(unit)
        return np.array((Dual(*table) * ratio).parts)

    @QUIET
    def times_of(self, names: Sequence[str], times: np.ndarray) -> np.ndarray:
        """Return the derivatives of the times of events, (events, directions).

        A time is that of the end of a phase, or of the zero of an event function.
        """
        shifts = np.zeros((len(times), self.directions))
        ends = [interval.ended for interval in self.intervals]
        at = {self.times[k]: (one, c) for one in self.samples for c, k in enumerate(one.which)}
        for k, (name, time) in enumerate(zip(names, times, strict=True)):
            interval = np.searchsorted(ends, time)
            if interval < len(ends) and ends[interval] == time:
                shifts[k] = self.shifts[interval]
                continue
            if time not in at:  # in a jump that takes time; the start of a run does not move
                shifts[k] = np.nan if time > 0 else 0.0
                continue
            one, column = at[time]
            motion = self._motion_of(one.solver)
            for event in motion.formulas.events:
                if event.name == name:
                    state = one.values[:, column], one.moves[..., column]
                    shifts[k] = one.shift + motion.happens(event, *state)[0]
        return shifts

    @QUIET
    def margins(self) -> list[Note]:
        """Return all notes by time, with those of exits that nearly happened."""
        notes = list(self.notes)
        ends = self.runs
        for solver, b, (q, _), which in self._together(self.between):
            scalars = solver.phase.form.scalars(q, b)
            exits = {one.event for one in solver.phase.exits if not one.smooth}
            for event in solver.phase.events:
                if event.name not in exits or event.sampled:
                    continue
                h, by = parts_of(event.formula(scalars, b), 1)
                size = np.abs(h)
                least = size / np.abs(by)
                for k in _lows(size, which):
                    if size[k] < NOISE:
                        continue
                    interval = ends[which[k]]
                    is_end = k + 1 == len(which) or which[k + 1] != which[k]
                    if not (is_end and interval.jump and interval.jump.exit.event == event.name):
                        notes.append(Note(interval.began, f"`{event.name}`", least[:, k]))
        return sorted(notes, key=attrgetter("time"))


def followed(problem: Problem, wrt: Sequence[str], times: np.ndarray, *options: Any) -> Pass:
    """Return the `Pass` of a run to times [s], while signals are handled."""
    internal = times / problem.unit(SECOND)
    follow = partial(Pass, problem, wrt, internal, *options)
    return awaited(follow, "the variational equations are integrated")


def _columned(record: Any) -> Any:
    """Return numbers of a record for arithmetic with arrays."""
    numbers = (
        Dual(one.value, *(part[:, None] for part in one.parts[1:]))
        if isinstance(one, Dual)
        else one
        for one in leaves(record)
    )
    return refill(record, numbers)


def _lows(size: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Return where a function has a minimum in a phase that it does not begin with."""
    falls = np.append(False, (size[1:] <= size[:-1]) & (which[1:] == which[:-1]))
    rises = np.append((size[1:] > size[:-1]) | (which[1:] != which[:-1]), True)
    return np.flatnonzero(falls & rises)
