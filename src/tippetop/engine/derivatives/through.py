"""Derivatives of a run through every change of its contact.

`followed(problem, wrt, times)` is the entrance; it returns a `Pass`, from which `sensitivities`
takes columns, times of events, and how far they are valid. A plain run decides which phases follow
each other. They are then followed once more: the flow of each by its variational equations, one
number in each lane; the start, times of events and jumps by dual numbers, which the formulas take
like any numbers. Columns are functions of the rows, compiled with derivatives. The end of a phase
so moves with the numbers, which is the saltation matrix of the textbooks, and no jump needs written
derivatives. Whole steps in dual numbers would need step control and events a second time.

Symbols
    rows      numbers with derivatives as an array (n, 1 + order, directions, ...): the value, again
              for each direction, then its derivatives
    state     such rows of the variables of a phase; its last row is the time, so that the time
              moves with the end of a phase too
    direction a change of the numbers of the user, each relative to its size; wrt: their names
    pace      the rate of an event function; by: its derivatives along the directions
    motion    a `Motion`: the equations of a phase or of an impact
    jump, n   a `hybrid.Jump`, and its result, a `form.Next`
    q, b      state and parameters of a phase, records of its form and of `Phase.parameters`
    place     the index of a region of an impact, by which a program refers to its motion
    h         the value of an event function, a `Dual`
"""

import operator
import threading
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ...awaiting import awaited
from ...errors import InputError
from ...mechanics.contact.contact_phases import STICK
from ...mechanics.dual import COMPARED, Dual, parts_of, plain
from ...mechanics.operand import kinds, leaves, refill, sqrt
from ...mechanics.rotation import outer
from ...mechanics.units import SECOND, Scales
from ...mechanics.variables import Variables, variables_of
from ...problem import Problem, Problems
from ..column_programs import repeated
from ..expressions import (
    AXES,
    Formulas,
    axes_in,
    compile_observables,
    formulas_of,
    observed,
    orientation_of,
)
from ..hybrid import QUIET, Jump, PhaseInterval, assembled
from ..impacts import formulas_of_impact
from ..integrator import awaited_once
from ..observables import QUATERNION
from ..orientation import quaternion
from ..variational import Moving, compiled_flow, in_motion


MOST_LANES = 8
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state
PER_INTERVAL, PER_TIME = 3, 6
"""States in a phase, and in a unit of time, by which it is seen what nearly happens."""
BRIEF_PHASE = 1e-4
"""Duration of a phase, such as one of the last hops of a ball, whose event function is zero where
it begins. The derivatives of this function are integrated: those of the state have lost digits.
"""
SIMPSON = np.array([1, 4, 1]) / 6
BRIEF = 1e-9
"""Time of a jump in which the state stays; there are no derivatives in a longer one."""
NOISE = 1e-12
"""Event functions nearer to zero are rounding: the number of a ball's last hops is not known."""
PROJECTED_AT = 1e-2, 1e-5, 1e-9
"""Times before sliding stops at which derivatives are those at a fixed speed, not time.

beta' = Q/w is singular where w vanishes: the derivative at a fixed time is the difference of two
huge numbers there, and six digits would be lost.
"""


def as_rows(numbers: Sequence, order: int, *shape: int) -> np.ndarray:
    """Return numbers as rows: values and derivatives up to an order, (n, 1 + order, *shape).

    A number without derivatives gets zeros. The shape begins with the directions.
    """
    parts = [np.broadcast_to(part, shape) for one in numbers for part in parts_of(one, order)]
    return np.reshape(parts, (len(numbers), 1 + order, *shape)).astype(float)


def duals_of(rows: np.ndarray) -> list[Dual]:
    """Return rows as dual numbers, (n,): the inverse of `as_rows`.

    The value is that of the first direction, as all are equal.
    """
    return [Dual(row[0, 0], *row[1:]) for row in rows]


class Motion(NamedTuple):
    """The equations of a phase or of an impact, and the numbers of the body in them."""

    formulas: Formulas
    variables: Variables
    pars: np.ndarray  # leaves of the parameters of the formulas, as rows

    @property
    def body(self) -> Any:
        """Return the body with derivatives, for states `in_time`: by time they are 0."""
        return self.formulas.body(
            Dual(value[0], np.append(first, 0.0)[:, None]) for value, first, *_ in self.pars
        )

    def flow(self, times: np.ndarray, state: np.ndarray) -> np.ndarray:
        """Return the state, as rows (n, ..., times), after each of these internal times.

        `state` are the rows from which it flows; `times` count from there. Rows after those of the
        variables, such as the time, keep their numbers: the derivatives are those after a fixed
        duration. At the end of a phase `_ended` replaces the values by those of the plain run.
        """
        size = len(self.variables.names)
        _, parts, directions = state.shape
        lanes = 1 << min(directions - 1, MOST_LANES - 1).bit_length()
        key = self.formulas, self.variables, lanes, parts - 1
        ta = awaited_once(compiled_flow, key, "the variational equations are being compiled")
        # each direction is divided by its largest derivative, as the largest numbers of a lane
        # decide its errors; derivatives of order k take the power k of this size
        sizes = np.abs(state[:size, 1]).max(axis=0).clip(min=1.0)
        scales = sizes ** np.arange(parts)[:, None]
        # each number before its derivatives, as `compiled_flow` takes them
        start, known = (
            (rows / scales).reshape(-1, directions) for rows in (state[:size], self.pars)
        )
        # the grid must begin at the time of the state; `back[1:]` leaves this time out again
        grid, back = np.unique(np.append(0.0, times), return_inverse=True)
        after = np.repeat(state[..., None], len(grid), axis=-1)
        for first in range(0, directions, lanes) if len(grid) > 1 else ():
            # lanes without a direction repeat the last one
            some = np.arange(first, first + lanes).clip(max=directions - 1)
            with _one_at_a_time:
                ta.set_time(0.0)
                ta.state[:] = start[:, some]
                ta.pars[:] = known[: len(ta.pars), some]
                _, rows = ta.propagate_grid(np.repeat(grid[:, None], lanes, axis=1))
            moved = np.moveaxis(rows, 0, -1).reshape(size, parts, lanes, len(grid))
            after[:size, :, some] = moved * scales[:, some, None]
        after[:, 0] = after[:, 0, :1]  # lanes take their own steps
        return after[..., back[1:]]

    def in_time(self, state: np.ndarray) -> np.ndarray:
        """Return states (n, ..., times) at fixed times, with time as one more direction.

        The last row of a state is its time, whose derivatives are taken out of those of all rows.
        """
        q, carried = self.variables.split(state[:, 0, 0])
        rates = *self.variables.rates(q, carried, plain(self.body)), 1.0
        # the added direction is a copy for its value; the loop writes its derivative
        moved = np.concatenate([state, state[:, :, :1]], axis=2)
        for row, rate in zip(moved, rates, strict=True):
            row[1, :-1] -= rate * state[-1, 1]
            row[1, -1] = rate
        return moved

    def functions(self, state: np.ndarray) -> dict[str, Dual]:
        """Return the event functions of states `in_time`, by the name of the event."""
        q, carried = self.variables.split(duals_of(state))
        values = self.formulas.functions(q, carried, self.body)
        events = self.formulas.events
        return {e.name: Dual(*parts_of(h, 1)) for e, h in zip(events, values, strict=True)}

    def slopes(self, event: Any, state: np.ndarray) -> tuple:
        """Return the rates of a state; and a function of an event, or the time without one, and its
        first two time derivatives, as rows.

        `state` are rows at one time. The rates end with that of the time, 1, if the state has it.
        """
        size = len(self.variables.names)

        def function(numbers: list) -> list:
            """Return the rates, then the function and its time derivatives.

            `numbers`: those of the body, then the variables.
            """
            rest = iter(numbers)
            b = self.formulas.body(rest)
            moving = in_motion(self.variables, [*rest], b, 2)
            q, _ = self.variables.split(moving)
            h = event.formula(self.formulas.form.scalars(q, b), b) if event else Moving(0.0, 1.0)
            return [*(one.first for one in moving), *parts_of(h, 2)]

        numbers = np.concatenate([self.pars, state[:size]])
        made, _ = evaluated((self.formulas, self.variables, event), function, numbers)
        return np.append(made[:size, 0, 0], 1.0)[: len(state)], made[size:]

    def happens(self, event: Any, state: np.ndarray, known: Any = None) -> tuple:
        """Return the state as it moves with an event, or with a time; and the change along each
        direction at which the event no longer happens.

        There the next extreme of its function comes to zero. `known`: the derivatives of its
        function, (directions,), where they are known better than from the state; for a time, minus
        its derivatives. `_ended` and `_impact` call it.
        """
        # turns: the derivatives of the pace along the directions; bend: the rate of the pace
        rates, ((_, by), (pace, turns), (bend, _)) = self.slopes(event, state)
        moved = state.copy()
        moved[:, 1] -= np.outer(rates, by if known is None else known) / pace[0]
        # the vertex of the parabola through the zero with this pace and bend: its height, then
        # this over the derivative of the height at a constant bend
        extreme = pace**2 / (2 * abs(bend))
        least = extreme / abs(by - pace / bend * turns)
        # a disc gives way where the function falls like a square root: it has no extreme there
        counts = (extreme > NOISE) & (abs(pace / bend) > BRIEF)
        return moved, np.where(counts, least, np.inf)


def nearest(function: Callable, *given: Any) -> tuple[Any, Any]:
    """Call a function; return its result, and how near its comparisons are to turning out
    otherwise: the inverse of the least change along the directions at which one does.

    Dual numbers append comparisons to `COMPARED`, which is set for this call alone.
    """
    compared = list[Any]()
    context = copy_context()
    context.run(COMPARED.set, compared)
    result = context.run(function, *given)
    near: Any = 0.0
    for one in compared:
        if type(one) is Dual:  # those of other types are along other lines
            near = np.fmax(np.divide(abs(one.first), abs(one.value)), near)
    return result, near


def evaluated(key: tuple, function: Callable, numbers: np.ndarray, follow: Any = None) -> tuple:
    """Call a function with derivatives, by a program of it if possible.

    The function takes milliseconds, and its program microseconds. Return its numbers as rows, and
    the least change along each direction at which a comparison turns out otherwise.

    Parameters
    ----------
    key
        Identifies the function, with all on which its operations depend but `numbers`.
    function
        function(duals) -> numbers.
    numbers
        The inputs, as rows of order 1.
    follow
        follow(place, columns) -> the results of a motion, of columns (2 n, directions) to such.
    """
    columns = numbers.reshape(-1, numbers.shape[2])

    def of_column(*column: Any) -> list:
        """Return how near comparisons are, then the results, of the numbers of one direction.

        Each number is before its derivative.
        """
        results, near = nearest(function, _duals(column))
        return [*_pairs([near, *results])]

    made = None
    # whatever it does that is no line of a program; the calls below raise its own errors again
    with suppress(Exception):
        made = repeated(key, of_column, columns, follow)
    if made is None:
        made = np.transpose([of_column(*column) for column in columns.T])
    rows = made.reshape(-1, 2, columns.shape[1]).astype(float)
    return rows[1:], 1 / rows[0, 0]


def _duals(pairs: Any) -> list[Dual]:
    """Return numbers each of which is before its derivative, as `_pairs` returns them."""
    return [*map(Dual, pairs[::2], pairs[1::2])]


def _pairs(numbers: Iterable) -> Iterator:
    """Return numbers, each before its derivative."""
    return chain.from_iterable(parts_of(one, 1) for one in numbers)


# --- the pass -------------------------------------------------------------------------------------


class DualProblems(Problems):
    """A run whose numbers have derivatives.

    `Problems` converts numbers to arrays and rounds them by the two methods that are replaced here.
    """

    def _wide(self, value: Any) -> Any:
        """Return the number as it is."""
        return value

    def _rounded(self, rows: Any) -> Any:
        """Return the numbers as they are."""
        return rows


class Note(NamedTuple):
    """How far numbers may change before a comparison or an exit differs: see `Pass.notes`."""

    time: float
    what: str
    least: np.ndarray  # relative change along each direction


class Pass:
    """Repeat a run with derivatives; `followed` makes it.

    Parameters
    ----------
    problem
        The run.
    wrt
        Dotted names of numbers.
    times
        Internal times of states, ascending, within the run.
    driver
        The `HybridDriver` of the run, at its end, with its `intervals`; None if it is smooth.
    ways
        Directions, (numbers, directions).
    order
        1, or 2 for second derivatives of a smooth run.

    Attributes
    ----------
    shifts
        The derivatives of the times at which the run starts, and at which phases end.
    rows
        The variables of the run at the times, in internal units, as rows (variables, ..., times);
        their last direction is time.
    between
        By phase: the times at which it began, and states in it.
    notes
        What could turn out otherwise.
    """

    @QUIET
    def __init__(
        self,
        problem: Problem,
        wrt: Sequence[str],
        times: np.ndarray,
        driver: Any,
        ways: np.ndarray,
        order: int = 1,
    ):
        """Follow the run with derivatives; `rows` then has the states.

        `_numbers_of` comes first: it sets the start, the bodies and scales that all else reads.
        """
        self.problem = problem
        self.times = times
        self.driver = driver
        self.directions = ways.shape[1]
        self.order = order
        self.motions = dict[Any, Motion]()  # by phase
        # by phase: numbers of the times at which it is, and its states there
        self.samples, self.between = defaultdict[Any, Any](list), defaultdict[Any, Any](list)
        self.shifts = {0.0: np.zeros(self.directions)}
        # mu is compared with 0, because `opening.assembled` takes another law without friction
        _, near = nearest(self._numbers_of, wrt, ways)
        least = 1 / np.broadcast_to(near, self.directions)
        self.notes = [Note(0.0, "the law of friction", least)]
        formulas = formulas_of(problem.system, problem.form.name, problem.law)
        # of hybrid runs too: `read` and `times_of` evaluate columns and events by it
        self.whole = Motion(formulas, problem.variables, self.first)
        if problem.system.is_hybrid:
            self._follow()
            self.rows = self._read_phases()
        else:
            self.rows = self.whole.in_time(self.whole.flow(times, self.start))[:-1]

    def _numbers_of(self, wrt: Sequence[str], ways: np.ndarray) -> None:
        """Set start, bodies and scales of the run, in internal units, with derivatives.

        Each direction, a column of `ways`, changes the numbers `wrt` relative to their sizes. The
        values of the plain run are kept bit by bit. It is called by `nearest`, because formulas of
        the start may compare numbers.
        """
        problem = self.problem
        numbers = dict[str, Any]()
        sizes = list[Any]()
        for name, way in zip(wrt, ways, strict=True):
            table, _, key = name.partition(".")
            value = float(problem.tables[table].get(key, 0.0))
            size = abs(value) or problem.unit(problem.rules[name].unit)
            numbers[name] = Dual(value, size * way, *[0 * way] * (self.order - 1))
            sizes.append(size)
        self.sizes = np.array(sizes)
        tops = DualProblems(problem, numbers, problem.orientation)
        scales = as_rows(tops.scales, self.order, self.directions)
        self.scales = Scales(*duals_of(scales[..., None]))

        def rows(numbers: Sequence, values: Sequence) -> np.ndarray:
            """Return numbers as rows, with the values that they have in the run."""
            made = as_rows(numbers, self.order, self.directions)
            made[:, 0] = np.array(values)[:, None]
            return made

        # the last row is the time
        self.start = rows([*tops.start, 0.0], [*problem.start(), 0.0])
        self.first = rows(leaves(tops.internal_body), leaves(problem.internal_body))
        if problem.system.is_hybrid:
            body, _ = assembled(problem.system, tops, lambda value: value)
            e_n = tops.contact.e_n if tops.contact else 0.0
            values = leaves(self.driver.world.body)
            self.known = rows([*leaves(body), e_n], [*values, plain(e_n)])
            self.given = refill((body, (e_n,)), iter(duals_of(self.known)))

    def _follow(self) -> None:
        """Repeat all phases and jumps of the plain run with derivatives.

        It fills `samples`, `between`, `shifts` and `notes`. If a jump leads elsewhere than in the
        plain run, it ends there, with a Note of change 0: no derivatives exist from then on.
        """
        body, _ = self.given
        jump = self.driver.first_jump
        state = self.start
        ended = -1.0  # before the start
        for interval in self.driver.intervals:
            now = state[-1, 0, 0]
            follows, least, lasts, state = self._jumped(jump, state)
            solver = interval.solver
            differs = follows != solver.at
            if differs or not jump.exit.smooth:
                what = f"what follows `{jump.exit.event}`"
                self.notes.append(Note(now, what, 0 * lasts if differs else least))
            if differs:
                break
            phase = solver.phase
            if phase not in self.motions:
                pars = as_rows(leaves(phase.parameters(body)), 1, self.directions)
                self.motions[phase] = Motion(solver.formulas, solver.variables, pars)
            # times in the jump before belong to this phase if the jump is brief: see BRIEF
            since = max(ended, interval.began - BRIEF)
            state = self._ended(interval, since, state, lasts)
            ended = interval.ended
            if jump := interval.jump:  # of phases that end at one time, the first decides
                self.shifts.setdefault(ended, state[-1, 1])
        for found in (self.samples, self.between):
            for phase, parts in found.items():
                found[phase] = [np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)]

    def _read_phases(self) -> np.ndarray:
        """Return `rows` of the samples in all phases; NaN at times in no phase.

        They are rows of the run, not states of phases, at fixed times.
        """
        variables = self.problem.variables
        # value and derivatives; `in_time` adds the time as a direction
        shape = len(variables.names), 2, self.directions + 1, len(self.times)
        rows = np.full(shape, np.nan)
        if self.times[0] == 0:  # a phase may begin later
            rows[:, :, :-1, 0] = self.start[:-1]
        for phase, (which, state) in self.samples.items():
            motion = self.motions[phase]
            q, carried = motion.variables.split(duals_of(motion.in_time(state)))
            read, _ = self.problem.system.read(phase, q, carried, motion.body)
            every = variables.join(read[: variables.moving], carried)
            rows[..., which] = as_rows(every, 1, self.directions + 1, len(which))
        return rows

    def _jumped(self, jump: Jump, state: np.ndarray) -> tuple:
        """Make a jump with derivatives.

        Return the index of the next phase (-1 if the run ends), the least change along each
        direction at which another one follows, the derivatives of the longest time that it lasts,
        and the state there, as rows, the time last.
        """
        driver = self.driver
        world = driver.world

        def jumped(numbers: list) -> list:
            """Make the jump with given numbers of the body, of restitution, and of the state.

            Return the index of the next phase, the longest time that it lasts, then the state in
            it, without which the run ends.
            """

            def piece(region: str, *given: Any) -> list:
                """Follow a piece of an impact, which is one line of a program."""
                place = [*driver.impacts.stages].index(region)

                def moved(*values: float) -> np.ndarray:
                    """Return the results in one column."""
                    return self._impact(place, np.array(values)[:, None])[:, 0]

                pairs = _pairs(leaves(given))
                program = getattr(numbers[0].value, "program", None)
                return _duals(program.call(place, moved, *pairs) if program else moved(*pairs))

            rest = iter(numbers)
            body, (e_n,) = refill(self.given, rest)
            state = [*rest]
            now = world.with_numbers(body, e_n, float(driver.end) - state[-1], piece)
            n, _, begun, _ = jump(driver, state, now)
            if n.ends:
                return [-1, n.lasts]
            return [[*driver.phases].index(n.phase), n.lasts, *begun, state[-1] + n.delay]

        key = jump, kinds(world.body)  # a program repeats one jump, for bodies of the same records
        numbers = np.concatenate([self.known, state])
        try:
            (follows, lasts, *begun), least = evaluated(key, jumped, numbers, self._impact)
        except InputError as error:
            raise InputError(
                f"{jump.where} must take numbers with derivatives: use operators and NumPy's "
                f"functions, not `math` or `float`, but {error}"
            ) from error
        return follows[0, 0], least, lasts[1], np.array(begun)

    def _ended(
        self, interval: PhaseInterval, since: float, state: np.ndarray, lasts: np.ndarray
    ) -> np.ndarray:
        """Return the state where a phase ends, of that where it begins.

        Rows after `since` are of this phase. `lasts` is that of `_jumped`: the derivatives of the
        longest time of the phase, by which an exit by the clock moves.
        """
        solver, done, end, last, jump = interval
        phase = solver.phase
        motion = self.motions[phase]
        start = state
        exit: Any = jump and jump.exit
        event = exit and next((one for one in phase.events if one.name == exit.event), None)
        sticks = exit and exit.event == STICK.name
        stops = [end - at for at in PROJECTED_AT if sticks and at < (end - done) / 2] + [end]
        for stop in stops if end > since else ():
            which = np.flatnonzero((self.times > since) & (self.times <= stop))
            count = PER_INTERVAL + int(PER_TIME * (stop - done))
            apart = np.linspace(done, stop, count + 2)[1:]  # `inside`, then the end
            # times in the brief jump before the phase get its first state
            after = motion.flow(np.append(self.times[which], apart).clip(done) - done, state)
            inside = after[..., len(which) : -1]
            self.samples[phase].append((which, after[..., : len(which)]))
            self.between[phase].append((np.full(count, interval.began), inside))
            state = after[..., -1].copy()
            since = done = stop
            if stop < end:  # at a fixed speed: see PROJECTED_AT
                state, _ = motion.happens(event, state)
        state[:, 0] = np.append(last, end)[:, None]
        if exit:
            # without an event the clock ends it, which `lasts` moves
            known = None if event else -lasts
            if event and end - interval.began < BRIEF_PHASE:
                # so brief a phase has PER_INTERVAL states inside, the middle one at half its time
                states = start, inside[..., PER_INTERVAL // 2], state
                three = np.array([motion.slopes(event, one)[1] for one in states])
                if abs(three[0, 0, 0, 0]) < NOISE:  # the phase begins on the zero by which it ends
                    known = (end - interval.began) * (SIMPSON @ three[:, 1, 1])
            state, least = motion.happens(event, state, known)
            if not exit.smooth:
                self.notes.append(Note(end, f"`{exit.event}`", least))
        self.between[phase].append((np.array([interval.began]), state[..., None]))
        return state

    def _impact(self, place: int, columns: np.ndarray) -> np.ndarray:
        """Integrate a piece of an impact with derivatives; see `ImpactMotions.piece`.

        It has the arguments and results of that method, in its order: a change of one is a change
        of both, and of `follow_motion` in loop.c. But `place` is the index of the region, `columns`
        has the arguments after the region, each before its derivative, (2 n, directions), and so
        have the results.
        """
        numbers = columns.astype(float).reshape(-1, 2, columns.shape[1])
        impacts = self.driver.impacts
        region = [*impacts.stages][place]
        driver = impacts.driver(region)
        formulas = formulas_of_impact(impacts.law, region, *impacts.pattern)
        variables = variables_of(formulas.form, False)
        size = len(variables.names)
        count = len(formulas.events)
        cuts = np.cumsum([2, count, count, driver.width])
        (end, most), *values = np.split(numbers[:, 0, 0], cuts)
        made = impacts.piece(region, end, most, *values)
        results = as_rows(made, 1, columns.shape[1])
        after = slice(3, 3 + size)  # the state follows status, steps and event
        *_, state, pars = np.split(numbers, cuts)
        motion = Motion(formulas, variables, pars)
        state = motion.flow(np.array([float(driver.reached()[0])]), state[:size])[..., 0]
        state[:, 0] = results[after, 0]
        if made[2] >= 0:  # the number of the event that ended it; -1: its clock did
            state, _ = motion.happens(formulas.events[made[2]], state)
        results[after] = state
        return results.reshape(-1, columns.shape[1])

    # --- what was found ---------------------------------------------------------------------------

    @QUIET
    def read(self) -> dict[str, Dual]:
        """Return the columns at all times, by name; their derivatives are (directions, times).

        Values are in internal units; `sensitivities` scales them.
        """
        problem = self.problem
        variables = problem.variables
        key = problem.system, variables, problem.law, self.order
        wait = "the derivatives of columns are being compiled"
        rows = np.ascontiguousarray(self.rows[:, :, :-1])
        shape = rows.shape[1:]
        pars = np.repeat(self.whole.pars.reshape(-1, shape[1]), shape[2], axis=1)
        inputs = rows.reshape(-1, pars.shape[1])
        values = dict[str, Any]()
        for formulas in (observed, orientation_of):
            if formulas is observed or (variables.orientation and variables.form.orientation):
                names, function = awaited_once(compile_observables, (formulas, *key), wait)
                columns = function(inputs, pars=pars[: function.nparams])
                values |= zip(names, duals_of(columns.reshape(-1, *shape)), strict=True)
        if AXES[0] in values:
            values |= zip(QUATERNION, _quaternion(outer(*axes_in(values))), strict=True)
        return values

    @QUIET
    def times_of(self, names: Any, times: np.ndarray) -> np.ndarray:
        """Return the derivatives of the times of events, (directions, events).

        `names` are those of the events, or one of all; times in `shifts` need none. A time is that
        of the start, of the end of a phase, or of the zero of an event function. It is NaN in a
        jump that takes time. The unit of time is a power of two, so times find their key exactly.
        """
        rows = self.rows[:, :2, :, np.searchsorted(self.times, times)]
        shifts = np.full((self.directions, len(times)), np.nan)
        for name, h in self.whole.functions(rows).items():
            happens = np.broadcast_to(names, len(times)) == name
            # the last derivative of `h` is its rate
            shifts[:, happens] = -(h.first[:-1] / h.first[-1])[:, happens]
        for k, time in enumerate(times):
            shifts[:, k] = self.shifts.get(time, shifts[:, k])
        return shifts

    @QUIET
    def margins(self) -> list[Note]:
        """Return all notes in order of time, with those of exits that nearly happened.

        These have the time at which their phase began: from there on it may end otherwise.
        """
        notes = list(self.notes)
        for phase, (began, state) in self.between.items():
            motion = self.motions[phase]
            exits = {one.event for one in phase.exits if not one.smooth}
            # the times of the samples move with the numbers, but not along a direction of time
            still = np.concatenate([state, 0 * state[:, :, :1]], axis=2)
            for name, h in motion.functions(still).items():
                if name not in exits:
                    continue
                size = np.abs(h.value)
                least = size / np.abs(h.first[:-1])
                for k in _lows(size, began):
                    # the function of the exit that happened is zero, which is no near miss
                    if size[k] > NOISE:
                        notes.append(Note(began[k], f"`{name}`", least[:, k]))
        return sorted(notes, key=operator.attrgetter("time"))


def followed(problem: Problem, wrt: Sequence[str], times: np.ndarray, *options: Any) -> Pass:
    """Return the `Pass` of a run to times [s], while signals are handled."""
    follow = partial(Pass, problem, wrt, times / problem.unit(SECOND), *options)
    return awaited(follow, "the variational equations are integrated")


def _quaternion(products: tuple) -> list[Dual]:
    """Return unit quaternions with their derivatives, of P = 4 q q^t.

    With a constant q0 near q, P q0 = 4 q (q . q0) is along q: divided by its length it is q, with
    the derivatives of q.
    """
    near = quaternion(plain(products))
    along = [sum(map(operator.mul, row, near)) for row in products]
    size = sqrt(sum(one * one for one in along))
    return [one / size for one in along]


def _lows(size: np.ndarray, began: np.ndarray) -> np.ndarray:
    """Return the indices of local minima of `size`, (k,), without those at the starts of phases.

    `began` has the time at which the phase of each sample began, (k,).
    """
    # the first sample of a phase never counts; the last one does if the size falls to it
    change = np.where(np.diff(began) == 0, np.diff(size), np.inf)
    falls = np.append(False, change <= 0)
    rises = np.append(change > 0, True)
    return np.flatnonzero(falls & rises)
