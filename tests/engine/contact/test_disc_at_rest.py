"""A contact disc that comes to rest ends its run, and one that friction cannot hold passes its rest."""

import math

import numpy as np
import pytest
from touching import table_of

from tippetop.engine.observables import Observables
from tippetop.engine.status import Status
from tippetop.runs.run import solve
from tippetop.scenario.build import problem


PARAMETERS = {"m": 0.006, "R": 0.015, "alpha": 0.2, "I1": 8e-7, "I3": 7e-7, "g": 9.81}
LAW = {"law": "contensou", "mu": 0.3, "patch": 2e-3}


def run(until=1.0, friction=LAW, **tables):
    """A run of Leine and Glocker's top on a soft plane: its disc is large, so that it soon stands."""
    scenario = {"system": "tippe-top", "parameters": PARAMETERS, "friction": friction, "run": {"until": until}}
    return solve(problem(scenario | tables))


def turning_and_sliding(done, row):
    """|Omega_z| and |v_A| in a state."""
    columns = Observables(done.problem).columns(np.zeros(1), row[None, :])
    c = {name: column.values[0] for name, column in columns.items() if column.values.ndim == 1}
    turn = c["omega3"] * math.cos(c["theta"]) + c["phi_dot"] * math.sin(c["theta"]) ** 2
    return abs(turn), math.hypot(c["nu_x"], c["nu_y"])


@pytest.mark.parametrize("mu_r", [0.0, 1e-5])
def test_a_disc_that_neither_slides_nor_turns_ends_the_run(mu_r):
    """Energy, and Jellett's integral with what the torque took, up to there; friction could hold it there."""
    done = run(friction=LAW | {"mu_r": mu_r}, initial={"theta": 1.0, "omega3": 5.0, "phi_dot": 1.0})
    assert done.status is Status.ENDED
    assert "comes to rest" in done.reason
    assert done.report["steps"] < 5000
    assert max(done.report["drift"].values()) < 1e-13
    phases = table_of(done, "phases")
    assert phases["phase"].tolist() == [0]
    assert phases["end"][-1] == done.report["t_end"] < 1.0
    turn, speed = turning_and_sliding(done, done.final)
    assert turn < 1e-2
    assert speed < LAW["patch"] * 1e-2


def test_the_end_is_told_at_once_where_a_run_begins_at_rest():
    """Released with its axis tilted: it would roll like a ball."""
    done = run(initial={"theta": 0.5})
    assert done.status is Status.ENDED
    assert (done.report["t_end"], done.report["steps"]) == (0.0, 0)


def test_a_disc_that_slides_from_rest_is_no_end():
    """Friction is too weak to hold it."""
    done = run(until=0.05, friction=LAW | {"mu": 0.02}, initial={"theta": 0.5})
    assert done.status is Status.FINISHED


def test_a_disc_whose_turning_is_reversed_passes_its_rest():
    """theta' and the spin about 3hat turn it the other way, more than friction can hold: w and U vanish at once, and
    grow again."""
    start = {"theta": 1.2, "theta_dot": 20.0, "phi_dot": -9.0, "omega3": 21.0}
    disc = LAW | {"patch": 1e-3}
    done = run(until=0.02, friction=disc, parameters=PARAMETERS | {"I3": 12e-7}, initial=start)
    assert done.status is Status.FINISHED
    assert max(done.report["drift"].values()) < 1e-13
    columns = {name: column.values for name, column in done.columns().items()}
    turn = columns["omega3"] * np.cos(columns["theta"]) + columns["phi_dot"] * np.sin(columns["theta"]) ** 2
    assert np.all(np.diff(turn) > 0)
    assert turn[0] < 0 < turn[-1]


def test_a_disc_that_turns_back_after_its_rest_is_asked_again():
    """It passes, is turned so little that no speed rises beyond the bound, and comes back: it crawled from there on."""
    body = {"m": 0.006, "R": 0.015, "alpha": 0.17728, "I1": 7.16595e-7, "I3": 4.23674e-7, "g": 9.81}
    start = {"theta": 2.8308, "omega3": -63.34065, "phi_dot": 0.0041548, "theta_dot": -1.12325}
    disc = LAW | {"mu": 0.431, "patch": 2.8332e-3}
    done = run(until=1.0, friction=disc, parameters=body, initial=start)
    assert done.status is Status.ENDED
    assert done.report["steps"] < 10_000
    assert max(done.report["drift"].values()) < 1e-13
