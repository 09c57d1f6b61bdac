"""Runs through phases of the contact: what the starts and ends of slides may not change, and
published runs.
"""

import numpy as np
import pytest
from examples import CANONICAL
from limits import assert_below
from touching import LEINE_GLOCKER, ROLLS_THEN_SLIDES, ROLLS_THEN_SLIDES_MU, STEM, table_of

from tippetop.engine.status import Status
from tippetop.mechanics.contact import exits
from tippetop.runs.run import solve
from tippetop.scenario.build import problem


def run(parameters=CANONICAL, system="tippe-top", until=0.3, keep=True, **tables):
    """A run of a tippe top, Coulomb's law itself unless another is given."""
    friction = tables.pop("friction", {"law": "coulomb", "mu": 0.3})
    return solve(
        problem(
            {
                "system": system,
                "parameters": parameters,
                "friction": friction,
                "run": {"until": until},
                **tables,
            }
        ),
        keep=keep,
    )


def random_start(seed):
    """A start that slides, rolls or flies, and its friction."""
    rng = np.random.default_rng(seed)
    start = {
        "theta": rng.uniform(0.05, 3.1),
        "phi_dot": rng.uniform(-40, 40),
        "omega3": rng.uniform(-100, 100),
        "theta_dot": rng.uniform(-30, 30),
    }
    if seed % 3:
        start |= {"nu_x": rng.normal() * 0.3, "nu_y": rng.normal() * 0.3}
    return start, {"law": "coulomb", "mu": rng.uniform(0.05, 0.6)}


def test_how_a_slide_is_begun_does_not_show(monkeypatch):
    """The first moments of a slide are a polynomial over a span of choice: what follows does not
    depend on it.
    """
    friction = {"law": "coulomb", "mu": ROLLS_THEN_SLIDES_MU}
    rows, times = [], []
    for span in (0.06, 0.015):
        monkeypatch.setattr(exits, "SPAN", span)
        done = run(initial=ROLLS_THEN_SLIDES, friction=friction)
        rows.append(done.columns()["theta"].values)
        times.append(done.events.time)
    assert {5, 6} <= set(done.events.kind)
    assert np.max(np.abs(np.diff(rows, axis=0))) < 1e-11
    assert np.max(np.abs(np.diff(times, axis=0))) < 1e-11


def test_a_run_may_end_in_the_first_moments_of_a_slide() -> None:
    """Where a series gives the motion and no step."""
    body = {"m": 0.003, "R": 0.005, "alpha": 0.6, "I": 4e-8, "g": 256.0}
    about = {"friction": {"law": "coulomb", "mu": 0.09}}
    about |= {"initial": {"theta": 0.364, "theta_dot": -20.7}}
    whole = run(body, "gliding-cylinder", 0.02, **about)
    phases = whole.report["contact_phases"]["first"]
    start = next(phase["start"] for phase in phases if phase["reason"] == "slip")
    end = start + 1e-4
    at = run(body, "gliding-cylinder", **about, run={"until": 0.02, "output_times": [end]})
    short = run(body, "gliding-cylinder", **about, run={"until": end, "output": "steps"})
    assert short.status is Status.FINISHED
    assert short.report["contact_phases"]["last"]["start"] == start
    there, here = at.columns(), short.columns()
    for name in ("theta", "theta_dot", "x", "energy", "normal_force"):
        expected = pytest.approx(there[name].values[-1], rel=1e-12, abs=1e-15)
        assert here[name].values[-1] == expected
    assert here["time"].values[-1] == end


@pytest.mark.slow
def test_drilling_friction_turns_a_top_onto_its_stem():
    """Leine and Glocker's top with Hertz's pressure: on the stem at 1.37081 s; published: it stands
    until 4.5 s, then rocks between sphere and stem, and has both on the plane for 0.8 s, from about
    4.6 to 5.4 s.
    """
    friction = {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 0.0}
    start = {"theta": 0.1, "omega3": 180.0, "centre_at_rest": True}
    done = run(LEINE_GLOCKER, friction=friction, initial=start, stem=STEM, until=8.0)
    impacts = table_of(done, "impacts")
    assert impacts["time"][0] == pytest.approx(1.37081, abs=5e-6)
    assert impacts["ball"][0] == 1
    phases = table_of(done, "phases")
    (both,) = np.flatnonzero(phases["phase"] == 3)
    assert 4.6 < phases["start"][both] < phases["end"][both] < 5.7
    assert done.status is Status.FINISHED
    assert_below(1e-13, done.report["drift"])


@pytest.mark.parametrize(
    ("alpha", "mu", "patch", "start"),
    [
        (0.1156, 0.0212, 1.08e-4, {"theta": 2.5712, "nu_x": -0.0448, "theta_dot": 2.407}),
        (0.2179, 0.0200, 3.20e-4, {"theta": 0.2797, "nu_x": -0.2179, "theta_dot": 24.61}),
    ],
)
def test_a_disc_that_does_not_turn_turns_back_as_coulombs_law_has_it(alpha, mu, patch, start):
    """The slip passed its rest within a step, and friction was that of before: theta differed by
    2e-2.
    """
    numbers = {**CANONICAL, "alpha": alpha}
    laws = {"law": "contensou", "mu": mu, "patch": patch * 0.02}, {"law": "coulomb", "mu": mu}
    drills, slides = (
        run(numbers, friction=law, initial=start).columns()["theta"].values for law in laws
    )
    assert drills[-1] == pytest.approx(slides[len(drills) - 1], abs=1e-7)


def test_a_corner_of_theta_is_a_turning():
    """An impact that turns theta' round ends a swing: between two logged turnings theta is
    monotone.
    """
    corners = 0
    for seed in range(6):
        start, friction = random_start(seed)
        done = run(
            initial=start | {"gap": 0.003}, friction=friction, contact={"e_n": 0.7}, until=0.1
        )
        turnings, columns = done.events.of("turning"), done.columns()
        corners += np.isin(turnings.time, table_of(done, "impacts")["time"]).sum()
        t, theta = columns["time"].values, columns["theta"].values
        for begin, end in zip([0.0, *turnings.time], [*turnings.time, 0.1], strict=True):
            steps = np.diff(theta[(t > begin) & (t < end)])
            assert np.all(steps > 0) or np.all(steps < 0), (seed, begin, end)
    assert corners > 1
