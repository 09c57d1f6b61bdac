"""Whole runs through phases of the contact, against the reference: states within 1e-11, events
within 1e-11 s.
"""

import numpy as np
import pytest
from touching import BOUNCE, THROWN, TURNING, reference

from tippetop.mechanics.contact.state import PHASES
from tippetop.runs.run import Solution, solve
from tippetop.scenario import build


CASES = (
    "caseC1_coulomb_slip_to_roll",
    "caseC3_liftoff_flight_plastic_landing",
    "caseC6_cylinder_coulomb",
)
SCALES = {"theta_dot": 50.0, "phi_dot": 50.0, "omega3": 50.0, "nu_x": 0.1, "nu_y": 0.1, "nu_z": 0.1}
KEYS = {
    "theta": ("theta", "theta_unwrapped"),
    "theta_dot": ("thetadot",),
    "phi_dot": ("phidot",),
    "omega3": ("omega3",),
    "nu_x": ("nu_x",),
    "nu_y": ("nu_y",),
    "nu_z": ("nu_z",),
}
EVENTS = {"impact-body": "impact"}  # touch-body is the same moment, before it


@pytest.fixture(scope="module", params=CASES)
def run(request: pytest.FixtureRequest) -> tuple[Solution, dict]:
    tables, case = reference(request.param)
    return solve(build.problem(tables)), case


def test_states_are_those_of_the_reference(run: tuple[Solution, dict]) -> None:
    solution, case = run
    columns = solution.columns()
    np.testing.assert_array_equal(solution.times, np.array(case["t"], dtype=float))
    for name, keys in KEYS.items():
        for key in keys:
            if key in case and name in columns:
                expected = np.array(case[key], dtype=float)
                error = np.abs(columns[name].values - expected) / SCALES.get(name, 1.0)
                assert error.max() <= 1e-11, (name, error)


def test_the_phase_of_each_row_is_that_of_the_reference(run: tuple[Solution, dict]) -> None:
    solution, case = run
    assert [PHASES[int(p)] for p in solution.columns()["phase"].values] == case["phase"]


def test_events_are_those_of_the_reference(run: tuple[Solution, dict]) -> None:
    solution, case = run
    events = solution.events
    ours = [
        (events.kinds[kind], time)
        for kind, time in zip(events.kind, events.time, strict=True)
        if events.kinds[kind] in ("stick", "slip", "reversal", "liftoff", "impact")
    ]
    expected = [
        (EVENTS.get(event["kind"], event["kind"]), float(event["t"]))
        for event in case["events"]
        if event["kind"] != "touch-body"
    ]
    assert [kind for kind, _ in ours] == [kind for kind, _ in expected]
    np.testing.assert_allclose([t for _, t in ours], [t for _, t in expected], rtol=0, atol=1e-11)


@pytest.mark.parametrize("tables", [BOUNCE, THROWN, TURNING], ids=["bounce", "thrown", "turning"])
def test_energy_and_the_work_of_friction_balance_through_all_phases(tables: dict) -> None:
    report = solve(build.problem(tables)).report
    assert report["drift"]["energy_balance"] <= 1e-12
    assert report["drift"].get("jellett", 0.0) <= 1e-13


def test_phases_follow_each_other_without_a_gap() -> None:
    solution = solve(build.problem(BOUNCE))
    parts = solution.others["phases"]
    start, end, phase = (
        np.concatenate([part[key] for part in parts]) for key in ("start", "end", "phase")
    )
    assert start[0] == 0
    assert end[-1] == BOUNCE["run"]["until"]
    np.testing.assert_array_equal(start[1:], end[:-1])
    assert {PHASES[p] for p in phase} >= {"flight", "roll"}
    assert solution.report["contact_phases"]["impacts"] == sum(
        len(part["time"]) for part in solution.others["impacts"]
    )
