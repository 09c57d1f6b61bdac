"""A contact disc that comes to rest rolls without turning, until friction can no longer hold it."""

import numpy as np
from examples import columns
from limits import assert_below
from test_phases_of_runs import run
from touching import LEINE_GLOCKER, ROCKING

from tippetop.runs.run import solve
from tippetop.scenario.build import problem


def test_a_disc_gives_way_where_friction_can_no_longer_hold_it():
    """It slides on, stops, and rests again."""
    done = solve(problem(ROCKING))
    assert_below(1e-13, done.report["drift"])
    counts = done.report["contact_phases"]["counts"]
    assert counts["rest"] > 1
    assert counts["slip"] > 1
    phases = done.report["contact_phases"]["first"]
    assert [p["reason"] for p in phases[1:3]] == ["rests", "gives"]


def test_a_disc_whose_turning_is_reversed_passes_its_rest():
    """theta' and the spin about 3hat turn it the other way, more than friction can hold: w and U
    vanish at once, and grow again.
    """
    start = {"theta": 1.2, "theta_dot": 20.0, "phi_dot": -9.0, "omega3": 21.0}
    disc = {"law": "contensou", "mu": 0.3, "patch": 1e-3}
    done = run(LEINE_GLOCKER | {"I3": 12e-7}, until=0.02, friction=disc, initial=start)
    assert done.report["contact_phases"]["counts"] == {"slip": 1}
    assert_below(1e-13, done.report["drift"])
    c = columns(done)
    turn = c["omega3"] * np.cos(c["theta"]) + c["phi_dot"] * np.sin(c["theta"]) ** 2
    assert np.all(np.diff(turn) > 0)
    assert turn[0] < 0 < turn[-1]
