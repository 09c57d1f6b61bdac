"""Derivatives of a run through every change of its contact.

The plain run gives the phases that it goes through. They are followed once more: the flow of each
by its variational equations, one number in each lane; the start, times of events, jumps and columns
by numbers with derivatives, which the formulas take as they are. So where a phase ends moves with
the numbers, and no jump has derivatives of its own.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...errors import InputError
from ...mechanics.contact import impact_motion
from ...mechanics.contact.contact_phases import STICK
from ...mechanics.dual import COMPARED, Dual, parts_of, plain
from ...mechanics.form import CLOCK, Phase
from ...mechanics.operand import cos, leaves, refill, sin
from ...mechanics.units import SECOND, Scales
from ...mechanics.variables import Variables, variables_of
from ...problem import Problem
from ..driver import STEPS_PER_SLICE
from ..expressions import Formulas
from ..hybrid import QUIET, HybridDriver, Leg, Track, begin_in_first, completed
from ..impacts import formulas_of_impact
from ..integrator import awaited_once
from ..variational import compiled_flow


MOST_LANES = 8
PROJECTED_AT = 1e-2, 1e-5, 1e-9
"""Speeds before sliding stops at which derivatives are those at a fixed speed, not time.

beta' = Q/w is singular where w vanishes: the derivative at a fixed time is the difference of two
huge numbers there, and six digits would be lost.
"""


class Numbers(NamedTuple):
    """The numbers of a run, in its units, with derivatives by the relative changes of some."""

    directions: int
    scales: Scales
    first: Any  # the body
    body: Any  # the body as jumps take it
    rules: Any
    state: tuple  # the start
    sizes: np.ndarray  # [SI] what a relative change of 1 is


def numbers_of(problem: Problem, wrt: Sequence[str], driver: HybridDriver) -> Numbers:
    """Return the numbers of a run with derivatives; values are those of its driver."""
    system = problem.system
    given = {name: 0.0 for name in wrt if name.startswith("initial.")}
    for table, numbers in problem.tables.items():
        given |= {f"{table}.{name}": value for name, value in numbers.items()}
    sizes = np.array([abs(given[n]) or problem.unit(problem.rules[n].unit) for n in wrt])
    for name, size, one in zip(wrt, sizes, np.eye(len(wrt)), strict=True):
        given[name] = Dual(float(given[name]), size * one)
    tables = {
        t: {n.partition(".")[2]: v for n, v in given.items() if n.startswith(f"{t}.")}
        for t in ("parameters", "friction", "initial", "contact", "stem")
    }
    b = system.body_of(tables["parameters"], problem.friction._replace(**tables["friction"]))
    mass, length = system.scales(b)
    scales = Scales(mass, length * problem.form.length_unit, problem.unit(SECOND))

    def internal(value: Any, unit: Any) -> Any:
        return value / scales.of(unit)

    units = leaves(system.body_units(problem.law.units()))
    first = refill(b, map(internal, leaves(b), units))._replace(**system.folds(problem.form))
    body = first
    rules = problem.contact
    if rules is not None:
        rules = rules._replace(**tables["contact"], **tables["stem"])
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
        len(wrt),
        scales,
        valued(first, leaves(problem.internal_body)),
        valued(body, leaves(driver.world.body)),
        rules,
        valued(tuple(state), problem.start()),
        sizes,
    )


def valued(record: Any, values: Sequence) -> Any:
    """Return a record with other values, and its derivatives."""
    pairs = zip(leaves(record), values, strict=True)
    made = (
        Dual(float(value), one.first) if isinstance(one, Dual) else float(value)
        for one, value in pairs
    )
    return refill(record, made)


def joined(values: np.ndarray, moves: np.ndarray) -> list[Dual]:
    """Return numbers of values (n, ...) and derivatives (n, directions, ...)."""
    return [Dual(*pair) for pair in zip(values, moves, strict=True)]


def derivatives(numbers: Sequence, directions: int) -> np.ndarray:
    """Return the derivatives of numbers, (n, directions)."""
    return np.array([parts_of(one, 1)[1] + np.zeros(directions) for one in numbers])


# --- flows ----------------------------------------------------------------------------------------


def flow(
    formulas: Formulas, variables: Variables, state: Sequence, body: Any, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the values (n, times) and derivatives (n, directions, times) of a state that moves for
    these times, ascending.
    """
    moves = np.array([one.first for one in state])
    n, directions = moves.shape
    pars = leaves(body)
    lanes = 1 << min(directions - 1, MOST_LANES - 1).bit_length()
    key = formulas, variables, lanes, 2.0**-52
    ta = awaited_once(compiled_flow, key, "the variational equations are being compiled")
    both = np.empty((2 * len(pars), directions))
    both[::2] = np.array([plain(one) for one in pars], float)[:, None]
    both[1::2] = derivatives(pars, directions)
    found = np.empty((2 * n, directions, len(times)))
    for first in range(0, directions, lanes):
        some = np.arange(first, first + lanes).clip(max=directions - 1)
        ta.set_time(0.0)
        ta.state[:n] = np.array([one.value for one in state])[:, None]
        ta.state[n:] = moves[:, some]
        ta.pars[:] = both[: len(ta.pars), some]
        ta.propagate_until(times[0])
        found[:, some, 0] = ta.state
        if len(times) > 1:
            _, rows = ta.propagate_grid(np.repeat(times[:, None], lanes, axis=1))
            found[:, some] = np.moveaxis(rows, 0, -1)
    return found[:n, 0], found[n:]


# --- the pass -------------------------------------------------------------------------------------


class Pass:
    """Follows a run with derivatives.

    Parameters
    ----------
    problem
        The run.
    wrt
        Dotted names of numbers.
    end
        How far [internal units].
    """

    steps = False

    def __init__(self, problem: Problem, wrt: Sequence[str], end: float):
        self.problem = problem
        self.driver = driver = HybridDriver(problem)
        driver.legs = []
        self.end = end
        status = driver.ended
        while status is None and driver.clock[0] <= end:
            status = driver.advance(self, STEPS_PER_SLICE).status
        if not driver.legs or driver.legs[-1].jump is not None and status is None:
            driver.last_rows()
        self.numbers = numbers_of(problem, wrt, driver)
        self.bodies = dict[str, Any]()
        rules = self.numbers.rules
        struck = driver.world.struck
        if struck:
            struck = partial(struck, piece=self._piece)
        self.world = driver.world._replace(body=self.numbers.body, rules=rules, struck=struck)

    def wanted(self) -> np.ndarray:
        """Return the times of rows of the plain run: none."""
        return np.zeros(0)

    @QUIET
    def follow(self) -> None:
        """Follow the run."""
        driver = self.driver
        begin = driver.problem.system.begin or begin_in_first
        phase = completed(self.problem.system.phase, self.problem.variables)
        zero = np.zeros(self.numbers.directions)
        now: Any = Dual(0.0, zero)
        self.times = []
        n, state = self._jumped(phase, begin, self.numbers.state, now)
        for leg in driver.legs:
            began = now + n.delay
            assert n.phase == leg.track.name, (n.phase, leg.track.name)
            state, now = self._ended(leg, state, began, n.lasts)
            self.times.append(now)
            self.state, self.track = state, leg.track
            if leg.jump is None:
                break
            n, state = self._jumped(leg.track.phase, leg.jump.exit.jump, state, now)
            if n.ends:
                break

    def _body(self, phase: Phase) -> Any:
        """Return the body of the formulas of a phase."""
        return phase.parameters(self.world.body)

    def _jumped(self, phase: Phase, jump: Callable, state: Sequence, now: Dual) -> tuple:
        """Return what follows a phase that ended in a state, and the variables in which the next
        one begins.
        """
        q, carried = variables_of(phase.form).split(state)
        x = phase.leave(q, self._body(phase))
        if hasattr(x, "carried"):
            x = x._replace(carried=carried)
        n = jump(x, self.world._replace(phase=phase, left=float(self.driver.end) - now))
        if n.phase not in self.driver.phases:
            return n, None
        to = self.driver.track_of(n.phase)
        carried = getattr(n.x, "carried", carried)
        q = to.phase.enter(n.x, self._body(to.phase))
        zero = 0 * now
        return n, [zero + one for one in to.variables.join(q, carried)]

    def _rates(self, track: Track, values: Sequence) -> np.ndarray:
        """Return the rates of the variables of a phase."""
        return np.array(track.variables.rates(*track.variables.split(values), track.b), float)

    def _ended(self, leg: Leg, state: Sequence, began: Dual, lasts: Any) -> tuple[list, Dual]:
        """Return the state where a phase ends, and the time, of the state where it begins."""
        track = leg.track
        body = self._body(track.phase)
        directions = self.numbers.directions
        values = [one.value for one in state]
        moves = np.array([one.first for one in state])
        moves = moves - np.outer(self._rates(track, values), began.first)  # at a fixed time
        more = np.zeros(directions)
        done = 0.0
        span = leg.ended - leg.began
        last = np.array(leg.last)
        rates = self._rates(track, leg.last)
        event = leg.jump and leg.jump.exit.event
        if span > 0:
            stops = []
            if event == STICK.name:
                w = track.variables.names.index("w")
                stops = [span + speed / rates[w] for speed in PROJECTED_AT]
            for stop in (*(stop for stop in stops if stop > span / 2), span):
                state = joined(np.array(values), moves)
                found, after = flow(
                    track.formulas, track.variables, state, body, np.array([stop - done])
                )
                values, moves = found[:, 0], after[..., 0]
                done = stop
                if stop < span:
                    at = self._rates(track, values)
                    by = -moves[w] / at[w]
                    moves = moves + np.outer(at, by)
                    more = more + by
        if event is None:
            shift = 0 * more
        elif event == CLOCK:
            shift = (began + lasts).first - more
        else:
            ending = next(one for one in track.phase.events if one.name == event)
            h = self._value(ending, track, last, np.c_[moves, rates])
            shift = -h.first[:-1] / h.first[-1]
        return joined(last, moves + np.outer(rates, shift)), Dual(leg.ended, shift + more)

    def _value(self, event: Any, track: Track, values: np.ndarray, moves: np.ndarray) -> Dual:
        """Return an event function and its derivatives; the last one is that by time."""
        padded = (
            Dual(one.value, np.append(one.first, 0.0)) if isinstance(one, Dual) else one
            for one in leaves(self._body(track.phase))
        )
        b = refill(track.b, padded)
        q, _ = track.variables.split(joined(values, moves))
        return event.formula(track.phase.form.scalars(q, b), b)

    def _piece(self, region: str, end: Any, most: int, signs: tuple, zeros: tuple, *given: Any):
        """Follow a motion of an impact, as `ImpactMotions.piece`."""
        impacts = self.driver.impacts
        state, pars = given
        made = impacts.piece(region, end, most, signs, zeros, *map(plain, given))
        status, steps, k, *after = made
        lasts = float(impacts.driver(region).reached()[0])
        zero = np.zeros(self.numbers.directions)
        formulas = formulas_of_impact(impacts.law, region, *impacts.pattern)
        variables = variables_of(formulas.form, False)
        size = len(variables.names)
        first = [Dual(*parts_of(one, 1)) + Dual(0.0, zero) for one in state[:size]]
        _, moves = flow(formulas, variables, first, pars, np.array([lasts]))
        moves = moves[..., 0]
        values = np.array(after[:size])
        if k >= 0:
            body = formulas.body(iter([plain(one) for one in pars]))
            q, _ = variables.split(values)
            rates = np.array(formulas.form.rates(q, body), float)
            padded = (
                Dual(one.value, np.append(one.first, 0.0)) if isinstance(one, Dual) else one
                for one in pars
            )
            q, _ = variables.split(joined(values, np.c_[moves, rates]))
            h = formulas.events[int(k)].formula(q, formulas.body(padded))
            moves = moves - np.outer(rates, h.first[:-1] / h.first[-1])
        return [status, steps, k, *joined(values, moves), *after[size:]]
