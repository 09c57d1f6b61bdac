"""What is said of a run before it is made: quantities of the start from first principles, and what
it will take.
"""

import math

import pytest

from tippetop.runs import cost, forecast, starting
from tippetop.runs.run import solve


def test_quantities_of_the_start_are_those_of_a_spinning_ball() -> None:
    """Tilted, spinning about its axis, its contact at rest: the centre moves with R omega3
    sin(theta), and no more.
    """
    problem = starting.load("inverting", ["initial.theta=0.4", "initial.omega3=80.0"])
    p, found = problem.parameters, forecast.at_start(problem)
    c, s, z, L3 = p["R"] * p["alpha"], math.sin(0.4), math.cos(0.4), p["I3"] * 80.0
    assert found["jellett"] == pytest.approx((p["R"] * z - c) * L3, rel=1e-13)
    height, spin = p["m"] * p["g"] * (p["R"] - c * z), L3 * 80.0 / 2
    moving = p["m"] * (p["R"] * 80.0 * s) ** 2 / 2
    assert found["energy"] == pytest.approx(spin + moving + height, rel=1e-13)
    assert found["modified_energy"] == pytest.approx(found["energy"], rel=1e-13)


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


def test_cost_is_proportional_to_what_is_asked_for() -> None:
    """To the time, to the spin, to the rows; wider numbers cost more for each step."""
    base = cost.estimate(starting.load("inverting", until=100.0))
    twice = cost.estimate(starting.load("inverting", ["run.output_step=0.001"], until=200.0))
    assert twice["steps"] == pytest.approx(2 * base["steps"], abs=1)
    assert twice["megabytes"] == pytest.approx(2 * base["megabytes"], rel=1e-3)
    faster = cost.estimate(starting.load("inverting", ["initial.omega3=310.0"], until=100.0))
    assert faster["steps"] == pytest.approx(2 * base["steps"], abs=1)
    seconds = [
        cost.estimate(starting.load("inverting", [f"run.precision={precision}"], until=100.0))[
            "seconds"
        ]
        for precision in ("double", "longdouble", "quad")
    ]
    assert seconds == sorted(seconds)
    assert seconds[0] < seconds[1] / 10 < seconds[2] / 100


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
