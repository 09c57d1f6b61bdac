"""`form = "auto"`: the cheapest form that is regular on the whole way, chosen before the run."""

import math
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.ensembles.ensemble import vary
from tippetop.mechanics.systems import SYSTEMS
from tippetop.problem import CLEARANCE
from tippetop.runs import recording
from tippetop.runs.run import solve
from tippetop.scenario import build
from tippetop.store import root
from tippetop.sweeps.plan import Plan


NEAR = ["initial.theta=0.15", "initial.phi_dot=20.0"]  # it comes within 0.068 rad of the upright


def test_auto_is_the_default_and_an_explicit_form_wins() -> None:
    for form in (None, "auto"):
        assert build.load("rolling", [f"form={form}"] if form else []).form.name == "reduced"
    for form in SYSTEMS["rolling-tippe-top"].forms:
        assert build.load("rolling", [f"form={form}"]).form.name == form
    assert tt.run("rolling", until=0.01).summary["form"] == "reduced"
    assert tt.run("rolling", until=0.01, form="vector").summary["form"] == "vector"


@pytest.mark.parametrize("preset", ["inverting", "heavy-top", "gliding-heavy-top", "gliding-cylinder"])
def test_where_a_pole_may_come_near_or_nothing_is_cheaper_the_first_form_serves(preset: str) -> None:
    made = build.load(preset)
    assert made.form is next(iter(made.system.forms.values()))


def test_a_top_that_comes_near_a_pole_is_integrated_in_a_regular_form() -> None:
    """Seen before the run; theta of the run then does as was said."""
    problem = build.load("rolling", NEAR, 2.0)
    assert problem.form.name == "contact"
    theta = solve(problem).events.of("turning").theta
    said = float(problem.choice.because.split()[-4])
    assert said == pytest.approx(theta.min(), rel=2e-3)
    assert said < CLEARANCE


def test_what_auto_keeps_away_from_the_poles_stays_away(rng: np.random.Generator) -> None:
    """Random starts: no run in the reduced form comes nearer than the clearance, in vector form neither."""
    chosen = []
    for _ in range(12):
        start = {"theta": rng.uniform(0.02, 3.1), "theta_dot": rng.normal(0, 5), "phi_dot": rng.normal(0, 20)}
        sets = [f"initial.{name}={value!r}" for name, value in (start | {"omega3": rng.normal(0, 80)}).items()]
        sets += ['run.on_liftoff="continue"']
        problem = build.load("rolling", sets, 1.0)
        chosen.append(problem.form.name)
        if chosen[-1] == "reduced":
            theta = solve(build.load("rolling", [*sets, "form=vector"], 1.0)).events.of("turning").theta
            assert theta.min() >= CLEARANCE
            assert theta.max() <= math.pi - CLEARANCE
    assert {"reduced", "contact"} == set(chosen)


def test_the_store_names_the_form_and_says_why(tmp_path: Path) -> None:
    """A resumed run takes what the store names, and the same sentence."""
    attrs = {}
    for name, sets in (("auto", []), ("named", ["form=vector"]), ("near", NEAR)):
        store = tmp_path / f"{name}.zarr"
        recording.record(build.load("rolling", sets, 0.05), store)
        attrs[name] = root.attributes(store)
        again = build.problem(build.tables_of(attrs[name]))
        assert again.form.name == attrs[name]["form"]
        assert not again.auto
        assert again.choice.because == attrs[name]["auto_form"]["because"]
    assert [attrs[name]["form"] for name in attrs] == ["reduced", "vector", "contact"]
    assert [attrs[name]["auto_form"]["form"] for name in attrs] == ["reduced", "reduced", "contact"]
    assert "0.512 rad" in attrs["auto"]["auto_form"]["because"]


def test_many_tops_share_the_form_that_serves_them_all() -> None:
    """One of them might come near a pole; a form that is named is not changed."""
    assert vary(build.load("rolling"), {"initial.theta": [0.05, 1.0]}).base.form.name == "contact"
    plan = {"scenario": "rolling", "axis": [{"of": "initial.theta", "values": [0.05, 1.0]}]}
    assert Plan.from_tables(plan).base.form.name == "contact"
    with pytest.raises(tt.InputError, match="`form` must be"):
        vary(build.load("rolling", ["form=reduced"]), {"initial.theta": [0.5, 1.0]})
