"""Sign changes are bisected to neighbouring numbers; what settles stays only where theory says so."""

import numpy as np
import pytest

from tippetop.engine.settling import stays
from tippetop.engine.zeros import sign_changes
from tippetop.mechanics.theory import thresholds
from tippetop.problem import Problem
from tippetop.scenario import build


def test_every_sign_change_is_found_once_with_its_sign(rng: np.random.Generator) -> None:
    """Of polynomials with known roots, one at most between two points of the grid, none on them."""
    grid = np.linspace(-1.0, 1.0, 41)
    for _ in range(50):
        cells = np.sort(rng.choice(40, rng.integers(0, 7), replace=False))
        roots = grid[cells] + 0.05 * rng.uniform(0.1, 0.9, len(cells))
        p = np.polynomial.Polynomial.fromroots(roots) if len(roots) else np.polynomial.Polynomial([1.0])
        found = sign_changes(p, grid)
        np.testing.assert_allclose([when for when, _ in found], roots, rtol=0, atol=1e-13)
        assert [sign for _, sign in found] == [(-1) ** k for k in range(len(roots) - 1, -1, -1)]


def test_the_later_of_two_neighbouring_numbers_is_given() -> None:
    """At it the function has the new sign already; at its neighbour it has not."""
    ((when, sign),) = sign_changes(lambda x: x**2 - 2, np.array([0.0, 1.0, 2.0]))
    assert sign == 1
    assert when**2 - 2 > 0 >= np.nextafter(when, 0) ** 2 - 2


def test_a_zero_that_is_touched_is_no_sign_change() -> None:
    assert sign_changes(lambda x: (x - 0.3) ** 2, np.linspace(0, 1, 11)) == []


def test_a_point_of_the_grid_that_is_zero_is_no_sign_change() -> None:
    """Values of no sign start or end a stretch: so a start on the zero is no event."""
    assert sign_changes(lambda x: x, np.array([0.0, 1.0, 2.0])) == []


# --- settling -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def problem() -> Problem:
    return build.load("inverting")


@pytest.mark.parametrize(("side", "factor"), [(s, f) for s in ("upright", "inverted") for f in (0.9, 1.1)])
def test_a_spin_stays_iff_it_is_stable(side: str, factor: float, problem: Problem) -> None:
    """Upright below lambda_u, inverted above lambda_s [section 6]; the spin is in internal units."""
    body, upright = problem.body(float), side == "upright"
    limit = thresholds.lambda_u(body) if upright else thresholds.lambda_s(body)
    spin = thresholds.spin_of(factor * limit, body, inverted=not upright)
    second = 0.045
    values = {"theta": np.array([1e-4 if upright else np.pi - 1e-4]), "omega3": np.array([spin * second])}
    assert stays(body, values, second) is ((factor < 1) == upright)


def test_away_from_the_poles_what_does_not_slide_stays(problem: Problem) -> None:
    body = problem.body(float)
    assert stays(body, {"theta": np.array([0.5]), "omega3": np.array([1e3])}, 1.0)


def test_a_motion_in_a_plane_stays() -> None:
    """It has no spin, and no pole that it could leave."""
    problem = build.load("gliding-cylinder")
    assert stays(problem.body(float), {"theta": np.array([0.0])}, 1.0)
