"""Compile the variational equations: derivatives of motions along directions of the input numbers.

The formulas are those of the run; their operands are expressions with derivatives. A number and its
direction are parameters of the compiled functions, so that one integrator serves every direction,
each in a SIMD lane. Units are those of the problem.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import count, starmap
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..mechanics.contact.body import Touch, by_scalars, height
from ..mechanics.contact.surroundings import by_table, dotted_numbers
from ..mechanics.dual import Dual, parts_of, plain
from ..mechanics.moment import moment
from ..mechanics.operand import Vector, cos, cross, dot, leaves, minus, plus, refill, sin, times
from ..mechanics.rotation import outer
from ..mechanics.system import System
from ..mechanics.units import Scales
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import AXES, Formulas, observed, orientation_of
from .opt_level import opt_level


ZERO = hy.expression(0.0)
EXACT = 1e-14  # tolerance of a step, of a phase that takes few
COARSE = 1e-12  # tolerance of an integrator from which on rounding is no part of its error
TURN = tuple(f"turn_{i}{j}" for i in range(4) for j in range(4))
"""Entries of 4 q q^t of the orientation q."""
CHIP = tuple(
    f"{name}_{c}" for name in ("omega", "gyroscope", "turning", "accelerometer") for c in "xyz"
)
"""Angular velocity in space; in body axes: angular velocity, its rate, and the specific force at
the centre of mass.
"""


class Kind(NamedTuple):
    """The key of compiled functions with derivatives.

    Parameters
    ----------
    system, variables, friction
        The equations of motion; friction is the type of the record of the law.
    names
        Dotted names of the user's numbers.
    flags
        Dotted names of the initial data that are set, and are no numbers.
    order
        0, 1 or 2: the highest derivative; 0 for motions alone.
    """

    system: System
    variables: Variables
    friction: Any
    names: tuple[str, ...]
    flags: tuple[str, ...]
    order: int

    def numbers(self) -> tuple[Any, dict[str, Any]]:
        """Return the body and the initial data as symbols with derivatives.

        Second derivatives of numbers are zero.
        """
        n = len(self.names)
        tables: dict[str, dict[str, Any]] = {"parameters": {}, "friction": {}, "initial": {}}
        tables |= {name: {} for name in by_table(self.system.surroundings)}
        parts = ([hy.par[i], hy.par[n + i], ZERO][: self.order + 1] for i in range(n))
        values = zip(self.names, starmap(number, parts), strict=True)
        for name, value in (dict(values) | dict.fromkeys(self.flags, True)).items():
            table, _, key = name.partition(".")
            tables[table][key] = value
        friction = self.friction(**tables["friction"])
        given = tables["parameters"] | dotted_numbers(tables)
        return self.system.body_of(given, friction), tables["initial"]


def number(*parts: Any) -> Any:
    """Return a number with its derivatives, if it has any."""
    return Dual(*parts) if len(parts) > 1 else parts[0]


def symbols(names: Iterable[str], order: int) -> list[Any]:
    """Return symbols with their derivatives."""
    return [number(*(hy.expression("d_" * k + name) for k in range(order + 1))) for name in names]


def by_order(values: Iterable, order: int) -> list[Any]:
    """Return values, then their first derivatives, then their second ones."""
    parts = [[ZERO + part for part in parts_of(value, order)] for value in values]
    return [one for row in zip(*parts, strict=True) for one in row]


@lru_cache(maxsize=16)
def compiled_motion(kind: Kind, lanes: int, tolerance: float) -> tuple[Any, Any]:
    """Return compiled functions of the start and of the motion, with derivatives.

    Returns
    -------
    starts
        The function of the parameters that gives them at the start, ((order + 1) variables, n).
    integrator
        heyoka's integrator of them, in lanes.
    """
    variables = kind.variables
    body, data = kind.numbers()
    theta = ZERO + data.get("theta", 0.0)
    s = sin(theta)
    z = cos(theta)
    angles = kind.system.start(data, s, z, body)
    start = variables.join(*variables.start(data, angles, s, z, body))
    starts = compiled_once(hy.cfunc, by_order(start, kind.order), vars=[])
    careful = tolerance < COARSE  # compensated sums of steps: a quarter of the cost
    return starts, _integrator(variables, body, kind.order, lanes, tolerance, careful)


@lru_cache(maxsize=128)
def compiled_flow(formulas: Formulas, variables: Variables, lanes: int) -> Any:
    """Return heyoka's integrator of formulas with derivatives along one direction for each lane.

    Its parameters are the numbers of the body, each before its derivative. It is for short phases,
    with steps that are not summed in double length. LLVM compiles it at level 1 at most: in little
    more than half the time of level 3, and the code is as fast.
    """
    body = formulas.body(Dual(hy.par[2 * i], hy.par[2 * i + 1]) for i in count())
    level = min(opt_level(), 1)
    return _integrator(variables, body, 1, lanes, EXACT, False, opt_level=level)


def _integrator(
    variables: Variables,
    body: Any,
    order: int,
    lanes: int,
    tolerance: float,
    careful: bool,
    **options: Any,
) -> Any:
    """Return heyoka's integrator of the variables of a body with derivatives."""
    state = symbols(variables.names, order)
    rates = variables.rates(*variables.split(state), body)
    equations = list(zip(by_order(state, order), by_order(rates, order), strict=True))
    options |= {"tol": tolerance, "high_accuracy": careful, "compact_mode": True}
    zero = np.zeros((len(equations), lanes))
    return compiled_once(hy.taylor_adaptive_batch, equations, zero, **options)


def expressions_of(
    system: System, variables: Variables, state: Sequence[Any], body: Any
) -> dict[str, Any]:
    """Return columns, the height of the centre of mass and body axes, as functions of the state."""
    form = variables.form
    q, carried = variables.split(state)
    values = observed(system, form, q, carried, body)
    scalars = form.scalars(q, body)
    if isinstance(body, Touch):
        values |= {"height": height(scalars.z, by_scalars(scalars, body))}
    elif hasattr(scalars, "height"):
        values |= {"height": scalars.height}
    if variables.orientation and form.orientation:
        values |= orientation_of(system, form, q, carried, body)
        first, third = (Vector(*(values[name] for name in axis)) for axis in (AXES[:3], AXES[3:]))
        values |= zip(TURN, leaves(outer(first, third)), strict=True)
    return values


def with_events(kind: Kind, state: Sequence[Any], body: Any) -> dict[str, Any]:
    """Return functions of the state by name, and event functions."""
    own_state, own_body = _own_units(kind, state, body)
    now = moment(kind.variables.form, *kind.variables.split(own_state), own_body)
    values = expressions_of(kind.system, kind.variables, state, body)
    return values | {f"event {e.name}": e.formula(now, own_body) for e in kind.system.events}


def _own_units(kind: Kind, state: Sequence[Any], body: Any) -> tuple[list[Any], Any]:
    """Return state and body in the units in which a run with these numbers would be integrated.

    Events are found in these units, and one whose level is not zero moves with them. The unit of
    time is a power of two, which does not change.
    """
    mass, length = kind.system.scales(body)
    scales = Scales(mass, length * kind.variables.form.length_unit, 1.0)
    of_body = leaves(kind.system.body_units(kind.friction.units()))
    of_state = kind.variables.units.values()
    body = refill(body, (v / scales.of(u) for v, u in zip(leaves(body), of_body, strict=True)))
    return [v / scales.of(u) for v, u in zip(state, of_state, strict=True)], body


@lru_cache(maxsize=32)
def compiled_readings(kind: Kind, names: tuple[str, ...] | None) -> tuple[tuple[str, ...], Any]:
    """Return the names of readings, and the compiled function of states with derivatives,
    f(inputs=((order + 1) variables, n), pars=(the parameters, n)): their values, their derivatives
    along the direction, and their derivatives by time.

    `names`: None for all.
    """
    variables = kind.variables
    state = symbols(variables.names, kind.order)
    body, _ = kind.numbers()
    known = with_events(kind, state, body)
    bare = plain(tuple(state)), plain(body)
    by_time = with_events(kind, in_motion(variables, *bare, 1), bare[1])
    if names and not set(CHIP).isdisjoint(names):
        known |= _in_body_axes(kind, state, body, 2)
        by_time |= _in_body_axes(kind, *bare, 3)
    names = tuple(known) if names is None else names
    values = (known[name] for name in names)
    outputs = by_order(
        (one.value if isinstance(one, Moving) else one for one in values), kind.order
    )
    outputs += [ZERO + parts_of(by_time[name], 1)[1] for name in names]
    inputs = by_order(state, kind.order)
    return names, compiled_once(hy.cfunc, outputs, vars=inputs, compact_mode=True)


class Moving(Dual):
    """A number with its derivatives by time."""

    __slots__ = ()
    level = 1

    @property
    def rate(self) -> Any:
        """Return the time derivative."""
        return Moving(*self.parts[1:])


def in_motion(variables: Variables, state: Sequence[Any], body: Any, order: int) -> list[Moving]:
    """Return variables with their derivatives by time, up to an order."""
    moving = [Moving(one) for one in state]
    for _ in range(order):
        rates = variables.rates(*variables.split(moving), body)
        moving = [
            Moving(one, *(rate.parts if isinstance(rate, Moving) else (rate,)))
            for one, rate in zip(state, rates, strict=True)
        ]
    return moving


def _in_body_axes(kind: Kind, state: Sequence[Any], body: Any, order: int) -> dict[str, Any]:
    """Return the functions CHIP of a state, with derivatives by time.

    The specific force is the acceleration of the centre of mass less that of gravity. Its first
    `order` - 2 derivatives are right.
    """
    moving = in_motion(kind.variables, state, body, order)
    known = expressions_of(kind.system, kind.variables, moving, body)
    first, third = (Vector(*(known[name] for name in axis)) for axis in (AXES[:3], AXES[3:]))
    axes = first, cross(third, first), third
    moves = [_rates(axis) for axis in axes]
    own = Vector(*(dot(moves[i - 2], axes[i - 1]) for i in range(3)))
    omega = plus(cross(third, moves[2]), times(own.z, third))
    if "x" in known:
        place = Vector(known["x"], known.get("y", Moving(0.0, 0.0, 0.0, 0.0)), known["height"])
    else:  # on a fixed tip
        place = times(-body.c, third)
    x, y = (getattr(body, "around", ()) and body.around.slope) or (0.0, 0.0)
    force = minus(_rates(_rates(place)), Vector(x, y, -body.g))
    values = *omega, *own, *_rates(own), *(dot(axis, force) for axis in axes)
    return dict(zip(CHIP, values, strict=True))


def _rates(vector: Vector) -> Vector:
    return Vector(*(one.rate for one in vector))
