"""The drift that a run reports is that of its rows: told by runs that were made badly on purpose."""

from collections.abc import Callable

import examples
import numpy as np
import pytest

from tippetop.engine.invariants import size
from tippetop.runs.run import solve
from tippetop.scenario import build


def momenta(column: dict[str, np.ndarray], p: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """L_3, and L_z about a point of the axis where the moment across it is I1."""
    L3 = p["I3"] * column["omega3"]
    return L3, p["I1"] * column["phi_dot"] * np.sin(column["theta"]) ** 2 + L3 * np.cos(column["theta"])


def jellett(column: dict[str, np.ndarray], p: dict[str, float]) -> np.ndarray:
    """R L_z - alpha R L_3, about the centre of mass."""
    L3, Lz = momenta(column, p)
    return p["R"] * (Lz - p["alpha"] * L3)


def about_the_tip(p: dict[str, float]) -> dict[str, float]:
    return {**p, "I1": p["I1"] + p["m"] * p["l"] ** 2}


def vertical_momentum(column: dict[str, np.ndarray], p: dict[str, float]) -> np.ndarray:
    return momenta(column, about_the_tip(p))[1]


def energy(column: dict[str, np.ndarray], p: dict[str, float]) -> np.ndarray:
    """Of a heavy top about its fixed tip."""
    across = column["theta_dot"] ** 2 + (column["phi_dot"] * np.sin(column["theta"])) ** 2
    turning = about_the_tip(p)["I1"] * across + p["I3"] * column["omega3"] ** 2
    return turning / 2 + p["m"] * p["g"] * p["l"] * np.cos(column["theta"])


@pytest.mark.parametrize(
    ("scenario", "name", "formula"),
    [
        ("inverting", "jellett", jellett),
        ("heavy-top", "Lz", vertical_momentum),
        ("heavy-top", "energy", energy),
        ("heavy-top", "energy_balance", energy),
    ],
)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_the_drift_is_the_worst_relative_change(scenario: str, name: str, formula: Callable, tolerance: float) -> None:
    sets = ["form=euler", f"run.tolerance={tolerance}", "run.output_step=0.0005"]
    run = solve(build.load(scenario, sets, until=2.0))
    values = formula(examples.columns(run), run.problem.parameters)
    worst = np.abs(values / values[0] - 1).max()
    assert worst > 1e-12  # it was made badly
    assert run.report["drift"][name] == pytest.approx(worst, rel=0.05)  # rows, and the ends of steps


def test_a_drift_is_relative_to_the_start_or_to_the_unit_where_that_is_zero() -> None:
    np.testing.assert_array_equal(size(np.array([2.0, -3.0, 1e-5, 1e-7, 0.0])), [2.0, 3.0, 1e-5, 1.0, 1.0])
