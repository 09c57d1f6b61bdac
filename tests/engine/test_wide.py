"""Events in wider numbers: found in doubles, refined in the working precision; tables reach the
highest orders.
"""

from typing import Any

import examples
import numpy as np
import pytest

from tippetop.engine.driver import Driver, Slice
from tippetop.engine.status import Status
from tippetop.engine.taylor import driver_of
from tippetop.engine.wide import WideDriver
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.run import solve
from tippetop.scenario import build


class Nothing:
    """No rows."""

    rows_at_steps = False

    def next_times(self) -> np.ndarray:
        return np.zeros(0)


def load(precision: str, *sets: str, until: float = 0.4) -> Problem:
    return starting.load(
        "inverting", [f"run.precision={precision}", "initial.theta_dot=0.2", *sets], until
    )


def done(problem: Problem) -> tuple[Driver, Slice]:
    driver = driver_of(problem)
    piece = driver.advance(Nothing(), 1 << 40)
    assert piece.status is Status.FINISHED
    return driver, piece


@pytest.fixture(scope="module")
def runs() -> dict[str, tuple[Driver, Slice]]:
    """The same top in three precisions."""
    return {precision: done(load(precision)) for precision in ("double", "longdouble", "quad")}


def test_zeros_of_all_precisions_agree(runs: dict[str, Any]) -> None:
    """With those of doubles to their rounding; of 80 bits and quadruple precision to 1e-17."""
    found = [runs[precision][1].passages for precision in ("double", "longdouble", "quad")]
    assert len(found[0].times) > 10
    quad = found[2].times
    for passages, least, most in zip(found, (0, 0), (1e-13, 1e-17), strict=False):
        np.testing.assert_array_equal(passages.events, found[2].events)
        np.testing.assert_array_equal(passages.signs, found[2].signs)
        apart = np.array([quad.dtype.type(time) for time in passages.times]) - quad
        assert least < np.abs(apart.astype(float)).max() < most


@pytest.mark.parametrize(("precision", "bound"), [("longdouble", 1e-18), ("quad", 1e-30)])
def test_a_refined_zero_is_one(precision: str, bound: float, runs: dict[str, Any]) -> None:
    """theta' and the normal force vanish in the state of their zero to the rounding of the working
    precision.
    """
    passages, problem = runs[precision][1].passages, load(precision)
    body = problem.internal_body
    for e, state in zip(passages.events, passages.states, strict=True):
        event = problem.system.events[e]
        q, _ = problem.variables.split(state)
        if event.name == "turning":
            assert abs(float(event.formula(problem.form.scalars(q, body), body))) < bound


def test_the_highest_orders_are_followed() -> None:
    """Quadruple precision at the least tolerance that a scenario may ask for."""
    tight, usual = (
        done(load("quad", "run.tolerance=2e-39", until=0.05)),
        done(load("quad", until=0.05)),
    )
    order = tight[0].workspace.compiled.integrator.order
    assert order > usual[0].workspace.compiled.integrator.order > 32
    assert isinstance(tight[0], WideDriver)
    np.testing.assert_array_equal(tight[1].passages.events, usual[1].passages.events)
    assert len(usual[1].passages.events) > 0
    difference = np.abs((tight[1].passages.times - usual[1].passages.times).astype(float))
    assert difference.max() < 1e-28


def test_a_wide_run_ends_where_its_steps_move_no_double() -> None:
    """Beyond its liftoff friction jams the contact: steps of 80 bits become shorter than doubles
    can count.
    """
    numbers = examples.HEAVY
    start = {
        "theta": 2.483539299169197,
        "omega3": -248.84951671601448,
        "phi_dot": -35.72394908708138,
    }
    start |= {"nu_x": -0.18641810482211407, "nu_y": 0.21082810002430513}
    run = {"until": 0.5, "on_liftoff": "continue", "precision": "longdouble"}
    friction = {"law": "viscous", "mu": 1.9603670971960712}
    tables = {"parameters": numbers, "friction": friction, "initial": start, "run": run}
    ended = solve(build.problem({"system": "gliding-heavy-top", **tables}))
    assert ended.status is Status.STALLED
    assert np.isfinite(ended.final.astype(float)).all()
