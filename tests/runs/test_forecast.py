"""What is said of a run before it is made: quantities of the start from first principles, and what
it will take.
"""

import pytest

from tippetop.runs import cost, forecast, starting
from tippetop.runs.run import solve


def test_everything_has_its_unit() -> None:
    problem = starting.load("inverting")
    found = forecast.assessment(problem)
    units = {quantity.name: quantity.unit.symbol for quantity in problem.system.quantities}
    assert {name: entry["unit"] for name, entry in found["at_start"].items()} == units
    assert found["thresholds"]["lambda_s"]["unit"] == "kg m3 s-1"
    assert found["thresholds"]["spin_full"]["unit"] == "rad s-1"
    assert found["thresholds"]["lambda_pi"]["meaning"] == "inverted spin stable in rolling above"


@pytest.mark.parametrize("preset", ["inverting", "rolling", "heavy-top"])
def test_steps_are_foretold_to_an_order_of_magnitude(preset: str) -> None:
    """No more is promised; measured: 0.3 to 4 times what the run takes."""
    problem = starting.load(preset, until=2.0)
    made = solve(problem, keep=False)
    assert 0.1 < cost.estimate(problem)["steps"] / made.report["steps"] < 10


def test_the_spin_that_a_stem_needs_is_the_published_one():
    """Leine and Glocker's top: 21.700 rad/s upright, 88.107 on its stem; nothing is promised where
    sliding may stop.
    """
    facts = forecast.assessment(starting.load("leine-glocker-drilling"))
    assert facts["thresholds"]["spin_upright"]["value"] == pytest.approx(21.700, abs=1e-3)
    assert facts["thresholds"]["spin_stem"]["value"] == pytest.approx(88.107, abs=1e-3)
    assert "drilling" in facts["regime"]
    sticks = forecast.assessment(starting.load("cohen-coulomb"))
    assert "may stop" in sticks["regime"]
    assert "fate" not in sticks
    assert "spin_stem" not in sticks["thresholds"]


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_a_quantity_that_rounding_hides_is_zero(precision: str) -> None:
    """The friction power mu g_n v^2 is 0 where v_A = 0, and not where it is small."""
    for slip, of_weight in ((0.0, 0.0), (1e-9, 0.3e-18)):
        changes = [f"initial.nu_x={slip}", f'run.precision="{precision}"']
        found = forecast.at_start(starting.load("inverting", changes))
        power = of_weight * found["normal_force"]
        assert found["friction_power"] == pytest.approx(power, rel=1e-5, abs=0.0)
