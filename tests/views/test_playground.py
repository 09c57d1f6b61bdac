"""The playground integrates by the formulas of the package: it is held against the engine, in a
browser.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from nightly import at_night
from typed import typed

import tippetop as tt
from tippetop.mechanics.contact.body import BALLS
from tippetop.mechanics.contact.contact_phases import PHASES
from tippetop.mechanics.contact.uniqueness import painleve_bound
from tippetop.scenario import build
from tippetop.views.phase_formulas import numbers_for_page
from tippetop.views.playground import BY_NAME, playground


pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def written() -> str:
    return playground()


def test_the_playground_of_the_docs_is_the_one_of_the_formulas(written: str) -> None:
    """Else: tippetop view --playground --out docs/playground.html --overwrite."""
    assert (ROOT / "docs" / "playground.html").read_text(encoding="utf-8") == written


def test_the_command_writes_the_playground(written: str, tmp_path: Path) -> None:
    assert typed(f"view --playground --out {tmp_path}/x.html") == 0
    assert (tmp_path / "x.html").read_text(encoding="utf-8") == written


@pytest.fixture(scope="module")
def tab(open_page: Any, written: str) -> Any:
    return open_page(written)


def in_page(tab: Any, problem: tt.Problem, times: np.ndarray) -> dict[str, Any]:
    """theta at some times, phases and events, integrated in the page."""
    (law,) = (name for name, law in BY_NAME.items() if law is type(problem.friction))
    call = "([top, times]) => tippetop.followed(top, times)"
    found = tab.evaluate(call, [numbers_for_page(problem) | {"law": law}, times.tolist()])
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


DAILY = ("inverting", "cohen-coulomb", "flying")  # slides, rolls and flies


@pytest.mark.parametrize("name", [name if name in DAILY else at_night(name) for name in PRESETS])
def test_a_motion_and_its_phases_are_those_of_the_engine(tab: Any, name: str) -> None:
    times = np.linspace(0.05, PRESETS[name], 100)
    run = tt.run(name, until=PRESETS[name], output_times=times)
    found = in_page(tab, run.problem, times)
    assert np.abs(found["thetas"] - run.trajectory.theta.values).max() < 1e-6
    if run.problem.contact:
        starts = [phase["start"] for phase in found["phases"]]
        assert_near(starts, run.phases.start.values, 1e-6)
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
    assert float(cell.nth(6).inner_text()) == pytest.approx(1e6 * expected, rel=1e-3)
    spin = tab.locator("[data-part=slider-omega3]")
    spin.evaluate("e => { e.value = 40; e.dispatchEvent(new Event('input')); }")
    tab.wait_for_function(
        "document.querySelector('[data-part=verdict]').textContent.includes('upright')"
    )
    assert "omega3 = 14" in tab.locator("[data-part=scenario]").text_content()
    assert tab.locator("[data-part=typed-omega3]").input_value() == "14"
    assert "rad/s = 2.2 turns/s" in tab.locator("[data-part=start-sliders]").inner_text()
    typed_spin = tab.locator("[data-part=typed-omega3]")
    for text, kept in {"1480 rpm": "14", "1/3": "14", "": "14", "21,5 rad/s": "21.5"}.items():
        typed_spin.fill(text)
        typed_spin.press("Enter")
        assert typed_spin.input_value() == kept
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


LIMITS = {
    "m": (0.002, 0.2), "R": (0.005, 0.06), "alpha": (0.02, 0.6), "r": (1e-3, 0.02),
    "h": (5e-3, 0.06), "mu": (0.003, 10), "mu_stem": (0.003, 10), "mu_coulomb": (0.01, 1),
    "mu_static": (0.01, 1.5), "eps": (1e-4, 0.1), "v_s": (1e-3, 1), "patch": (5e-5, 2e-3),
    "mu_r": (1e-6, 2e-4),
}  # fmt: skip
"""Ends of the sliders, R for all lengths but the disc."""


def test_the_page_refuses_what_the_engine_refuses_in_the_same_words(tab: Any) -> None:
    rng, tops, expected = np.random.default_rng(47), [], []
    for _ in range(400):
        v = {name: float(np.exp(rng.uniform(*np.log(ends)))) for name, ends in LIMITS.items()}
        v["I3"] = float(rng.uniform(0.15, 0.65) * v["m"] * v["R"] ** 2)
        v["I1"] = float(rng.uniform(0.55, 1.5) * v["I3"])
        name, law = list(BY_NAME.items())[rng.integers(len(BY_NAME))]
        stem = {part: v[part] for part in ("r", "h")} if rng.random() < 0.7 else None
        body = {part: v[part] for part in ("m", "R", "alpha", "I1", "I3")} | {"g": 9.81}
        numbers = {part: v[part] for part in law.parameters}
        if "mu" in law.bounded_by and not stem and rng.random() < 0.4:  # at the bound
            numbers["mu"] = painleve_bound(tt.TippeTop(**body).body())
            numbers["mu"] *= 1 - rng.choice([1e-3, -1e-9, 1e-9])
        tops.append({"law": name, "parameters": body | numbers, "stem": stem})
        tables = {
            "system": "tippe-top", "parameters": body, "friction": {"law": law.key, **numbers},
            "contact": {"e_n": 0.0}, "run": {"until": 1.0},
        }  # fmt: skip
        try:
            build.problem(tables | ({"stem": stem} if stem else {}))
            expected.append("")
        except tt.InputError as error:
            expected.append(error.sentences[0])
    found = tab.evaluate("tops => tops.map(tippetop.refusal)", tops)
    assert [*map(plain, found)] == [*map(plain, expected)]
    kinds = {sentence.partition(", but")[0].partition("=")[0][:30] for sentence in expected}
    assert len(kinds) >= 5, kinds


def plain(sentence: str) -> str:
    """Write tiny numbers without exponents, as JavaScript does."""
    return re.sub(r"\d\S*\d", lambda n: f"{float(n[0]):.12g}", sentence)


def test_a_refused_top_is_not_shown_as_a_motion(tab: Any) -> None:
    tab.locator("[data-part=preset]").select_option("wooden-toy")
    tab.locator("[data-part=typed-R]").fill("46,8")
    tab.locator("[data-part=typed-R]").press("Tab")
    tab.wait_for_function("document.body.classList.contains('refused')")
    assert "`stem.h` must exceed R - r" in tab.locator("[data-part=verdict]").inner_text()
    tab.locator("[data-part=preset]").select_option("inverting")
    assert not tab.evaluate("document.body.classList.contains('refused')")


def test_the_address_keeps_the_settings(tab: Any) -> None:
    """A link shows the same top; numbers beyond the sliders, and words, do not reach it."""
    tab.locator("[data-part=preset]").select_option("leine-glocker")
    tab.locator("[data-part=law]").select_option("stribeck")
    for name, text in {"m": "7.25", "mu": "0.7"}.items():
        tab.locator(f"[data-part=typed-{name}]").fill(text)
        tab.locator(f"[data-part=typed-{name}]").press("Enter")
    scenario = "document.querySelector('[data-part=scenario]').textContent"
    tab.wait_for_function(f"{scenario}.includes('mu = 0.7') && location.hash.includes('mu=0.7')")
    link, text = tab.evaluate("location.hash"), tab.evaluate(scenario)
    tab.evaluate("location.hash = '#preset=cohen-coulomb'")
    tab.wait_for_function(f"!{scenario}.includes('mu = 0.7')")
    tab.evaluate("link => { location.hash = link; }", link)
    tab.wait_for_function(f"{scenario}.includes('mu = 0.7')")
    assert tab.evaluate(scenario) == text
    assert "m = 0.00725" in text
    tab.evaluate("location.hash = '#preset=nonsense&law=none&omega3=1e99&m=x&theta='")
    tab.wait_for_function(f"{scenario}.includes('omega3 = 350')")
    assert "m = 0.02\n" in tab.evaluate(scenario)
    tab.evaluate("location.hash = '#__proto__=1&law=constructor&omega3=61'")
    tab.wait_for_function(f"{scenario}.includes('omega3 = 61')")
    assert tab.faults == []


def test_one_phase_has_a_legend_and_rolling_no_arrow_of_sliding(tab: Any) -> None:
    """What the engine or the page leaves of a sliding velocity is rounding noise."""
    call = "([name, t]) => { tippetop.playground.take(name); tippetop.set(t); tippetop.draw(); }"
    key = tab.locator("[data-part=key]")
    tab.evaluate(call, ["inverting", 1.0])
    assert key.inner_text() == "slip: 100.0 %"
    assert slide(tab) > 0.05
    tab.evaluate(call, ["cohen-coulomb", 0.8])
    assert tab.locator("[data-part=phase]").inner_text() == "roll"
    assert slide(tab) < 1e-6


def slide(tab: Any) -> float:
    """Return the length of the arrow of the sliding velocity; 1.3 is the longest."""
    (arrow,) = (a for a in tab.evaluate("tippetop.arrows()") if a["name"] == "slip")
    return float(np.linalg.norm(arrow["drawn"]))


def test_a_slow_browser_shows_the_motion_in_real_time(tab: Any) -> None:
    passed = tab.evaluate("""() => {
        const { clock } = tippetop.stage;
        tippetop.playground.take("inverting");
        clock.speed = 1;
        tippetop.set(0);
        clock.play(true);
        [0, 400, 1200, 1210].forEach((now) => clock.tick(1e6 + now));
        clock.play(false);
        return clock.time;
    }""")
    assert passed == pytest.approx(1.21)


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
        at_night({"until": 10.0}, "is inverted"),
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
