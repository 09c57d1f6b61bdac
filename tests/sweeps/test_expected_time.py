"""Test the expected time of a sweep, which is measured on some of its tops."""

from typing import Any

import numpy as np
import pytest
from plans import plan_of
from touching import BOUNCE, STEM

from tippetop.engine.status import Status
from tippetop.ensembles import ensemble
from tippetop.sweeps import chunk, measuring
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.sweep_summary import lines


OMEGA = {"of": "initial.omega3", "linspace": [100.0, 175.0]}


def lanes(n: int, until: float = 0.3, **more: Any) -> Plan:
    return plan_of(OMEGA | {"n": n}, set={"run": {"until": until}}, **more)


def bouncing(*omegas: float) -> Plan:
    return plan_of({"of": "initial.omega3", "values": list(omegas)}, scenario=BOUNCE)


class Steps:
    """A clock that a step of an integrator moves by a millisecond, and nothing else."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.steps, measure = 0, chunk.measure

        def counted(*arguments: Any) -> Any:
            outcomes = measure(*arguments)
            self.steps += int(outcomes.columns["steps"].sum())
            return outcomes

        monkeypatch.setattr(chunk, "measure", counted)

    def __call__(self) -> float:
        return 1e-3 * self.steps


@pytest.mark.parametrize("until", [0.3, 3.0])
def test_the_steps_of_some_stand_for_those_of_all(
    until: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Count steps as time: a short sweep is measured whole, a long one by its beginning."""
    plan = lanes(24, until)
    tops = ensemble.vary(plan.base, plan.columns(np.arange(24)))
    whole = int(ensemble.measure(tops).columns["steps"].sum())
    clock = Steps(monkeypatch)
    found = measuring.measured(plan, clock)
    assert found["tops_measured"] == measuring.SOME
    assert found["core_seconds"] == pytest.approx(1e-3 * whole + measuring.WRITING, rel=0.15)
    assert clock.steps < 4 * 16 / 24 * whole


def test_tops_that_cannot_be_take_no_time(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_of({"of": "parameters.m", "values": [-1.0, -2.0]})
    found = measuring.measured(plan, Steps(monkeypatch))
    assert (found["tops_measured"], found["core_seconds"]) == (0, measuring.WRITING)


def test_a_bouncing_top_is_measured() -> None:
    found = measuring.measured(bouncing(50.0, 60.0))
    assert found["tops_measured"] == 2
    assert found["core_seconds"] > 10 * 2 * 30 * 0.8e-6  # what a lane would take


def test_the_contact_of_a_sweep_is_told() -> None:
    base = {"contact": {"restitution": "energetic", "e_n": 0.5}, "stem": STEM}
    facts: dict[str, Any] = {
        **{
            "status": "finished",
            "tops": 1,
            "tops_done": 1,
            "chunks": {"done": 1},
            "dimensions": ["a"],
            "shape": [1],
        },
        **{"counts": {}, "drift": {}, "runs": [], "faults": [], "failed": {}, "versions": {}},
        "plan": {"axis": [], "scenario": base},
    }
    told = dict(lines(facts))
    assert told["contact"] == "restitution = energetic, e_n = 0.5"
    assert told["stem"] == "r = 0.005, h = 0.013"
    assert "drift" not in told


def test_a_top_that_its_contact_ended_has_a_word() -> None:
    """Before, `info` of such a sweep was a traceback: the number of its status had no meaning."""
    words = chunk.column_schema(bouncing(60.0).base, None)["status"].attrs["flag_meanings"]
    assert words.split()[Status.ENDED.code] == "ended"
