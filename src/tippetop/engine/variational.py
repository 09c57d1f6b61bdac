"""The variational equations: derivatives of motions along directions in the space of all numbers
that a user gives.

Everything is a function of one parameter `along`: the numbers are p + along v. The start, the
equations of motion, columns and event functions are differentiated by it, as expressions: the
formulas are those of the run, and one integrator serves every direction, each in a SIMD lane.
Units are those of the problem.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..mechanics.contact.body import Touch, height
from ..mechanics.moment import moment
from ..mechanics.operand import Vector, cos, leaves, refill, sin
from ..mechanics.rotation import outer
from ..mechanics.system import Form, System
from ..mechanics.units import Scales
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import AXES, observed, orientation_of


ALONG = hy.par[0]
"""The parameter of the line; it is zero wherever a derivative is taken."""
ZERO = hy.expression(0.0)
COARSE = 1e-12  # tolerance of an integrator from which on rounding is no part of its error
TURN = tuple(f"turn_{i}{j}" for i in range(4) for j in range(4))
"""Entries of 4 q q^t of the orientation q."""


class Kind(NamedTuple):
    """Key of compiled tangents.

    Parameters
    ----------
    system, form_name, friction
        The equations of motion; friction is the type of the record of the law.
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

    def numbers(self, values: Iterable) -> tuple[Any, dict[str, Any]]:
        """Return the body and the initial data of the user's numbers, in order."""
        values = iter(values)
        body = self.system.body_of(
            {name: next(values) for name in self.system.parameters},
            self.friction._make(next(values) for _ in self.friction._fields),
        )
        return body, {
            **dict.fromkeys(self.flags, True),
            **dict(zip(self.initial, values, strict=True)),
        }

    def line(self) -> dict[Any, Any]:
        """Return the user's numbers along the line, each with its value where it begins.

        The numbers are parameters behind `along`, the direction those behind them.
        """
        n = len(self.system.parameters) + len(self.friction._fields) + len(self.initial)
        return {hy.par[i] + ALONG * hy.par[n + i]: hy.par[i] for i in range(1, n + 1)}


def _derivatives(values: Iterable, order: int) -> list[Any]:
    """Return expressions, their first derivatives along the line, then their second ones."""
    rows = [[ZERO + value for value in values]]
    for _ in range(order):
        rows.append([hy.diff(value, ALONG) for value in rows[-1]])
    return [value for row in rows for value in row]


@lru_cache(maxsize=32)
def compiled_starts(kind: Kind) -> Any:
    """Return the function of the parameters that gives the state at the start and its derivatives,
    ((order + 1) variables, n).
    """
    body, data = kind.numbers(kind.line())
    theta = ZERO + data.get("theta", 0.0)
    s, z = sin(theta), cos(theta)
    angles = kind.system.start(data, s, z, body)
    values = kind.variables.join(*kind.variables.start(data, angles, s, z, body))
    return compiled_once(hy.cfunc, _derivatives(values, kind.order), vars=[])


@lru_cache(maxsize=16)
def compiled_motion(kind: Kind, lanes: int, tolerance: float) -> Any:
    """Return heyoka's integrator of the state and its derivatives, in lanes."""
    variables, line = kind.variables, kind.line()
    symbols = [hy.expression(name) for name in variables.names]
    body, _ = kind.numbers(line)
    rates = [ZERO + rate for rate in variables.rates(*variables.split(symbols), body)]
    equations = list(zip(symbols, rates, strict=True))
    if kind.order:
        equations = hy.var_ode_sys(equations, [ALONG], order=kind.order).sys
    # numbers instead of sums, of which heyoka would compute every Taylor coefficient
    all_symbols, expressions = zip(*equations, strict=True)
    equations = list(zip(all_symbols, hy.subs(list(expressions), line), strict=True))
    careful = tolerance < COARSE  # compensated sums of steps: a quarter of the cost
    options = {"tol": tolerance, "high_accuracy": careful, "compact_mode": True}
    return compiled_once(
        hy.taylor_adaptive_batch, equations, np.zeros((len(equations), lanes)), **options
    )


def expressions_of(kind: Kind, q: Any, carried: Any, body: Any) -> dict[str, Any]:
    """Return functions of the state by name: columns, the height of the centre of mass, axes of the
    body, event functions.
    """
    form = kind.form
    values = observed(kind.system, form, q, carried, body)
    if isinstance(body, Touch):
        values |= {"height": height(form.scalars(q, body).z, body)}
    if kind.orientation and form.orientation:
        values |= orientation_of(kind.system, form, q, carried, body)
        first, third = (Vector(*(values[name] for name in axis)) for axis in (AXES[:3], AXES[3:]))
        turn = outer(first, third)
        values |= dict(zip(TURN, (entry for row in turn for entry in row), strict=True))
    own = _own_units(kind, q, carried, body)
    state = moment(form, *own)
    return values | {f"event {e.name}": e.formula(state, own[2]) for e in kind.system.events}


def _own_units(kind: Kind, q: Any, carried: Any, body: Any) -> tuple[Any, Any, Any]:
    """Return state, integrals and body in the units in which a run with these numbers would be
    integrated: events are looked for there, and one whose level is not zero moves with them. The
    unit of time is a power of two, and stays.
    """
    mass, length = kind.system.scales(body)
    scales = Scales(mass, length * kind.form.length_unit, 1.0)
    units = leaves(kind.system.body_units(kind.friction.units()))
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
) -> tuple[tuple[str, ...], Any]:
    """Return the names of readings, and the compiled function of states with derivatives,
    f(inputs=((order + 1) variables, n), pars=(the parameters, n)): their values, their derivatives
    along the line, and derivatives of the `timed` ones by time.

    `names`: None for all.
    """
    variables = kind.variables
    jets = [
        [hy.expression("d_" * k + name) for name in variables.names] for k in range(kind.order + 1)
    ]
    powers = (1.0, ALONG, 0.5 * ALONG * ALONG)
    state = [sum(map(hy.expression.__mul__, jet, powers), ZERO) for jet in zip(*jets, strict=True)]
    body, _ = kind.numbers(kind.line())
    known = expressions_of(kind, *variables.split(state), body)
    names = tuple(known) if names is None else names
    rates = variables.rates(*variables.split(state), body)
    outputs = _derivatives((known[name] for name in names), kind.order)
    for name in timed:
        value = ZERO + known[name]
        outputs.append(
            sum((hy.diff(value, y) * rate for y, rate in zip(jets[0], rates, strict=True)), ZERO)
        )
    inputs = [variable for jet in jets for variable in jet]
    return names, compiled_once(hy.cfunc, outputs, vars=inputs, compact_mode=True)
