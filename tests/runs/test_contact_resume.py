"""A run whose contact changes its phase continues bit by bit, in whichever phase it was
interrupted.
"""

import json
from typing import Any

import numpy as np
import pytest
from nightly import at_night
from touching import BOUNCE, ROCKING, STANDING, THROWN, TURNING

from tippetop.runs.integration import Integration
from tippetop.runs.sinks import Memory
from tippetop.scenario import build, reading


ON_STEM: dict[str, Any] = {
    **reading.read("wooden-toy"),
    "friction": {"law": "coulomb", "mu": 0.32},
    "contact": {"e_n": 0.5},
    "initial": {"theta": 2.992, "phi_dot": 11.8, "omega3": -79.9, "theta_dot": 4.7},
    "run": {"until": 0.08},
}
"""A top that bounces on its stem, slides on it, rolls on it, and slides again."""

DRILLS: dict[str, Any] = {
    **STANDING,
    "friction": {"law": "contensou", "mu": 0.3, "patch": 2e-3, "mu_r": 0.0},
    "contact": {"e_n": 0.0},
}
"""A top that rocks from its sphere to its stem, and stands on both, through every region of
friction that drills.
"""

LOADED: dict[str, Any] = {
    **BOUNCE,
    "friction": {"law": "coulomb", "mu": 0.3, "mu_r": 1e-4, "mu_d": 1e-4},
}
"""A top that bounces under torques of its contact, and rolls."""


def gathered(memory: Memory) -> list[np.ndarray]:
    """All that a sink has taken, as arrays."""
    table = memory.table()
    others = [
        np.concatenate([part[key] for part in parts])
        for parts in memory.others.values()
        for key in parts[0]
    ]
    return [
        np.concatenate(memory.times),
        np.concatenate(memory.states),
        table.time,
        table.kind,
        table.theta,
        *others,
    ]


@pytest.mark.parametrize(
    ("tables", "phases"),
    [
        (BOUNCE, "flight roll"),
        (THROWN, "slip flight roll"),
        (TURNING, "slip roll"),
        ({**ROCKING, "run": {"until": 0.2}}, "slip-inside rest"),
        at_night(STANDING, "slip stem-slip stem-flight flight both"),
        at_night(ON_STEM, "stem-flight stem-slip stem-roll"),
        at_night(DRILLS, "slip-between stem-slip-outside both-between-outside"),
        at_night(LOADED, "flight roll"),
        at_night({**THROWN, "run": {**THROWN["run"], "precision": "longdouble"}}, "slip flight"),
        at_night({**ROCKING, "run": {**ROCKING["run"], "precision": "longdouble"}}, "rest"),
    ],
)
def test_a_snapshot_in_any_phase_continues_to_the_same_bits(tables: dict, phases: str) -> None:
    problem = build.problem(tables)
    integration, whole = Integration(problem), Memory()
    integration.begin(whole)
    snapshots = []
    while integration.status is None:
        taken = [
            len(whole.times),
            len(whole.logs),
            {name: len(parts) for name, parts in whole.others.items()},
        ]
        if integration.t_end > 0:
            snapshots.append(
                (integration.driver.solver.name, json.dumps(integration.snapshot()), taken)
            )
        integration.add_slice(integration.driver.advance(integration, 3))
    integration.fill()
    kinds = {kind for kind, *_ in snapshots}
    assert kinds >= {*phases.split()}
    chosen = [next(s for s in snapshots if s[0] == kind) for kind in sorted(kinds)] + snapshots[-1:]
    for _, text, (times, logs, others) in chosen:
        again, memory = Integration(problem), Memory()
        again.restore(json.loads(text))
        memory.times, memory.states, memory.logs = (
            whole.times[:times],
            whole.states[:times],
            whole.logs[:logs],
        )
        memory.others = {name: whole.others[name][:count] for name, count in others.items()}
        again.run(memory)
        names = "times", "states", "event times", "events", "theta at events"
        for k, (a, b) in enumerate(zip(gathered(memory), gathered(whole), strict=True)):
            np.testing.assert_array_equal(a, b, [*names, "phases and impacts"][min(k, 5)])
        assert again.progress().phases == integration.progress().phases
