"""Pegs, alpha < 0: the motion and the theory of the body with its axis turned round."""

import math
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from plans import plan_of
from refusals import refusal

import tippetop as tt
from helpers.touching import BODY, BOUNCE
from tippetop.exchange.scales import scale_of
from tippetop.mechanics.systems.tippe_top import TippeTop
from tippetop.runs import forecast, starting
from tippetop.scenario import build


TOP = tt.TippeTop(**BODY)
PEG = tt.TippeTop(**{**BODY, "alpha": -BODY["alpha"]})
START = {"theta": 0.5, "theta_dot": 2.0, "phi_dot": 5.0, "omega3": 60.0}
MOTIONS: dict[str, dict[str, Any]] = {
    "slip": {
        "system": "tippe-top",
        "friction": {"law": "viscous", "mu": 0.3},
        "initial": {**START, "nu_x": 0.1},
    },
    "roll": {"system": "rolling-tippe-top", "initial": START},
    "stick": {
        "system": "tippe-top",
        "friction": {"law": "coulomb", "mu": 0.3},
        "initial": {**START, "nu_y": 0.01},
    },
    "resist": {
        "system": "tippe-top",
        "friction": {"law": "coulomb", "mu": 0.3, "mu_r": 1e-4, "mu_d": 1e-4},
        "initial": {**START, "nu_x": 0.1},
    },
    "bounce": {**BOUNCE, "contact": {"e_n": 0.5}},
    "drill": {
        "system": "tippe-top",
        "friction": {"law": "contensou", "mu": 0.3, "patch": 5e-4},
        "initial": {**START, "nu_x": 0.01},
    },
}


def turned(tables: dict[str, Any]) -> dict[str, Any]:
    """The scenario of the same body with its axis turned round."""
    start = {
        name: -x if name in ("theta_dot", "omega3", "nu_x", "nu_y") else x
        for name, x in tables["initial"].items()
    }
    start |= {"theta": math.pi - start["theta"], "phi": math.pi}
    return {**tables, "parameters": PEG._asdict(), "initial": start}


@pytest.mark.parametrize("kind", MOTIONS)
def test_a_peg_moves_as_the_top_with_its_axis_turned_round(kind: str) -> None:
    tables = {"parameters": BODY, "run": {"until": 0.3, "output_step": 0.01}, **MOTIONS[kind]}
    top, peg = (tt.run(one).trajectory for one in (tables, turned({**tables})))
    assert_near(peg["axis"], -top["axis"], 1e-13)
    for name in ("L", "x", "y", "energy", "jellett", "normal_force", "routh"):
        if name in top:
            sign = -1 if name == "routh" else 1
            assert_near(peg[name], sign * top[name], 1e-13, name, relative=True)
    assert kind != "bounce" or 0 < (peg["phase"] == top["phase"].values).sum() == top.sizes["time"]


@pytest.mark.parametrize(("ratio", "stable"), [(0.9, False), (1.1, True)])
def test_the_upright_spin_of_a_rolling_peg_stays_above_lambda_pi_alone(
    ratio: float, stable: bool
) -> None:
    omega3 = (
        ratio * tt.theory.thresholds(PEG)["lambda_pi"].value / (PEG.I3 * PEG.R * (1 - PEG.alpha))
    )
    start = {"theta": 1e-5, "omega3": omega3}
    tables = {
        "system": "rolling-tippe-top",
        "parameters": PEG._asdict(),
        "initial": start,
        "run": {"until": 3.0},
    }
    assert (float(tt.run({**tables, "form": "vector"}).trajectory["theta"].max()) < 1e-3) is stable
    assert (
        f"upright spin of this lambda is {'' if stable else 'un'}stable"
        in forecast.assessment(build.problem(tables))["fate"]
    )


def test_words_of_theory_follow_the_axis_of_a_peg() -> None:
    of_top, of_peg = tt.theory.thresholds(TOP), tt.theory.thresholds(PEG)
    swap = {"upright": "inverted", "inverted": "upright"}
    for name, limit in of_top.items():
        other = of_peg["_".join(swap.get(word, word) for word in name.split("_"))]
        assert other.value == limit.value
        assert other.long_name == " ".join(swap.get(word, word) for word in limit.long_name.split())


def test_the_landscape_of_a_peg_is_that_of_the_top_with_D_turned_round() -> None:
    D, lam = np.linspace(-2e-4, 3e-4, 11), np.linspace(0, 4e-6, 9)
    top, peg = (
        tt.landscapes.minimal_surface(TOP, D=D, lam=lam),
        tt.landscapes.minimal_surface(PEG, D=-D[::-1], lam=lam),
    )
    for name, sign in (("F", 1), ("z", -1), ("F_D", -1), ("F_lambda", 1)):
        np.testing.assert_allclose(peg[name][::-1], sign * top[name], rtol=1e-13)
    lines = tt.landscapes.marked_lines(PEG, np.array([1e-6, 2e-6]))
    assert lines["on_surface"].values.tolist() == [[False, True], [True, True]]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"alpha": 0.0}, "`parameters.alpha` must be other than 0.0, but is 0"),
        ({"alpha": -1.0}, "`parameters.alpha` must be greater than -1.0, but is -1"),
    ],
)
def test_no_top_has_its_centre_of_mass_in_the_centre_or_outside(
    wrong: dict[str, float], sentence: str
) -> None:
    with refusal(sentence):
        tt.TippeTop(**{**BODY, **wrong})


@pytest.mark.parametrize(
    "how", [{"linspace": [-0.2, 0.2], "n": 4}, {"values": [0.1, -0.1]}, {"between": [-0.1, 0.3]}]
)
def test_an_axis_of_a_sweep_keeps_the_sign_of_alpha(how: dict[str, Any]) -> None:
    sample = {"method": "random", "n": 4, "seed": 1}
    more = {"sample": sample} if "between" in how else {}
    with refusal(r"`parameters\.alpha` must keep its sign along an axis, but goes from"):
        plan_of({"of": "parameters.alpha", **how}, **more)


def test_a_fit_keeps_the_sign_of_alpha() -> None:
    for value in (-0.25, 0.25):
        scale = scale_of(TippeTop.parameters["alpha"], value)
        assert sorted(map(scale.outside, (scale.low, scale.high))) == sorted(
            (0.0, math.copysign(1, value))
        )


def test_a_peg_with_a_stem_stands_on_it_only_with_its_centre_of_mass_above() -> None:
    for alpha, stands in ((-0.2, True), (-0.9, False)):
        stem = ["stem.r='12 mm'", "stem.h='10 mm'"]
        problem = starting.load(
            "leine-glocker-stem", [f"parameters.alpha={alpha}", "friction.mu=0.1", *stem]
        )
        assert ("lambda_s_stem" in forecast.assessment(problem)["thresholds"]) is stands


def test_a_peg_near_its_lowest_point_has_not_inverted() -> None:
    law = tt.friction.Viscous(mu=0.3)
    run = tt.run(PEG, law, start={"theta": 2.5, "omega3": 5.0}, until=1.0)
    assert run.summary.event_counts["inverted"] > 1
    assert run.summary.inversion.inverted_at is None
    assert "rises through" not in str(run)
    assert "\ninversion" not in str(run)
