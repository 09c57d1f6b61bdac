"""How a motion changes with the numbers that a user gives: derivatives along directions in the space of all of them.

Everything is a function of one number `along`: the user's numbers p + along v, the state y + along s + along^2 t/2.
The equations of motion, the start, columns and event functions are differentiated by it, as expressions: the formulas
are those of the run, and one integrator serves every direction, each in a SIMD lane. Units are those of the problem.
"""

import threading
from collections.abc import Iterable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..mechanics.contact.body import Body, height
from ..mechanics.friction import LAWS, Law
from ..mechanics.operand import cos, leaves, refill, sin
from ..mechanics.system import Form, System
from ..mechanics.units import Scales
from ..mechanics.variables import Variables
from .expressions import observed, orientation_of


MOST_LANES = 4
SOON = 3e4  # internal time in which all lanes together do not repay the 10 s that straight code takes to compile
ALONG, TIME = hy.make_vars("along", "elapsed")
ZERO = hy.expression(0.0)
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state


class Kind(NamedTuple):
    """What tangents are compiled for.

    Parameters
    ----------
    system, form_name, friction
        What moves; friction is the type of the record of the law.
    orientation
        Whether the orientation of the body is integrated too.
    initial
        Names of the initial numbers among the user's.
    flags
        Names of the initial data that are set, and are no numbers.
    order
        0, 1 or 2: the highest derivative; 0 for motions alone.
    """

    system: System
    form_name: str
    friction: Any
    orientation: bool
    initial: tuple[str, ...]
    flags: tuple[str, ...]
    order: int

    @property
    def form(self) -> Form:
        """The form that is integrated."""
        return self.system.forms[self.form_name]

    @property
    def variables(self) -> Variables:
        """What is integrated."""
        return Variables(self.form, self.orientation)

    @property
    def body_numbers(self) -> int:
        """How many of the user's numbers are of the body and the law: they come first."""
        return len(self.system.parameters) + len(self.friction._fields)

    def numbers(self, values: Iterable) -> tuple[Any, dict[str, Any]]:
        """The body and the initial data of the user's numbers, in order."""
        values = iter(values)
        body = self.system.body_of(
            {name: next(values) for name in self.system.parameters},
            self.friction(*(next(values) for _ in self.friction._fields)),
        )
        return body, {**dict.fromkeys(self.flags, True), **dict(zip(self.initial, values, strict=True))}

    @property
    def law(self) -> Law:
        """The friction law."""
        laws = {**LAWS, **self.system.laws}.values()
        return next(law for law in laws if law.record is self.friction)


class Line:
    """Variables and numbers as functions of `along`: what stands for each, and what that is at 0.

    Parameters
    ----------
    jets
        Of each: its value and its derivatives at 0, expressions.
    """

    def __init__(self, jets: Iterable[tuple[Any, ...]]):
        self.points: list[Any] = []
        self._at_zero: dict[Any, Any] = {}
        for value, *rates in jets:
            point = value
            for rate, factor in zip(rates, (ALONG, 0.5 * ALONG * ALONG), strict=False):
                point = point + factor * rate
            self.points.append(point)
            for expected in (value, *rates[:-1]):  # heyoka does not fold the 0 x that 0 makes of `along x`
                self._at_zero[point] = expected
                point = hy.diff(point, ALONG)

    def derivatives(self, values: Iterable, order: int) -> list[list[Any]]:
        """Expressions of the points and their derivatives by `along` where that is 0, [derivative][expression]."""
        rows = [[ZERO + value for value in values]]
        for _ in range(order):
            rows.append([hy.diff(value, ALONG) for value in rows[-1]])
        return [hy.subs(hy.subs(row, self._at_zero), {ALONG: ZERO}) if row else [] for row in rows]


def _line(kind: Kind) -> tuple[Line, list[Any], Any]:
    """The state and the body as functions of `along`: the numbers of the body are the first parameters, their direction
    the following ones. Variables, then their derivatives `d_`, `d_d_`, are those of an integrator."""
    k, names = kind.body_numbers, kind.variables.names
    jets = [tuple(hy.expression("d_" * i + name) for i in range(kind.order + 1)) for name in names]
    line = Line([*jets, *((hy.par[i], hy.par[k + i]) for i in range(k))])
    body, _ = kind.numbers([*line.points[len(names) :], *(ZERO for _ in kind.initial)])
    return line, line.points[: len(names)], body


@lru_cache(maxsize=32)
def compiled_starts(kind: Kind) -> Any:
    """The function of numbers and their direction, (2 numbers, n), that gives the state at the start and its
    derivatives, ((order + 1) variables, n)."""
    size = kind.body_numbers + len(kind.initial)
    numbers = hy.make_vars(*(f"p{i}" for i in range(size)))
    ways = hy.make_vars(*(f"v{i}" for i in range(size)))
    numbers, ways = ([v] if size == 1 else list(v) for v in (numbers, ways))
    line = Line(zip(numbers, ways, strict=True))
    body, data = kind.numbers(line.points)
    theta = ZERO + data.get("theta", 0.0)
    s, z = sin(theta), cos(theta)
    angles = kind.system.start(data, s, z, body)
    values = kind.variables.join(*kind.variables.start(data, angles, s, z, body))
    outputs = [e for row in line.derivatives(values, kind.order) for e in row]
    return hy.cfunc(outputs, vars=[*numbers, *ways])


@lru_cache(maxsize=16)
def compiled_motion(kind: Kind, lanes: int, compact: bool, tolerance: float, wanted: tuple[str, ...]) -> Any:
    """heyoka's integrator of the state and its derivatives, in lanes, and the places of its variables among all.

    `wanted`: the variables that must be right; what these do not depend on is left out."""
    line, state, body = _line(kind)
    variables, names = kind.variables, kind.variables.names
    rates = line.derivatives(variables.rates(*variables.split(state), body), kind.order)
    keep = _closure(names, rates[0], wanted)
    pairs = [(hy.expression("d_" * k + names[i]), rates[k][i]) for k in range(kind.order + 1) for i in keep]
    places = [k * len(names) + i for k in range(kind.order + 1) for i in keep]
    integrator = hy.taylor_adaptive_batch(
        pairs, np.zeros((len(pairs), lanes)), tol=tolerance, high_accuracy=True, compact_mode=compact
    )
    return integrator, np.array(places)


def _closure(names: tuple[str, ...], rates: list[Any], wanted: Iterable[str]) -> list[int]:
    """The variables that the wanted ones depend on, in order."""
    needs = {name: set(hy.get_variables(rate)) for name, rate in zip(names, rates, strict=True)}
    known: set[str] = set()
    new = set(wanted)
    while new:
        known |= new
        new = set().union(*(needs[name] for name in new)) - known
    return [i for i, name in enumerate(names) if name in known]


class Readings(NamedTuple):
    """A compiled function of states with derivatives: names, what each needs, the function."""

    names: tuple[str, ...]
    timed: tuple[str, ...]  # those whose derivative by time is given too
    needs: tuple[str, ...]  # variables
    function: Any


def expressions_of(kind: Kind, q: Any, carried: Any, body: Any) -> dict[str, Any]:
    """What can be read of a state, by name: columns, the height of the centre of mass, axes of the body, event
    functions."""
    form = kind.form
    values = observed(kind.system, form, q, carried, body)
    if isinstance(body, Body):
        values |= {"height": height(form.scalars(q, body).z, body)}
    if kind.orientation and form.orientation:
        axes = orientation_of(form, q, carried, body)
        names = [f"{axis}_{c}" for axis in ("first", "third") for c in "xyz"]
        values |= dict(zip([*names, "psi"], axes, strict=False))
    scalars = form.scalars(*_own_units(kind, q, body))
    own = _own_units(kind, q, body)[1]
    return values | {f"event {e.name}": e.formula(scalars, own) for e in kind.system.events}


def _own_units(kind: Kind, q: Any, body: Any) -> tuple[Any, Any]:
    """State and body in the units in which a run with these numbers would be integrated: events are looked for there,
    and one whose level is not zero moves with them. The unit of time is a power of two, and stays."""
    mass, length = kind.system.scales(body)
    scales = Scales(mass, length * kind.form.length_unit, 1.0)
    units = leaves(kind.system.body_units(kind.law.units()))
    state = type(q)(*(v / scales.of(unit) for v, unit in zip(q, kind.form.units, strict=True)))
    return state, refill(body, iter([v / scales.of(u) for v, u in zip(leaves(body), units, strict=True)]))


@lru_cache(maxsize=32)
def compiled_readings(kind: Kind, names: tuple[str, ...] | None, timed: tuple[str, ...]) -> Readings:
    """What is read of states with derivatives, f(inputs=((order + 1) variables, n), pars=(2 numbers of the body, n)):
    the values, their derivatives along the direction, and derivatives of the `timed` ones by time.

    `names`: None for all."""
    line, state, body = _line(kind)
    variables = kind.variables
    known = expressions_of(kind, *variables.split(state), body)
    names = tuple(known) if names is None else names
    outputs = [e for row in line.derivatives((known[name] for name in names), kind.order) for e in row]
    rates = variables.rates(*variables.split(state), body)
    later = [y + TIME * rate for y, rate in zip(state, rates, strict=True)]
    moved = expressions_of(kind, *variables.split(later), body)
    now = dict(zip(later, state, strict=True))
    slopes = [hy.subs(hy.subs(hy.diff(ZERO + moved[name], TIME), now), {TIME: ZERO}) for name in timed]
    outputs += line.derivatives(slopes, 0)[0]
    names_of = variables.names
    needs = set().union(*(hy.get_variables(e) for e in outputs)) & set(names_of)
    inputs = [hy.expression("d_" * k + name) for k in range(kind.order + 1) for name in names_of]
    return Readings(names, timed, tuple(sorted(needs)), hy.cfunc(outputs, vars=inputs, compact_mode=True))


class Tangents:
    """Motions with their derivatives along directions.

    Parameters
    ----------
    kind
        What moves.
    tolerance
        Of the integrator; 0 is the rounding unit.
    most
        Steps per internal unit of time beyond which a motion counts as one that cannot be integrated; 0: any number.
    uses
        How often motions are asked for, about.
    longest
        Internal time of the longest of them; 0: each is as long as the others.
    """

    def __init__(self, kind: Kind, tolerance: float = 0.0, most: float = 0.0, *, uses: int = 1, longest: float = 0.0):
        self.kind, self.tolerance, self.most, self.uses, self.longest = kind, tolerance, most, uses, longest
        self._known: dict[Any, Any] = {}

    def states(
        self, numbers: np.ndarray, ways: np.ndarray, times: np.ndarray, needs: tuple[str, ...] | None = None
    ) -> np.ndarray:
        """States with derivatives at given times.

        Parameters
        ----------
        numbers, ways
            The user's numbers in internal units, and the direction: (numbers, lanes) each.
        times
            Internal, (rows,) or (rows, lanes), ascending; the start is at 0.
        needs
            Variables that must be right; None: all.

        Returns
        -------
        ndarray
            (rows, order + 1, variables, lanes); NaN from where a motion cannot be integrated further.
        """
        kind, total = self.kind, numbers.shape[1]
        names = kind.variables.names
        wanted = names if needs is None else needs
        lanes = 1 << min(total - 1, MOST_LANES - 1).bit_length()
        times = np.broadcast_to(times[:, None] if times.ndim == 1 else times, (len(times), total))
        compact = float(np.abs(times).max(initial=self.longest)) * total * self.uses < SOON
        starts, motion = self._compiled(lanes, compact, tuple(wanted))
        begin = starts(np.concatenate([numbers, ways]))
        k = kind.body_numbers
        pars = np.concatenate([numbers[:k], ways[:k]])
        rows = np.zeros((len(times), (kind.order + 1) * len(names), total))

        def fill() -> None:
            for first in range(0, total, lanes):
                block = np.minimum(np.arange(first, first + lanes), total - 1)
                with _one_at_a_time:
                    part = self._block(motion, begin[:, block], pars[:, block], times[:, block])
                count = min(lanes, total - first)
                rows[:, motion[1], first : first + count] = part[:, :, :count]

        awaited(fill, "the variational equations are integrated")
        return rows.reshape(len(times), kind.order + 1, len(names), total)

    def _compiled(self, lanes: int, compact: bool, wanted: tuple[str, ...]) -> Any:
        """The compiled start and motion."""
        key = (lanes, compact, wanted)
        if key not in self._known:  # a look into the caches of the module compares whole systems
            self._known[key] = (
                awaited(lambda: compiled_starts(self.kind), "the start is being compiled"),
                awaited(
                    lambda: compiled_motion(self.kind, lanes, compact, self.tolerance, wanted),
                    "the variational equations are being compiled",
                ),
            )
        return self._known[key]

    def _block(self, motion: Any, begin: np.ndarray, pars: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Rows of the lanes of one batch. A lane that breaks down ends all of them: then each is followed alone."""
        together = _followed(motion, begin, pars, times, self.most)
        lanes = times.shape[1]
        if lanes > 1 and not self.most and np.isnan(together).any():
            for lane in range(lanes):
                same = np.full(lanes, lane)
                alone = _followed(motion, begin[:, same], pars[:, same], times[:, same], self.most)
                together[:, :, lane] = alone[:, :, lane]
        return together

    def read(
        self,
        numbers: np.ndarray,
        ways: np.ndarray,
        states: np.ndarray,
        names: tuple[str, ...] | None,
        timed: tuple[str, ...],
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Columns of states with derivatives, in internal units.

        Returns
        -------
        columns
            name -> (order + 1, rows, lanes): values and derivatives along the direction.
        rates
            name -> (rows, lanes), by internal time, of the `timed` ones.
        """
        readings = self._readings(names, timed)
        rows, orders, variables, lanes = states.shape
        k, function = self.kind.body_numbers, readings.function
        inputs = states.transpose(1, 2, 0, 3).reshape(orders * variables, rows * lanes)
        pars = np.tile(np.concatenate([numbers[:k], ways[:k]]), (1, rows))[: function.nparams]
        outputs = function(np.ascontiguousarray(inputs), pars=pars).reshape(-1, rows, lanes)
        n = len(readings.names)
        columns = {name: outputs[i : orders * n : n] for i, name in enumerate(readings.names)}
        return columns, dict(zip(timed, outputs[orders * n :], strict=True))

    def _readings(self, names: tuple[str, ...] | None, timed: tuple[str, ...]) -> Readings:
        if (names, timed) not in self._known:
            make = partial(compiled_readings, self.kind, names, timed)
            self._known[names, timed] = awaited(make, "the derivatives of columns are being compiled")
        return self._known[names, timed]

    def needs(self, names: tuple[str, ...] | None, timed: tuple[str, ...]) -> tuple[str, ...]:
        """The variables that columns read."""
        return self._readings(names, timed).needs


def _followed(
    motion: tuple[Any, np.ndarray], begin: np.ndarray, pars: np.ndarray, times: np.ndarray, most: float
) -> np.ndarray:
    """Rows (rows, variables, lanes) of one batch; NaN where it ended early."""
    integrator, places = motion
    integrator.set_time(0.0)
    integrator.state[:] = begin[places]
    integrator.pars[:] = pars[: len(integrator.pars)]
    limit = {"max_steps": int(most * float(np.abs(times).max()) + 100)} if most else {}
    if np.any(times[0] != 0.0):
        integrator.propagate_until(np.ascontiguousarray(times[0]), **limit)
        if any(outcome != hy.taylor_outcome.time_limit for outcome, *_ in integrator.propagate_res):
            return np.full((len(times), len(places), times.shape[1]), np.nan)
    _, rows = integrator.propagate_grid(np.ascontiguousarray(times), **limit)
    return np.array(rows)
