"""The playground integrates by the formulas of the package: it is held against the engine, in a
browser.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tippetop as tt
from tippetop.cli import outcome
from tippetop.views.encoding import problem_data
from tippetop.views.playground import playground


pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
ROOT = Path(__file__).parents[2]


def test_the_playground_of_the_docs_is_the_one_of_the_formulas() -> None:
    """Else: tippetop view --playground --out docs/playground.html --overwrite."""
    assert (ROOT / "docs" / "playground.html").read_text(encoding="utf-8") == playground()


def test_the_command_writes_the_playground(tmp_path: Path) -> None:
    assert outcome(["view", "--playground", "--out", str(tmp_path / "x.html")]) == 0
    assert (tmp_path / "x.html").read_text(encoding="utf-8") == playground()


@pytest.fixture(scope="module")
def tab(open_page: Any) -> Any:
    return open_page(playground())


def in_page(tab: Any, problem: tt.Problem, times: np.ndarray) -> np.ndarray:
    """theta at some times, integrated in the page."""
    about = problem_data(problem)
    start = {name: float(value) for name, value in about["initial"].items()}
    numbers = {**about["parameters"], **about["friction"]}
    top = {"law": about["law"], "parameters": numbers, "initial": start, "atRest": about["atRest"]}
    return np.array(
        tab.evaluate("([top, times]) => tippetop.thetas(top, times)", [top, times.tolist()]),
        dtype=float,
    )


def test_the_canonical_inversion_is_that_of_the_engine(tab: Any) -> None:
    times = np.linspace(0.05, 10.0, 200)
    run = tt.run("inverting", until=10.0, output_times=times)
    difference = np.abs(in_page(tab, run.problem, times) - run.trajectory.theta.values)
    assert difference.max() < 1e-6
    assert tab.faults == []


@pytest.mark.slow
def test_twenty_tops_are_those_of_the_engine(tab: Any) -> None:
    rng = np.random.default_rng(20)
    worst = []
    for i in range(20):
        m, R, alpha, gamma = (
            rng.uniform(0.005, 0.1),
            rng.uniform(0.01, 0.04),
            rng.uniform(0.05, 0.5),
            rng.uniform(0.7, 1.2),
        )
        I3 = rng.uniform(0.25, 0.5) * m * R**2
        top = tt.TippeTop(m=m, R=R, alpha=alpha, I1=gamma * I3, I3=I3, g=9.81)
        law = (
            tt.friction.Viscous(mu=rng.uniform(0.05, 1))
            if i % 4
            else tt.friction.Coulomb(mu=rng.uniform(0.1, 0.5), eps=0.02)
        )
        start = dict(
            theta=rng.uniform(0.05, 3.0),
            omega3=rng.uniform(-200, 200),
            theta_dot=rng.uniform(-3, 3),
        )
        start |= dict(
            phi=rng.uniform(-3, 3), phi_dot=rng.uniform(-3, 3), nu_x=rng.uniform(-0.3, 0.3), psi=1.0
        )
        times = np.linspace(0.02, 2.0, 100)
        run = tt.run(top, law, start=start, until=2.0, output_times=times, on_liftoff="continue")
        found = in_page(tab, run.problem, times)
        worst.append(np.abs(found - run.trajectory.theta.values).max())
    assert max(worst) < 1e-5, worst


def test_sliders_change_the_motion_and_its_thresholds(tab: Any) -> None:
    verdict, cell = tab.locator("[data-part=verdict]"), tab.locator("[data-part=thresholds] td")
    assert "inverted" in verdict.inner_text()
    expected = tt.theory.thresholds(tt.load("inverting"))["lambda_s"].value
    assert float(cell.nth(5).inner_text()) == pytest.approx(1e6 * expected, rel=1e-3)
    spin = tab.locator("[data-part=slider-omega3]")
    spin.evaluate("e => { e.value = 40; e.dispatchEvent(new Event('input')); }")
    tab.wait_for_function(
        "document.querySelector('[data-part=verdict]').textContent.includes('upright')"
    )
    assert "omega3 = 14" in tab.locator("[data-part=scenario]").text_content()
    assert "14 rad/s = 2.2 turns/s" in tab.locator("[data-part=start-sliders]").inner_text()
    tab.locator("[data-part=law]").select_option("coulomb")
    tab.wait_for_function(
        "document.querySelector('[data-part=scenario]').textContent.includes('eps = 0.01')"
    )
    tab.locator("[data-part=preset]").select_option("leine-glocker")
    tab.wait_for_function(
        "document.querySelector('[data-part=verdict]').textContent.includes('passed 90° at 1.05')"
    )
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert tab.faults == []


def shown(tab: Any, **start: float) -> str:
    """The sentence about the canonical top with another start, at whose end the page is."""
    return tab.evaluate(
        """(start) => {
        const { playground } = tippetop;
        playground.take("inverting");
        playground.start.set(start);
        playground.show(true);
        tippetop.set(tippetop.end);
        tippetop.draw();
        return document.querySelector("[data-part=verdict]").textContent;
    }""",
        start,
    )


def test_a_top_lifts_off_where_the_engine_lets_it_lift_off(tab: Any) -> None:
    """At the time at which the force is zero, not at the sample after it."""
    run = tt.run("inverting", start={"omega3": 342.6, "theta": 0.1})
    assert run.summary.status == "liftoff"
    assert "Lifts off at 4.93 s" in shown(tab, omega3=342.6)
    assert tab.evaluate("tippetop.end") == pytest.approx(run.summary.t_end, abs=1e-7)
    force = tab.evaluate("tippetop.pose(tippetop.end).force[2]")
    assert 0 <= force < 1e-9


@pytest.mark.parametrize(
    ("start", "where"),
    [
        ({"until": 6.9}, "nearly inverted"),
        ({"until": 10.0}, "is inverted"),
        ({"omega3": 44.0}, "tilted"),
    ],
)
def test_the_end_of_a_motion_has_a_word(tab: Any, start: dict, where: str) -> None:
    assert where in shown(tab, **start)


def test_the_scenario_for_the_engine_is_the_top_of_the_page(tab: Any, tmp_path: Path) -> None:
    tab.locator("[data-part=preset]").select_option("inverting")
    path = tmp_path / "mine.toml"
    path.write_text(tab.locator("[data-part=scenario]").text_content(), encoding="utf-8")
    there, here = tt.load(path), tt.load("inverting")
    assert there.parameters == pytest.approx(here.parameters)
    assert (there.initial, there.friction, there.until) == (here.initial, here.friction, here.until)
