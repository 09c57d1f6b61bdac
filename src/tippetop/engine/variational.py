"""The variational equations: derivatives of motions along directions in the space of all numbers
that a user gives.

The start, the equations of motion, columns and event functions are differentiated as expressions:
the formulas are those of the run. A number and its direction are parameters of the compiled
functions, so that one integrator serves every direction, each in a SIMD lane. Units are those of
the problem.
"""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..mechanics.contact.body import Touch, by_scalars, height
from ..mechanics.contact.surroundings import by_table, dotted_numbers
from ..mechanics.moment import moment
from ..mechanics.operand import Vector, cos, leaves, refill, sin
from ..mechanics.rotation import outer
from ..mechanics.system import System
from ..mechanics.units import Scales
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import AXES, observed, orientation_of


ALONG = hy.make_vars("along")
"""The parameter of a line; it is zero where a derivative is taken."""
ZERO = hy.expression(0.0)
COARSE = 1e-12  # tolerance of an integrator from which on rounding is no part of its error
TURN = tuple(f"turn_{i}{j}" for i in range(4) for j in range(4))
"""Entries of 4 q q^t of the orientation q."""


class Kind(NamedTuple):
    """Key of compiled tangents.

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

    @property
    def symbols(self) -> list[Any]:
        """The variables as symbols, then their first derivatives, then their second ones."""
        names = self.variables.names
        orders = range(self.order + 1)
        return [hy.expression("d_" * k + name) for k in orders for name in names]

    def numbers(self) -> tuple[Any, dict[str, Any]]:
        """Return the body and the initial data of the user's numbers, as symbols."""
        tables: dict[str, dict[str, Any]] = {"parameters": {}, "friction": {}, "initial": {}}
        tables |= {name: {} for name in by_table(self.system.surroundings)}
        values = {name: hy.par[i] for i, name in enumerate(self.names)}
        for name, value in (values | dict.fromkeys(self.flags, True)).items():
            table, _, key = name.partition(".")
            tables[table][key] = value
        friction = self.friction(**tables["friction"])
        given = tables["parameters"] | dotted_numbers(tables)
        return self.system.body_of(given, friction), tables["initial"]

    def motion(self) -> tuple[list[Any], Any, list[Any]]:
        """Return the variables, the body and the rates of the variables, as expressions."""
        variables, (body, _) = self.variables, self.numbers()
        state = self.symbols[: len(variables.names)]
        return state, body, variables.rates(*variables.split(state), body)

    def with_derivatives(self, values: Iterable) -> list[Any]:
        """Return expressions, their first derivatives along a direction, then their second ones."""
        n = len(self.names)
        symbols = self.symbols
        moves = {hy.par[i]: hy.par[n + i] for i in range(n)}
        moves |= zip(symbols, symbols[len(self.variables.names) :], strict=False)
        rows = [[ZERO + value for value in values]]
        for _ in range(self.order):
            rows.append(_derivatives(rows[-1], moves))
        return [value for row in rows for value in row]


def _derivatives(values: list[Any], moves: Mapping[Any, Any]) -> list[Any]:
    """Return the derivatives of expressions along a line, by the derivative of each symbol."""
    ahead = {symbol: symbol + ALONG * move for symbol, move in moves.items()}
    here = {moved: symbol for symbol, moved in ahead.items()}
    return hy.subs([hy.diff(value, ALONG) for value in hy.subs(values, ahead)], here)


@lru_cache(maxsize=16)
def compiled_motion(kind: Kind, lanes: int, tolerance: float) -> tuple[Any, Any]:
    """Return the state and its derivatives in motion.

    Returns
    -------
    starts
        The function of the parameters that gives them at the start, ((order + 1) variables, n).
    integrator
        heyoka's integrator of them, in lanes.
    """
    body, data = kind.numbers()
    theta = ZERO + data.get("theta", 0.0)
    s = sin(theta)
    z = cos(theta)
    angles = kind.system.start(data, s, z, body)
    start = kind.variables.join(*kind.variables.start(data, angles, s, z, body))
    starts = compiled_once(hy.cfunc, kind.with_derivatives(start), vars=[])
    _, _, rates = kind.motion()
    equations = list(zip(kind.symbols, kind.with_derivatives(rates), strict=True))
    careful = tolerance < COARSE  # compensated sums of steps: a quarter of the cost
    options = {"tol": tolerance, "high_accuracy": careful, "compact_mode": True}
    zero = np.zeros((len(equations), lanes))
    return starts, compiled_once(hy.taylor_adaptive_batch, equations, zero, **options)


def expressions_of(kind: Kind, state: list[Any], body: Any) -> dict[str, Any]:
    """Return functions of the state by name: columns, the height of the centre of mass, axes of the
    body, event functions.
    """
    form, (q, carried) = kind.variables.form, kind.variables.split(state)
    values = observed(kind.system, form, q, carried, body)
    if isinstance(body, Touch):
        scalars = form.scalars(q, body)
        values |= {"height": height(scalars.z, by_scalars(scalars, body))}
    if kind.variables.orientation and form.orientation:
        values |= orientation_of(kind.system, form, q, carried, body)
        first, third = (Vector(*(values[name] for name in axis)) for axis in (AXES[:3], AXES[3:]))
        values |= zip(TURN, leaves(outer(first, third)), strict=True)
    own_state, own_body = _own_units(kind, state, body)
    now = moment(form, *kind.variables.split(own_state), own_body)
    return values | {f"event {e.name}": e.formula(now, own_body) for e in kind.system.events}


def _own_units(kind: Kind, state: list[Any], body: Any) -> tuple[list[Any], Any]:
    """Return state and body in the units in which a run with these numbers would be integrated:
    events are looked for there, and one whose level is not zero moves with them. The unit of time
    is a power of two, and stays.
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
    state, body, rates = kind.motion()
    known = expressions_of(kind, state, body)
    names = tuple(known) if names is None else names
    values = [ZERO + known[name] for name in names]
    by_time = _derivatives(values, dict(zip(state, rates, strict=True)))
    outputs = kind.with_derivatives(values) + by_time
    return names, compiled_once(hy.cfunc, outputs, vars=kind.symbols, compact_mode=True)
