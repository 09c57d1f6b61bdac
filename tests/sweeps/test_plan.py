"""Test the axes, draws and derived numbers of plans, and messages about bad plans."""

import itertools
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plans import all_numbers, plan_of
from refusals import refusal

from tippetop.errors import InputError
from tippetop.problem import Problem
from tippetop.runs import forecast
from tippetop.scenario import reading
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.sweep_summary import faults_of


GRID = [
    {"of": "initial.omega3", "linspace": [175.0, 100.0], "n": 4},
    {"of": "friction.mu", "geomspace": [0.1, 0.8], "n": 4},
    {"of": "run.until", "values": [1.0, 2.0, 0.5]},
]


def test_axes_take_texts_with_units() -> None:
    spin = {"of": "initial.omega3", "linspace": ["955 rpm", 175.0], "n": 3}
    numbers = all_numbers(plan_of(spin, {"of": "run.until", "values": ["2 min", 1.0, "3/2"]}))
    assert numbers["initial.omega3"][0] == 955 * 2 * np.pi / 60
    assert numbers["run.until"][:3].tolist() == [120.0, 1.0, 1.5]
    with refusal(r"`axis.1.values.0` must be in rad s-1 .* but is \"20 cm\""):
        plan_of({"of": "initial.omega3", "values": ["20 cm"]})


def test_a_chunk_is_a_stretch_of_the_whole() -> None:
    drawn = {"of": "lambda", "between": [0.5, 2.0]}
    of = plan_of(*GRID[1:], drawn, sample={"method": "sobol", "n": 8, "seed": 1}, chunk=7)
    whole = of.columns(np.arange(of.n))
    assert set(whole) == {"friction.mu", "run.until", "initial.omega3"}
    for key, values in whole.items():
        parts = [of.columns(of.tops(chunk))[key] for chunk in range(of.chunks)]
        assert np.concatenate(parts).tobytes() == values.tobytes()


def jellett_of(problem: Problem) -> tuple[float, float]:
    """Jellett's integral of a start and its threshold, as `check` says them."""
    found = problem.system.outlook(problem.body(), start := forecast.at_start(problem))
    return start["jellett"], found.thresholds["lambda_s"].value


@pytest.mark.parametrize("theta", [0.1, 2.5])
def test_derived_numbers_are_those_of_the_tops_that_they_make(theta: float) -> None:
    """The problems are read back by `check`, which knows nothing of plans."""
    axes = [
        {"of": "lambda", "values": [0.4, 2.0, -1.5]},
        {"of": "gamma", "values": [0.8, 1.2]},
        {"of": "sigma", "values": [2.2, 3.0]},
    ]
    of = plan_of(*axes, set={"initial": {"theta": theta, "phi_dot": 3.0, "theta_dot": 0.2}})
    numbers = all_numbers(of)
    for top in range(of.n):
        problem = of.problem(top)
        p = problem.parameters
        assert p["I1"] / p["I3"] == pytest.approx(numbers["gamma"][top], rel=1e-14)
        assert p["m"] * p["R"] ** 2 / p["I3"] == pytest.approx(numbers["sigma"][top], rel=1e-14)
        lam, limit = jellett_of(problem)
        assert lam / limit == pytest.approx(numbers["lambda"][top], rel=1e-12)
        assert problem.initial["phi_dot"] == 3.0


def test_sigma_alone_keeps_gamma() -> None:
    problem = plan_of({"of": "sigma", "values": [4.0]}).problem(0)
    assert problem.parameters["I1"] / problem.parameters["I3"] == pytest.approx(
        131 / 140, rel=1e-14
    )


def test_a_document_is_the_whole_plan(tmp_path: Path) -> None:
    """Read a document back from JSON: the same numbers, without the scenario's file."""
    (tmp_path / "mine.toml").write_text(reading.presets()["cohen"])
    axes = [{"of": "initial.omega3", "values": [1.0, float("nan"), 3.0, float("inf")]}, GRID[1]]
    one = Plan.from_tables(
        {"scenario": "mine.toml", "axis": axes, "keep": ["class"], "runs": [0]}, tmp_path
    )
    (tmp_path / "mine.toml").unlink()
    again = Plan.from_tables(json.loads(json.dumps(one.document, allow_nan=False)))
    assert again.document == one.document
    assert (again.chunk, again.n, again.keep, again.runs) == (one.chunk, 16, ["class"], [0])
    for key, values in one.columns(np.arange(one.n)).items():
        assert values.tobytes() == again.columns(np.arange(one.n))[key].tobytes()


@pytest.mark.parametrize(("n", "until"), [(10, 1.0), (1000, 10.0), (1000, 0.01)])
def test_chunks_hold_every_top_once_and_take_seconds(n: int, until: float) -> None:
    axes = [
        {"of": "initial.omega3", "linspace": [100, 175], "n": n},
        {"of": "friction.mu", "linspace": [0.1, 0.5], "n": n},
    ]
    of = plan_of(*axes, set={"run": {"until": until}})
    ends = [(tops[0], tops[-1]) for tops in map(of.tops, range(of.chunks))]
    assert ends[0][0] == 0
    assert ends[-1][1] == n * n - 1
    assert all(b[0] == a[1] + 1 for a, b in itertools.pairwise(ends))
    assert of.chunk * of.seconds_per_top < 8
    if n == 1000:
        assert of.chunk * of.seconds_per_top > 0.5


@pytest.mark.parametrize(("n", "chunk"), [(4, 4), (40, 40), (400, 100), (10_000, 256)])
def test_chunks_of_tops_whose_contact_changes_fill_lanes(n: int, chunk: int) -> None:
    axis = {"of": "initial.omega3", "linspace": [150, 350], "n": n}
    assert plan_of(axis, scenario="wooden-toy").chunk == chunk


def test_the_plan_of_the_documentation_is_one(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "docs" / "reference" / "sweeps.md").read_text(
        encoding="utf-8"
    )
    (tmp_path / "PLAN.toml").write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0])
    of = Plan.from_toml(tmp_path / "PLAN.toml")
    assert (of.n, of.base.until, of.runs) == (24, 8.0, [0])


@pytest.mark.parametrize(
    "changes", [{"output": "keyframes"}, {"output": "steps"}, {"output_times": [0.0, 1.0]}]
)
def test_set_takes_the_place_of_what_the_scenario_says_of_its_rows(changes: dict[str, Any]) -> None:
    plan = plan_of(GRID[0], set={"run": changes})
    run = plan.document["scenario"]["run"]
    assert "output_step" not in run
    assert {name: run[name] for name in changes} == changes


def test_another_law_takes_no_number_from_the_scenario() -> None:
    change = {"friction": {"law": "coulomb", "eps": 1e-3}}
    with refusal(r"`friction\.mu` must be given, but is missing"):
        plan_of(OMEGA, set=change)


OMEGA = {"of": "initial.omega3", "values": [100.0]}
DRAWN = {"of": "friction.mu", "between": [0.1, 0.5]}


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"axis": []}, "`axis` must have at least 1 item"),
        (
            {"axis": [OMEGA], "kep": []},
            "unknown key `kep`; did you mean `keep`? The keys are scenario, set, axis",
        ),
        ({"axis": [{**OMEGA, "linspace": [1, 2]}]}, "but has values and linspace"),
        ({"axis": [{**OMEGA, "n": 3}]}, "`axis.1.n` must be given"),
        ({"axis": [{**DRAWN, "between": [2, 1]}]}, "`axis.1.between` must ascend"),
        ({"axis": [DRAWN], "sample": {"method": "sobol", "n": 9, "seed": 1}}, "power of two"),
        (
            {"axis": [OMEGA], "sample": {"method": "sobol", "n": 8, "seed": 1}},
            "must have an axis with `between`",
        ),
        ({"axis": [OMEGA, OMEGA]}, "`initial.omega3` must be one axis only"),
        (
            {"axis": [{"of": "initial.spin", "values": [1]}]},
            "`initial.spin` must be one of sigma, gamma, lambda, ",
        ),
        (
            {"axis": [{"of": "lambda", "values": [1]}], "scenario": "gliding-heavy-top"},
            "must be an axis of tippe-top",
        ),
        (
            {"axis": [OMEGA], "set": {"initial": {"from": "RUN.zarr"}}},
            "must not be given in a plan",
        ),
        ({"axis": [OMEGA], "runs": [1]}, "`runs` must be numbers of tops, 0 to 0, but has 1"),
        (
            {"axis": [{"of": "friction.mu", "values": [-1]}], "runs": [0]},
            "top 0: `friction.mu` must be at least 0",
        ),
        (
            {"axis": [{**GRID[0], "n": 10**5}, {**GRID[1], "n": 10**5}]},
            "at most 1e+09 tops, but makes 1e+10",
        ),
    ],
)
def test_what_is_wrong_is_said(document: dict[str, Any], words: str) -> None:
    with refusal(re.escape(words)):
        Plan.from_tables({"scenario": "inverting", **document})


def test_all_that_is_wrong_is_said_at_once() -> None:
    axes = [{"of": "friction.mu", "geomspace": [0, 1], "n": 2}, {"of": "gamma"}, {**OMEGA, "n": 2}]
    with pytest.raises(InputError) as error:
        plan_of(*axes, runs=[3])
    assert len(error.value.sentences) == 3


def test_a_top_of_a_plan_stands_as_it_would_alone() -> None:
    """Begin on the stem; a larger sphere begins on itself, without the gap of the base."""
    base = ["stem.r=3e-3", "stem.h=2.45e-2", "initial.theta=2.06", "parameters.R=1.3e-2"]
    tables = reading.override(reading.read("wooden-toy"), base)
    plan = plan_of({"of": "parameters.R", "values": [1.2e-2, 1.55e-2]}, scenario=tables)
    assert plan.problem(0).initial["gap"] > 0
    assert "gap" not in plan.problem(1).initial


def test_info_says_why_a_contact_cannot_be_followed() -> None:
    axis = {"of": "friction.mu", "values": [0.3, 5.0]}
    (sentence,) = faults_of(plan_of(axis, scenario="leine-glocker-stem"), np.array([1]))
    assert sentence.startswith("top 1: `friction.mu` must be less than 1.3")
