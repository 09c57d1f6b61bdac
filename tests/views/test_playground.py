"""The playground integrates by the formulas of the package: it is held against the engine, in a
browser.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nightly import at_night
from typed import typed

import tippetop as tt
from tippetop.mechanics.contact.body import BALLS
from tippetop.mechanics.contact.contact_phases import PHASES
from tippetop.views.phase_formulas import given
from tippetop.views.playground import BY_NAME, playground


pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
ROOT = Path(__file__).parents[2]


def test_the_playground_of_the_docs_is_the_one_of_the_formulas() -> None:
    """Else: tippetop view --playground --out docs/playground.html --overwrite."""
    assert (ROOT / "docs" / "playground.html").read_text(encoding="utf-8") == playground()


def test_the_command_writes_the_playground(tmp_path: Path) -> None:
    assert typed(f"view --playground --out {tmp_path}/x.html") == 0
    assert (tmp_path / "x.html").read_text(encoding="utf-8") == playground()


@pytest.fixture(scope="module")
def tab(open_page: Any) -> Any:
    return open_page(playground())


def in_page(tab: Any, problem: tt.Problem, times: np.ndarray) -> dict[str, Any]:
    """theta at some times, phases and events, integrated in the page."""
    (law,) = (name for name, law in BY_NAME.items() if law is type(problem.friction))
    call = "([top, times]) => tippetop.followed(top, times)"
    found = tab.evaluate(call, [given(problem) | {"law": law}, times.tolist()])
    return found | {"thetas": np.array(found["thetas"], dtype=float)}


PRESETS = {
    "inverting": 10.0,
    "cohen": 8.0,
    "cohen-coulomb": 1.0,
    "flying": 9.0,
    "leine-glocker-drilling": 4.89,
    "leine-glocker-stem": 1.0,
    "mujoco-tutorial": 8.0,
    "plastic-toy": 5.0,
    "wooden-toy": 4.0,
}
"""Presets with the time up to which every change of phase is compared: not the last of endless
ones."""


@pytest.mark.parametrize(
    "name", [at_night(name) if name in ("cohen", "plastic-toy") else name for name in PRESETS]
)
def test_a_motion_and_its_phases_are_those_of_the_engine(tab: Any, name: str) -> None:
    times = np.linspace(0.05, PRESETS[name], 100)
    run = tt.run(name, until=PRESETS[name], output_times=times)
    found = in_page(tab, run.problem, times)
    assert np.abs(found["thetas"] - run.trajectory.theta.values).max() < 1e-6
    if run.problem.contact:
        starts = [phase["start"] for phase in found["phases"]]
        np.testing.assert_allclose(starts, run.phases.start.values, rtol=0, atol=1e-6)
        labels = [f"{phase['phase']} {phase['ball']}" for phase in found["phases"]]
        assert labels == [f"{PHASES[p]} {BALLS[b]}" for p, b in zip(*where(run), strict=True)]
    assert tab.faults == []


def where(run: tt.Run) -> tuple[np.ndarray, np.ndarray]:
    return run.phases.phase.values, run.phases.ball.values


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    ["viscous", "coulomb", "regularised", "contensou", "mixed", "stribeck", "latitude", "none"],
)
def test_tops_drawn_by_chance_are_those_of_the_engine(tab: Any, law: str) -> None:
    rng = np.random.default_rng(20)
    make = {
        "viscous": lambda: tt.friction.Viscous(mu=rng.uniform(0.05, 1)),
        "coulomb": lambda: tt.friction.Coulomb(mu=rng.uniform(0.1, 0.4)),
        "regularised": lambda: tt.friction.Coulomb(mu=rng.uniform(0.1, 0.4), eps=0.02),
        "contensou": lambda: tt.friction.Contensou(mu=rng.uniform(0.1, 0.4), patch=3e-4),
        "mixed": lambda: tt.friction.Mixed(mu=0.2, mu_coulomb=0.1, eps=0.02),
        "stribeck": lambda: tt.friction.Stribeck(mu=0.2, mu_static=0.3, v_s=0.05, eps=0.02),
        "latitude": lambda: tt.friction.Latitude(mu=0.3, mu_stem=0.6),
        "none": tt.friction.Frictionless,
    }[law]
    worst = []
    for _ in range(10):
        m, R, alpha = rng.uniform(0.005, 0.1), rng.uniform(0.01, 0.04), rng.uniform(0.05, 0.4)
        I3 = rng.uniform(0.3, 0.5) * m * R**2
        top = tt.TippeTop(m=m, R=R, alpha=alpha, I1=rng.uniform(0.8, 1.2) * I3, I3=I3, g=9.81)
        start = dict(theta=rng.uniform(0.05, 3.0), omega3=rng.uniform(50, 200), nu_x=0.1, nu_y=0.1)
        times, stem = np.linspace(0.02, 1.5, 75), {"r": 0.25 * R, "h": 1.2 * R}
        contact = {"e_n": rng.choice([0.0, 0.4])}
        run = tt.run(
            top, make(), start=start, until=1.5, output_times=times, contact=contact, stem=stem
        )
        found = in_page(tab, run.problem, times)
        n = len(run.trajectory.theta)
        worst.append(np.nanmax(np.abs(found["thetas"][:n] - run.trajectory.theta.values)))
    assert np.median(worst) < 1e-9, worst
    assert max(worst) < 1e-3, worst  # bounces make a motion chaotic


def test_sliders_change_the_motion_and_its_thresholds(tab: Any) -> None:
    verdict, cell = tab.locator("[data-part=verdict]"), tab.locator("[data-part=thresholds] td")
    tab.locator("[data-part=preset]").select_option("inverting")
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
    tab.locator("[data-part=law]").select_option("regularised")
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


def test_a_light_top_flies_and_its_page_says_so(tab: Any) -> None:
    run = tt.run("inverting", start={"omega3": 342.6, "theta": 0.1})
    assert run.summary.status == "liftoff"
    assert "impacts" in shown(tab, omega3=342.6)
    first = tab.evaluate("tippetop.stage.shown.log.marks.find((m) => m.kind === 'liftoff').time")
    assert first == pytest.approx(run.summary.t_end, abs=1e-7)


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


AT_NIGHT = ("cohen", "flying", "leine-glocker-drilling", "plastic-toy", "wooden-toy")


@pytest.mark.parametrize("name", [at_night(name) if name in AT_NIGHT else name for name in PRESETS])
def test_the_scenario_for_the_engine_is_the_top_of_the_page(
    tab: Any, name: str, tmp_path: Path
) -> None:
    tab.locator("[data-part=preset]").select_option(name)
    path = tmp_path / "mine.toml"
    path.write_text(tab.locator("[data-part=scenario]").text_content(), encoding="utf-8")
    there, here = tt.load(path), tt.load(name, ["run.on_liftoff=fly"])
    assert there.parameters == pytest.approx(here.parameters)
    assert there.start() == pytest.approx(here.start(), abs=1e-15)
    assert tuple(there.friction) == pytest.approx(tuple(here.friction))
    assert (there.contact, there.until) == (here.contact, here.until)
