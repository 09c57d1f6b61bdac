"""Compile derivatives of motions along directions of the input numbers.

`Formulas` of a run go in; out comes heyoka's integrator of the same equations for numbers with
derivatives. The formulas are those of the run; their operands are expressions with derivatives. A
number and its direction are parameters of the compiled functions, so that one integrator serves
every direction, each in a SIMD lane. `derivatives.through` integrates with it.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from ..mechanics.dual import Dual
from ..mechanics.variables import Variables
from .code_cache import compiled_once
from .expressions import Formulas, equations_of_motion
from .opt_level import opt_level


TOLERANCE = 1e-14
"""Of a step. Below it steps would need sums in double length, which cost a quarter more."""


@lru_cache(maxsize=128)
def compiled_flow(formulas: Formulas, variables: Variables, lanes: int, order: int) -> Any:
    """Return heyoka's integrator of formulas with derivatives along one direction for each lane.

    Its variables and parameters are those of the equations, and numbers of the body; each is before
    its derivatives up to an order. LLVM compiles it at level 1 at most: in little more than half
    the time of level 3, and the code is as fast.
    """
    equations = equations_of_motion(formulas, variables, order).rates
    return compiled_once(
        hy.taylor_adaptive_batch,
        equations,
        np.zeros((len(equations), lanes)),
        tol=TOLERANCE,
        compact_mode=True,
        opt_level=min(opt_level(), 1),
    )


class Moving(Dual):
    """A number with its derivatives by time."""

    __slots__ = ()
    level = 1

    @property
    def rate(self) -> Any:
        """Return the time derivative."""
        return Moving(*self.parts[1:])


def in_motion(variables: Variables, state: Sequence[Any], body: Any, order: int) -> list[Any]:
    """Return the variables of a state as numbers with their time derivatives, up to this order.

    Each pass through the rates adds one derivative.
    """
    moving: list[Any] = [*state]
    for _ in range(order):
        rates = variables.rates(*variables.split(moving), body)
        moving = [
            Moving(one, *(rate.parts if isinstance(rate, Moving) else (rate,)))
            for one, rate in zip(state, rates, strict=True)
        ]
    return moving
