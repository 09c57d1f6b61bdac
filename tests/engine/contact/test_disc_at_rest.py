"""A contact disc that comes to rest rolls without turning, until friction can no longer hold it."""

from types import SimpleNamespace

import numpy as np
from limits import assert_below
from touching import LEINE_GLOCKER, ROCKING

from tippetop.runs.run import solve
from tippetop.scenario.build import problem


LAW = {"law": "contensou", "mu": 0.3, "patch": 2e-3}


def scenario(until=1.0, friction=LAW, parameters=LEINE_GLOCKER, run=None, **tables):
    """Leine and Glocker's top on a soft plane: its disc is large, so that it soon rests."""
    run = {"until": until} | (run or {})
    return problem(
        {"system": "tippe-top", "parameters": parameters, "friction": friction, "run": run} | tables
    )


def columns_of(done):
    """Its columns, and Omega_z."""
    c = SimpleNamespace(**{name: column.values for name, column in done.columns().items()})
    c.turn = c.omega3 * np.cos(c.theta) + c.phi_dot * np.sin(c.theta) ** 2
    return c


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
    disc = LAW | {"patch": 1e-3}
    done = solve(
        scenario(until=0.02, friction=disc, parameters=LEINE_GLOCKER | {"I3": 12e-7}, initial=start)
    )
    assert done.report["contact_phases"]["counts"] == {"slip": 1}
    assert_below(1e-13, done.report["drift"])
    c = columns_of(done)
    assert np.all(np.diff(c.turn) > 0)
    assert c.turn[0] < 0 < c.turn[-1]
