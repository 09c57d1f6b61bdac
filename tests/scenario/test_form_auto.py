"""`form = "auto"`: the cheapest form that is regular everywhere."""

import math

import pytest
from limits import assert_near

import tippetop as tt
from tippetop.mechanics.contact.gliding import AWAY_FROM_POLE
from tippetop.mechanics.systems import SYSTEMS
from tippetop.runs import starting
from tippetop.runs.run import solve


def test_auto_is_the_default_and_an_explicit_form_wins() -> None:
    for sets in ([], ["form=auto"]):
        assert starting.load("rolling", sets).form.name == "contact"
    for form in SYSTEMS["rolling-tippe-top"].forms:
        assert starting.load("rolling", [f"form={form}"]).form.name == form
    assert tt.run("rolling", until=0.01).summary["form"] == "contact"
    assert tt.run("rolling", until=0.01, form="vector").summary["form"] == "vector"


@pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))
def test_what_auto_takes_is_regular_at_the_poles(system) -> None:
    assert AWAY_FROM_POLE not in next(iter(system.forms.values())).domains


@pytest.mark.parametrize(
    "start", [{"theta": 0.0, "theta_dot": 3.0}, {"theta": math.pi}, {"theta": 1e-5}]
)
def test_a_rolling_top_about_its_contact_passes_the_poles(start: dict) -> None:
    """Where the vector form goes, and with no undefined axis or momentum."""
    sets = [f"initial.{name}={value!r}" for name, value in ({"phi_dot": 0.0, **start}).items()]
    runs = [
        solve(starting.load("rolling", [*sets, f"form={form}"], 0.2)).columns()
        for form in ("auto", "vector")
    ]
    for name in ("theta", "axis", "L", "x", "y", "orientation"):
        mine, other = (columns[name].values for columns in runs)
        assert_near(mine, other, 1e-12)


def test_the_azimuth_is_as_exact_as_theta() -> None:
    """Near a pole phi of the reduced form is wrong by 1e-8 after 4 s: its integrals do not control
    the step.
    """
    sets = ["initial.theta=0.3", "initial.phi_dot=60.0", "run.output_step=0.05"]
    axis, wide = (
        solve(starting.load("rolling", [*sets, f'run.precision="{precision}"'], 4.0))
        .columns()["axis"]
        .values
        for precision in ("double", "longdouble")
    )
    assert_near(axis, wide, 1e-13)
