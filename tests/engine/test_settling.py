"""What settles stays only where theory says so."""

import numpy as np
import pytest

from tippetop.engine.settling import stays
from tippetop.engine.status import Status
from tippetop.mechanics.theory import thresholds
from tippetop.mechanics.units import SECOND
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.run import solve


@pytest.fixture(scope="module")
def problem() -> Problem:
    return starting.load("inverting")


@pytest.mark.parametrize(
    ("side", "factor"), [(s, f) for s in ("upright", "inverted") for f in (0.9, 1.1)]
)
def test_a_spin_stays_iff_it_is_stable(side: str, factor: float, problem: Problem) -> None:
    """Upright below lambda_u, inverted above lambda_s; the spin is in
    internal units.
    """
    body, upright = problem.body(float), side == "upright"
    limit = thresholds.lambda_u(body) if upright else thresholds.lambda_s(body)
    spin = thresholds.spin_of(factor * limit, body, inverted=not upright)
    second = float(problem.scales.of(SECOND))
    values = {
        "theta": np.array([1e-4 if upright else np.pi - 1e-4]),
        "omega3": np.array([spin * second]),
    }
    assert stays(problem, values) is ((factor < 1) == upright)


def test_what_does_not_slide_stays_away_from_the_poles_and_in_a_plane(problem: Problem) -> None:
    away = {"theta": np.array([0.5]), "omega3": np.array([1e3])}
    assert stays(problem, away)
    assert stays(starting.load("gliding-cylinder"), {"theta": np.array([0.0])})


@pytest.mark.parametrize("mu", [0.0, 1e-9])
def test_friction_that_takes_nothing_to_speak_of_lets_nothing_settle(mu: float) -> None:
    """Its loss is below the threshold from the start, while the contact slides on."""
    problem = starting.load("inverting", [f"friction.mu={mu}", "run.stop_when=settled"], until=12.0)
    solution = solve(problem, keep=False)
    assert solution.status is Status.FINISHED
    assert solution.report["t_end"] == 12.0  # 200 internal units are 9 s
    assert solution.report["outcome"] == ("under-way" if mu else "nutating")
