"""Thresholds over the map of a page: lines of zeros, where the motion itself has that threshold."""

import base64
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plans import plan_of

import tippetop as tt
from tippetop.views.borders import borders


UPRIGHT = "λ = λ_u: upright spin stable below"
OMEGA3 = {"of": "initial.psi_dot", "linspace": [10.0, 250.0], "n": 9}
MU = {"of": "friction.mu", "geomspace": [0.1, 0.9], "n": 3}


class Table(dict):
    """What is read of a sweep's table: words and units of its axes."""

    def __missing__(self, key: str) -> Any:
        return SimpleNamespace(attrs={"long_name": key, "units": "1"})


def of(*axes: dict[str, Any], **more: Any) -> dict[str, Any]:
    plan = plan_of(*axes, scenario="leine-glocker", **more)
    return borders(plan, list(plan.design.axes), Table())


def points(made: dict[str, Any], choice: int, label: str) -> np.ndarray:
    """x and y of a line, (n, 2)."""
    text = made["lines"][choice][made["labels"].index(label)]
    numbers = np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, 2)
    assert np.isnan(numbers[-1]).all()
    return numbers[~np.isnan(numbers[:, 0])]


def test_a_top_on_the_line_has_the_lambda_of_the_threshold() -> None:
    """For each choice of the further axis; mu plays no part."""
    made = of(OMEGA3, MU, {"of": "parameters.alpha", "values": [0.2, 0.1]})
    for choice, alpha in enumerate((0.1, 0.2)):
        line = points(made, choice, UPRIGHT)
        assert np.ptp(line[:, 0]) < 1e-3
        assert line[:, 1].min() < 0.1 < 0.9 < line[:, 1].max()
        top = tt.load("leine-glocker", [f"parameters.alpha={alpha}"])
        jellett = (
            7e-7 * line[0, 0] * 1.5e-2 * (np.cos(0.1) - alpha)
        )  # I3 omega3 R (z - alpha), of a top that spins only
        assert jellett == pytest.approx(tt.theory.thresholds(top)["lambda_u"].value, rel=1e-5)


def test_over_one_axis_a_threshold_is_one_upright_line() -> None:
    line = points(of(OMEGA3), 0, UPRIGHT)
    assert sorted(line[:, 1]) == [-np.inf, np.inf]
    assert (
        line[0, 0]
        == line[1, 0]
        == pytest.approx(points(of(OMEGA3, MU), 0, UPRIGHT)[0, 0], rel=1e-5)
    )


def test_where_tops_of_other_numbers_share_a_map_there_is_no_line() -> None:
    drawn = [
        {"of": key, "between": [low, high]}
        for key, low, high in (
            ("initial.psi_dot", 10, 250),
            ("friction.mu", 0.1, 0.9),
            ("parameters.alpha", 0.1, 0.2),
        )
    ]
    sample = {"method": "random", "n": 9, "seed": 1}
    assert of(*drawn, sample=sample) == {"labels": [], "lines": []}
