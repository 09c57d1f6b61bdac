"""Compile derivatives of motions and of their columns along directions of the input numbers.

`Formulas` of a run go in; out comes heyoka's integrator of the same equations for numbers with
derivatives. The formulas are those of the run; their operands are expressions with derivatives. A
number and its direction are parameters of the compiled functions, so that one integrator serves
every direction, each in a SIMD lane. `derivatives.through` integrates with it.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import chain, count, islice
from typing import Any

import heyoka as hy
import numpy as np

from ..mechanics.dual import Dual, parts_of
from ..mechanics.system import System
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import Formulas, formulas_of, observed, orientation_of
from .opt_level import opt_level


EXACT = 1e-14
"""Tolerance of a step in a phase that takes few. Below it steps are summed in double length, which
costs a quarter more.
"""


def in_duals(formulas: Formulas, variables: Variables, order: int) -> tuple:
    """Return the variables and their derivatives along a direction up to an order, as symbols; and
    the records that formulas take: the state, the integrals, the body.
    """
    pars = (hy.par[k] for k in count())
    body = formulas.body(Dual(*islice(pars, order + 1)) for _ in count())
    symbols = [
        [hy.expression("d_" * k + name) for k in range(order + 1)] for name in variables.names
    ]
    return symbols, *variables.split([Dual(*one) for one in symbols]), body


def expressions_of(values: Iterable, order: int) -> list[Any]:
    """Return numbers and their derivatives up to an order as expressions, one after another."""
    return [hy.expression(0.0) + part for value in values for part in parts_of(value, order)]


@lru_cache(maxsize=128)
def compiled_flow(
    formulas: Formulas, variables: Variables, lanes: int, order: int, tolerance: float
) -> Any:
    """Return heyoka's integrator of formulas with derivatives along one direction for each lane.

    Its variables and parameters are those of the equations, and numbers of the body; each is before
    its derivatives up to an order. LLVM compiles it at level 1 at most: in little more than half
    the time of level 3, and the code is as fast.
    """
    symbols, *records = in_duals(formulas, variables, order)
    rates = expressions_of(variables.rates(*records), order)
    equations = list(zip(chain(*symbols), rates, strict=True))
    options: Any = {"tol": tolerance, "high_accuracy": tolerance < EXACT, "compact_mode": True}
    options["opt_level"] = min(opt_level(), 1)
    zero = np.zeros((len(equations), lanes))
    return compiled_once(hy.taylor_adaptive_batch, equations, zero, **options)


@lru_cache(maxsize=64)
def compiled_columns(
    system: System, variables: Variables, friction: Any, order: int
) -> tuple[tuple[str, ...], Any]:
    """Return the names of the values of rows, and the compiled function of them with derivatives;
    variables and numbers are in the order of `compiled_flow`, and so are the values.
    """
    form = variables.form
    symbols, *records = in_duals(formulas_of(system, form.name, friction), variables, order)
    values = observed(system, form, *records)
    if variables.orientation and form.orientation:
        values |= orientation_of(system, form, *records)
    outputs = expressions_of(values.values(), order)
    level = min(opt_level(), 1)
    function = compiled_once(hy.cfunc, outputs, vars=[*chain(*symbols)], opt_level=level)
    return tuple(values), function


class Moving(Dual):
    """A number with its derivatives by time."""

    __slots__ = ()
    level = 1

    @property
    def rate(self) -> Any:
        """Return the time derivative."""
        return Moving(*self.parts[1:])


def in_motion(variables: Variables, state: Sequence[Any], body: Any, order: int) -> list[Any]:
    """Return the variables of a state as numbers with their time derivatives, up to this order."""
    moving: list[Any] = [*state]
    for _ in range(order):
        rates = variables.rates(*variables.split(moving), body)
        moving = [
            Moving(one, *(rate.parts if isinstance(rate, Moving) else (rate,)))
            for one, rate in zip(state, rates, strict=True)
        ]
    return moving
