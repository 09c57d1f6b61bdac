"""The variational equations: derivatives of motions along directions in the space of all numbers
that a user gives.

Everything is a function of one number `along`: the user's numbers p + along v, the state y + along
s + along^2 t/2. The equations of motion, the start, columns and event functions are differentiated
by it, as expressions: the formulas are those of the run, and one integrator serves every direction,
each in a SIMD lane. Units are those of the problem.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..mechanics.contact.body import Touch, height
from ..mechanics.moment import moment
from ..mechanics.operand import cos, leaves, refill, sin
from ..mechanics.system import Form, System
from ..mechanics.units import Scales
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import observed, orientation_of


ALONG, TIME = hy.make_vars("along", "elapsed")
ZERO = hy.expression(0.0)
COARSE = 1e-12  # tolerance of an integrator from which on rounding is no part of its error


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
        """The integrated variables."""
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
            self.friction._make(next(values) for _ in self.friction._fields),
        )
        return body, {
            **dict.fromkeys(self.flags, True),
            **dict(zip(self.initial, values, strict=True)),
        }

    @property
    def law(self) -> Any:
        """The friction law."""
        return self.friction


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
            for expected in (
                value,
                *rates[:-1],
            ):  # heyoka does not fold the 0 x that 0 makes of `along x`
                self._at_zero[point] = expected
                point = hy.diff(point, ALONG)

    def derivatives(self, values: Iterable, order: int) -> list[list[Any]]:
        """Expressions of the points and their derivatives by `along` where that is 0,
        [derivative][expression].
        """
        rows = [[ZERO + value for value in values]]
        for _ in range(order):
            rows.append([hy.diff(value, ALONG) for value in rows[-1]])
        return [hy.subs(hy.subs(row, self._at_zero), {ALONG: ZERO}) if row else [] for row in rows]


def _line(kind: Kind) -> tuple[Line, list[Any], Any]:
    """The state and the body as functions of `along`: the numbers of the body are the first
    parameters, their direction the following ones. Variables, then their derivatives `d_`, `d_d_`,
    are those of an integrator.
    """
    k, names = kind.body_numbers, kind.variables.names
    jets = [tuple(hy.expression("d_" * i + name) for i in range(kind.order + 1)) for name in names]
    line = Line([*jets, *((hy.par[i], hy.par[k + i]) for i in range(k))])
    body, _ = kind.numbers([*line.points[len(names) :], *(ZERO for _ in kind.initial)])
    return line, line.points[: len(names)], body


@lru_cache(maxsize=32)
def compiled_starts(kind: Kind) -> Any:
    """The function of numbers and their direction, (2 numbers, n), that gives the state at the
    start and its derivatives, ((order + 1) variables, n).
    """
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
    return compiled_once(hy.cfunc, outputs, vars=[*numbers, *ways])


@lru_cache(maxsize=16)
def compiled_motion(
    kind: Kind, lanes: int, compact: bool, tolerance: float, wanted: tuple[str, ...]
) -> Any:
    """heyoka's integrator of the state and its derivatives, in lanes, and the places of its
    variables among all.

    `wanted`: the variables that must be right; what these do not depend on is left out."""
    line, state, body = _line(kind)
    variables, names = kind.variables, kind.variables.names
    rates = line.derivatives(variables.rates(*variables.split(state), body), kind.order)
    keep = _closure(names, rates[0], wanted)
    pairs = [
        (hy.expression("d_" * k + names[i]), rates[k][i])
        for k in range(kind.order + 1)
        for i in keep
    ]
    places = [k * len(names) + i for k in range(kind.order + 1) for i in keep]
    careful = tolerance < COARSE  # sums of steps keep what rounding takes: a quarter of the cost
    zero = np.zeros((len(pairs), lanes))
    options = {"tol": tolerance, "high_accuracy": careful, "compact_mode": compact}
    integrator = compiled_once(hy.taylor_adaptive_batch, pairs, zero, **options)
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
    """What can be read of a state, by name: columns, the height of the centre of mass, axes of the
    body, event functions.
    """
    form = kind.form
    values = observed(kind.system, form, q, carried, body)
    if isinstance(body, Touch):
        values |= {"height": height(form.scalars(q, body).z, body)}
    if kind.orientation and form.orientation:
        axes = orientation_of(form, q, carried, body)
        names = [f"{axis}_{c}" for axis in ("first", "third") for c in "xyz"]
        values |= dict(zip([*names, "psi"], axes, strict=False))
    own = _own_units(kind, q, carried, body)
    state = moment(kind.system, form, *own)
    return values | {f"event {e.name}": e.formula(state, own[2]) for e in kind.system.events}


def _own_units(kind: Kind, q: Any, carried: Any, body: Any) -> tuple[Any, Any, Any]:
    """Return state, integrals and body in the units in which a run with these numbers would be
    integrated: events are looked for there, and one whose level is not zero moves with them. The
    unit of time is a power of two, and stays.
    """
    mass, length = kind.system.scales(body)
    scales = Scales(mass, length * kind.form.length_unit, 1.0)
    units = leaves(kind.system.body_units(kind.law.units()))
    of_state = kind.variables.units
    state, integrals = (
        type(record)(*(v / scales.of(of_state[name]) for name, v in record._asdict().items()))
        for record in (q, carried)
    )
    return (
        state,
        integrals,
        refill(body, iter([v / scales.of(u) for v, u in zip(leaves(body), units, strict=True)])),
    )


@lru_cache(maxsize=32)
def compiled_readings(
    kind: Kind, names: tuple[str, ...] | None, timed: tuple[str, ...]
) -> Readings:
    """Return readings of states with derivatives, f(inputs=((order + 1) variables, n),
    pars=(2 numbers of the body, n)): the values, their derivatives along the
    direction, and derivatives of the `timed` ones by time.

    `names`: None for all."""
    line, state, body = _line(kind)
    variables = kind.variables
    known = expressions_of(kind, *variables.split(state), body)
    names = tuple(known) if names is None else names
    outputs = [
        e for row in line.derivatives((known[name] for name in names), kind.order) for e in row
    ]
    rates = variables.rates(*variables.split(state), body)
    later = [y + TIME * rate for y, rate in zip(state, rates, strict=True)]
    moved = expressions_of(kind, *variables.split(later), body)
    now = dict(zip(later, state, strict=True))
    slopes = [
        hy.subs(hy.subs(hy.diff(ZERO + moved[name], TIME), now), {TIME: ZERO}) for name in timed
    ]
    outputs += line.derivatives(slopes, 0)[0]
    names_of = variables.names
    needs = set().union(*(hy.get_variables(e) for e in outputs)) & set(names_of)
    inputs = [hy.expression("d_" * k + name) for k in range(kind.order + 1) for name in names_of]
    function = compiled_once(hy.cfunc, outputs, vars=inputs, compact_mode=True)
    return Readings(names, timed, tuple(sorted(needs)), function)
