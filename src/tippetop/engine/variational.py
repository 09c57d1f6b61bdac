"""Compile the variational equations: derivatives of motions along directions of the input numbers.

The formulas are those of the run; their operands are expressions with derivatives. A number and its
direction are parameters of the compiled functions, so that one integrator serves every direction,
each in a SIMD lane.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import count
from typing import Any

import heyoka as hy
import numpy as np

from ..mechanics.dual import Dual, parts_of
from ..mechanics.operand import Vector, leaves
from ..mechanics.rotation import outer
from ..mechanics.system import System
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import AXES, Formulas, observed, orientation_of
from .opt_level import opt_level


TURN = tuple(f"turn_{i}{j}" for i in range(4) for j in range(4))
"""Entries of 4 q q^t of the orientation q."""


@lru_cache(maxsize=128)
def compiled_flow(
    formulas: Formulas,
    variables: Variables,
    lanes: int,
    order: int,
    tolerance: float,
    careful: bool,
) -> Any:
    """Return heyoka's integrator of formulas with derivatives along one direction for each lane.

    Its parameters are the numbers of the body, each before its derivatives up to an order.
    `careful`: whether steps are summed in double length, a quarter of the cost. LLVM compiles it at
    level 1 at most: in little more than half the time of level 3, and the code is as fast.
    """
    every = range(order + 1)
    body = formulas.body(Dual(*(hy.par[len(every) * i + k] for k in every)) for i in count())
    state = [Dual(*(hy.expression("d_" * k + name) for k in every)) for name in variables.names]
    rates = [parts_of(one, order) for one in variables.rates(*variables.split(state), body)]
    pairs = [*zip(state, rates, strict=True)]
    equations = [(one.parts[k], hy.expression(0.0) + rate[k]) for k in every for one, rate in pairs]
    options: Any = {"tol": tolerance, "high_accuracy": careful, "compact_mode": True}
    options["opt_level"] = min(opt_level(), 1)
    zero = np.zeros((len(equations), lanes))
    return compiled_once(hy.taylor_adaptive_batch, equations, zero, **options)


def expressions_of(
    system: System, variables: Variables, state: Sequence[Any], body: Any
) -> dict[str, Any]:
    """Return columns and axes of the body, as functions of the state."""
    form = variables.form
    q, carried = variables.split(state)
    values = observed(system, form, q, carried, body)
    if variables.orientation and form.orientation:
        values |= orientation_of(system, form, q, carried, body)
        first, third = (Vector(*(values[name] for name in axis)) for axis in (AXES[:3], AXES[3:]))
        values |= zip(TURN, leaves(outer(first, third)), strict=True)
    return values


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
