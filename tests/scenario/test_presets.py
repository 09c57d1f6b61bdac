"""Every preset runs, cites its source, and every system has one."""

import numpy as np
import pytest
from limits import assert_below
from nightly import at_night
from typed import answered, reported

from tippetop.columns import flag_words, flagged
from tippetop.engine.status import Status
from tippetop.library.finished_run import Run
from tippetop.mechanics.systems import SYSTEMS
from tippetop.runs import cost
from tippetop.runs.run import solve
from tippetop.runs.starting import load
from tippetop.scenario.reading import presets


EXPENSIVE = {"leine-glocker-drilling", "plastic-toy", "wooden-toy"}


@pytest.mark.parametrize("name", sorted(presets()))
def test_preset_runs_and_cites(name: str) -> None:
    assert presets()[name].startswith("# ")
    made = solve(load(name, until=0.5))
    assert made.status in (Status.FINISHED, Status.LIFTOFF)
    assert_below(1e-12, made.report["drift"])


@pytest.mark.parametrize(
    ("name", "stick", "theta"),
    [
        ("cohen-coulomb", 0.02878761568, 0.0528961411),
        ("leine-glocker-stem", 0.0361449219, 0.0363789785),
        ("mujoco-tutorial", 0.00106575846, 0.00071159046),
    ],
)
def test_coulomb_friction_sticks_when_the_literature_s_tops_do(
    name: str, stick: float, theta: float
) -> None:
    """Ten digits of two independent engines; from then on the top rolls, and its energy stays."""
    made = Run(solve(load(name, until=0.1))).datasets()
    phases, events = made["phases"], made["events"]
    assert [float(phases["end"][0]), float(phases["start"][1])] == pytest.approx(
        [stick, stick], abs=1e-11
    )
    assert [*flag_words(phases["phase"])] == ["slip", "roll"]
    at = flagged(events["kind"], "stick")
    assert events["theta"].values[at] == pytest.approx([theta], abs=1e-10)
    energy = made["trajectory"]["energy"].values[made["trajectory"]["time"].values > stick]
    assert np.ptp(energy) < 1e-13 * energy[0]


def test_mujoco_tutorial_stays_upright_under_exact_coulomb_friction() -> None:
    events = Run(solve(load("mujoco-tutorial"))).events
    assert events["theta"].max() == pytest.approx(0.002943501, abs=1e-9)


def test_every_system_has_a_preset() -> None:
    assert {load(name).system.name for name in presets()} == set(SYSTEMS)


@pytest.mark.parametrize(
    "name", [at_night(name) if name in EXPENSIVE else name for name in sorted(presets())]
)
def test_check_says_the_regime(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if name not in EXPENSIVE | {"inverting", "flying"}:  # most of the time goes there
        monkeypatch.setattr(cost, "measured", lambda *_: {})
    found = reported(f"check {name}")
    # the outlook is that of a contact that stays
    assert found.get("regime") or load(name).contact is not None
    monkeypatch.setattr(cost, "measured", lambda *_: {})
    assert " J, " in answered("check", name)[1]
