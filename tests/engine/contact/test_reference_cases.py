"""Whole runs through phases of the contact, against the reference: states within 1e-11, events
within 1e-11 s.
"""

import numpy as np
import pytest
from touching import reference

from tippetop.mechanics.contact.contact_phases import PHASES
from tippetop.runs.run import solve
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


@pytest.mark.parametrize("name", CASES)
def test_a_run_is_that_of_the_reference(name: str) -> None:
    """States, the phase of each row, events."""
    tables, case = reference(name)
    solution = solve(build.problem(tables))
    columns, events = solution.columns(), solution.events
    np.testing.assert_array_equal(solution.times, np.array(case["t"], dtype=float))
    for column, keys in KEYS.items():
        for key in keys:
            if key in case and column in columns:
                expected = np.array(case[key], dtype=float)
                error = np.abs(columns[column].values - expected) / SCALES.get(column, 1.0)
                assert error.max() <= 1e-11, (column, error)
    assert [PHASES[int(p)] for p in columns["phase"].values] == case["phase"]
    ours = [
        (events.kinds[kind], time)
        for kind, time in zip(events.kind, events.time, strict=True)
        if events.kinds[kind] in ("stick", "slip", "reversal", "liftoff", "impact")
    ]
    expected = [
        (EVENTS.get(event["kind"], event["kind"]), pytest.approx(float(event["t"]), abs=1e-11))
        for event in case["events"]
        if event["kind"] != "touch-body"
    ]
    assert ours == expected
