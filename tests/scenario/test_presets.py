"""Every preset runs, cites its source, and every system has one."""

import json

import pytest

from tippetop.cli import outcome
from tippetop.engine.status import Status
from tippetop.mechanics.systems import SYSTEMS
from tippetop.runs.run import solve
from tippetop.scenario.build import load
from tippetop.scenario.reading import presets


@pytest.mark.parametrize("name", sorted(presets()))
def test_preset_runs_and_cites(name: str) -> None:
    assert presets()[name].startswith("# ")
    made = solve(load(name, until=0.5))
    assert made.status in (Status.FINISHED, Status.LIFTOFF)
    assert max(made.report["drift"].values()) < 1e-12


def test_every_system_has_a_preset() -> None:
    assert {load(name).system.name for name in presets()} == set(SYSTEMS)


@pytest.mark.parametrize("name", sorted(presets()))
def test_check_says_the_regime(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["check", name, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["regime"]
    assert ("inversion_by_eps" in found) == ("eps" in found.get("friction", {}) and found["system"] == "tippe-top")
    assert outcome(["check", name]) == 0
    assert " J, " in capsys.readouterr().out
