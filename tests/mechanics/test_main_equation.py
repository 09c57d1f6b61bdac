"""Three forms of one motion: the main equation gives back the theta(t) of a run, from D(t) and
E~(t) alone.
"""

import examples
import numpy as np
import pytest
from limits import assert_near
from nightly import at_night

import tippetop as tt
from tippetop.engine.observables import Observables
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.theory.main_equation import reconstruct
from tippetop.mechanics.units import SECOND
from tippetop.runs.run import solve


SPUN = {"theta": 1.0, "phi_dot": 10.0, "omega3": 100.0}
ROLLED = {"theta": 1.0, "phi_dot": 20.0, "omega3": 60.0}
TIPPED = {"theta": 0.4, "phi_dot": 5.0, "omega3": 300.0}


@pytest.mark.parametrize(
    ("system", "start", "until", "turnings", "digits"),
    [
        ("tippe-top", examples.LATE, 0.1, 5, 1e-8),
        at_night("tippe-top", SPUN, 0.3, 9, 1e-8),
        at_night("gliding-heavy-top", TIPPED, 0.15, 7, 1e-8),
        ("rolling-tippe-top", ROLLED, 0.3, 6, 1e-9),  # constant momenta fix no turning
        ("heavy-top", TIPPED, 0.3, 5, 1e-9),
    ],
)
def test_main_equation_gives_the_motion_back(
    system: str, start: dict, until: float, turnings: int, digits: float
) -> None:
    """Through every turning point; the limit is the spline through 6001 rows."""
    parameters = examples.HEAVY if "heavy" in system else examples.CANONICAL
    friction = ("viscous", {"mu": 0.3}) if SYSTEMS[system].frictional else ("none", {})
    times = np.linspace(0, until, 6001)
    made = examples.problem(system, parameters, start, until, friction, times=times)
    run, view = solve(made), Observables(made)
    values, z = view.evaluate(run.rows), view.moment(run.rows).z
    momenta = [values[name] for name in made.system.momenta]
    second = float(made.scales.of(SECOND))
    expected = run.events.of("turning", significant=True).time / second
    assert len(expected) >= turnings
    found = reconstruct(
        made.system,
        view.body,
        run.times / second,
        momenta,
        values["modified_energy"],
        float(z[0]),
        2 * expected[0],
    )
    n = len(found.turnings)
    assert n >= len(expected) - 1
    assert_near(found.turnings, expected[:n], digits)
    known = np.isfinite(found.z)
    assert known.mean() > 0.95
    assert np.abs(np.arccos(found.z[known]) - np.arccos(z[known])).max() < digits
    assert found.mismatch < digits


@pytest.mark.slow
def test_a_piece_that_leaves_the_numbers_is_no_warning() -> None:
    """Pieces that are too long are tried with z beyond 1."""
    run = tt.run("ciocci-2b", until=0.5)
    found = tt.theory.reconstruct(run)
    assert np.nanmax(np.abs(found.theta.values - run.trajectory.theta.values)) < 1e-8
