"""Ways to write and to compile the tippe top that were tried, over the first six seconds of the
inversion.

The error is that of cos(theta) in the midst of the inversion, against quadruple numbers. A product
of two series costs order^2/2 multiplications in a step, any other operation order: products are
what a formulation can save.
"""

import math
import statistics
from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np

from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.mechanics.operand import leaves
from tippetop.problem import Problem
from tippetop.runs import starting

from .case_ensemble import MIDST
from .measure import interleaved, timed
from .minimal import Minimal
from .ours import end_of, start_by_hand, tippe_top_by_hand


PRODUCT, ALONE = "the product's", "the motion alone"
ANGULAR_VELOCITY = (
    4.0  # of the rotating frame, internal: between slow precession and half the fast one
)


class Tried:
    """A system of equations with its start, ready to run to `end`; `z` reads cos(theta) from a
    state.
    """

    def __init__(
        self,
        sys: list,
        start: np.ndarray,
        end: float,
        z: Callable[[np.ndarray], float],
        **options: Any,
    ):
        numbers = {"pars": options.pop("pars")} if "pars" in options else {}
        self.made = hy.taylor_adaptive(
            sys, start, **{"tol": 2.0**-52, "high_accuracy": True, **numbers, **options}
        )
        self.start, self.end, self.z = start.copy(), end, z

    def run(self) -> int:
        """Integrates from the start; gives the number of steps."""
        self.made.time = 0.0
        self.made.state[:] = self.start
        return self.made.propagate_until(self.end)[3]

    def products(self) -> int:
        """Products, quotients and other operations on two series in a step."""
        texts = [str(expression) for expression, _ in self.made.decomposition]
        return sum(
            text.count("u_") > 1 and ("*" in text or text.startswith("div")) for text in texts
        )


def compare(quick: bool) -> dict[str, Any]:
    """Terms, products, steps, milliseconds and error of every way."""
    tried = ways()
    exact = _exact()
    found: dict[str, Any] = {
        "title": "Formulations of the canonical inversion",
        "until": MIDST,
        "ways": {},
    }
    for name, way in tried.items():
        steps = way.run()
        found["ways"][name] = {
            "terms": len(way.made.decomposition),
            "products": way.products(),
            "order": way.made.order,
            "steps": steps,
            "error": abs(way.z(way.made.state) - exact),
        }
    works = {name: lambda way=way: timed(way.run) for name, way in tried.items()}
    for name, times in interleaved(works, 5 if quick else 25).items():
        found["ways"][name]["seconds"] = statistics.median(times)
    return found


def ways() -> dict[str, Tried]:
    """All that was tried, by name."""
    vector, euler = (_inverting(f"form={form}") for form in ("vector", "euler"))
    sys, start, pars = _system(vector)
    alone = sys[: vector.variables.moving]
    few, end = start[: len(alone)], end_of(vector)
    numbers = {hy.par[i]: hy.expression(value) for i, value in enumerate(pars)}
    constants = [(v, hy.subs(rate, numbers)) for v, rate in alone]
    minimal = Minimal(vector, np.array([MIDST]))
    by_hand, angles = tippe_top_by_hand(minimal)[0], _system(euler)
    own = {"pars": pars}
    return {
        "by hand: vectors, SI units, numbers for parameters": Tried(
            by_hand, start_by_hand(minimal), MIDST, _uz
        ),
        f"{PRODUCT}: L_3 carried, parameters at run time, with x, y, work, impulse": Tried(
            sys, start, end, _uz, **own
        ),
        f"{PRODUCT} equations in Euler angles": Tried(*angles[:2], end, _cosine, pars=angles[2]),
        f"{ALONE}, without integrals": Tried(alone, few, end, _uz, **own),
        f"{ALONE}, numbers for parameters": Tried(constants, few, end, _uz),
        f"{ALONE}, in a rotating frame": Tried(_rotating(alone), few, end, _uz, **own),
        f"{ALONE}, plain sums (high_accuracy off)": Tried(
            alone, few, end, _uz, **own, high_accuracy=False
        ),
        f"{ALONE}, fast_math": Tried(alone, few, end, _uz, **own, fast_math=True),
        f"{ALONE}, slp_vectorize": Tried(alone, few, end, _uz, **own, slp_vectorize=True),
        f"{ALONE}, compact_mode": Tried(alone, few, end, _uz, **own, compact_mode=True),
        f"{ALONE}, tolerance 2^-49": Tried(alone, few, end, _uz, **own, tol=2.0**-49),
        f"{ALONE}, tolerance 2^-46": Tried(alone, few, end, _uz, **own, tol=2.0**-46),
    }


def _inverting(*settings: str) -> Problem:
    return starting.load("inverting", [*settings, f"run.output_step={MIDST}"], MIDST)


def _system(problem: Problem) -> tuple[list, np.ndarray, list[float]]:
    sys = equations_of_motion(
        formulas_of(problem.system, problem.form.name, type(problem.friction)), problem.variables
    ).rates
    return sys, problem.start(), [float(leaf) for leaf in leaves(problem.internal_body)]


def _rotating(sys: list) -> list:
    """The same motion seen from a frame that turns about the vertical: no product is new."""
    rates, at = {str(v): rate for v, rate in sys}, {str(v): v for v, _ in sys}
    for x, y in (("ux", "uy"), ("Lx", "Ly"), ("rx_dot", "ry_dot")):
        rates[x], rates[y] = (
            rates[x] + ANGULAR_VELOCITY * at[y],
            rates[y] - ANGULAR_VELOCITY * at[x],
        )
    return [(at[name], rate) for name, rate in rates.items()]


def _uz(state: np.ndarray) -> float:
    return float(state[2])


def _cosine(state: np.ndarray) -> float:
    return math.cos(state[0])


def _exact() -> float:
    wide = _inverting("run.precision=quad")
    sys = equations_of_motion(
        formulas_of(wide.system, wide.form.name, type(wide.friction)), wide.variables
    ).rates
    pars = np.array([wide.number(leaf) for leaf in leaves(wide.internal_body)])
    options = {"tol": wide.number(2.0**-112), "fp_type": wide.number, "compact_mode": True}
    made = hy.taylor_adaptive(sys, wide.start(), pars=pars, high_accuracy=True, **options)
    made.propagate_until(wide.number(wide.until) / wide.number(wide.scales.time))
    return float(made.state[2])
