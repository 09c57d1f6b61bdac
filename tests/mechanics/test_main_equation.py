"""Three forms of one motion: the main equation gives back the theta(t) of a run, from D(t) and
E~(t) alone.
"""

import examples
import numpy as np
import pytest

from tippetop.engine.observables import Observables
from tippetop.mechanics.theory.main_equation import reconstruct
from tippetop.runs.run import solve


AT_4_354 = {
    "theta": 0.1930406939565264,
    "phi_dot": 213.19654689741958,
    "omega3": 147.31406907076985,
}
AT_4_354 |= {"nu_x": -0.036966204229469724, "nu_y": 0.16341042960004895}
"""The canonical inversion at its 233rd turning; two turnings later both curvatures of a turning
cross, p = 2.
"""


@pytest.mark.parametrize(
    ("system", "parameters", "start", "until", "turnings"),
    [
        ("tippe-top", examples.CANONICAL, AT_4_354, 0.1, 5),
        (
            "tippe-top",
            examples.CANONICAL,
            {"theta": 1.0, "phi_dot": 10.0, "omega3": 100.0},
            0.6,
            19,
        ),
        (
            "tippe-top",
            examples.CANONICAL,
            {"theta": 0.5, "phi_dot": -8.0, "omega3": 155.0},
            0.3,
            15,
        ),
        (
            "gliding-heavy-top",
            examples.HEAVY,
            {"theta": 0.4, "phi_dot": 5.0, "omega3": 300.0},
            0.15,
            7,
        ),
    ],
)
def test_main_equation_gives_the_motion_back(
    system: str, parameters: dict, start: dict, until: float, turnings: int
) -> None:
    """Through every turning point; the limit is the spline through 6001 rows."""
    made = examples.problem(
        system,
        parameters,
        start,
        until,
        ("viscous", {"mu": 0.3}),
        times=np.linspace(0, until, 6001),
    )
    run, view = solve(made), Observables(made)
    values, scalars, times = (
        view.evaluate(run.rows),
        view.moment(run.rows),
        made.internal_time(run.times),
    )
    momenta = [values[name] for name in made.system.momenta]
    energy = values["modified_energy"]
    expected = made.internal_time(run.events.of("turning", significant=True).time)
    assert len(expected) == turnings
    found = reconstruct(
        made.system, view.body, times, momenta, energy, float(scalars.z[0]), 2 * expected[0]
    )
    n = len(found.turnings)
    assert n >= turnings - 1
    np.testing.assert_allclose(found.turnings, expected[:n], rtol=0, atol=1e-8)
    known = np.isfinite(found.z)
    assert known.sum() > 0.95 * len(times)
    assert np.abs(np.arccos(found.z[known]) - np.arccos(scalars.z[known])).max() < 1e-8
    assert found.mismatch < 1e-8


@pytest.mark.parametrize(
    ("system", "parameters", "start", "turnings"),
    [
        (
            "rolling-tippe-top",
            examples.CANONICAL,
            {"theta": 1.0, "phi_dot": 20.0, "omega3": 60.0},
            24,
        ),
        ("heavy-top", examples.HEAVY, {"theta": 0.4, "phi_dot": 5.0, "omega3": 300.0}, 18),
    ],
)
def test_constant_momenta_need_no_turnings(
    system: str, parameters: dict, start: dict, turnings: int
) -> None:
    """Where D, lambda and E~ stay, Q does not depend on time and Q_t = 0 fixes no turning: 0.03 rad
    were lost by it.
    """
    made = examples.problem(system, parameters, start, 1.0, times=np.linspace(0, 1.0, 2001))
    run, view = solve(made), Observables(made)
    values, scalars, times = (
        view.evaluate(run.rows),
        view.moment(run.rows),
        made.internal_time(run.times),
    )
    momenta = [values[name] for name in made.system.momenta]
    expected = made.internal_time(run.events.of("turning", significant=True).time)
    found = reconstruct(
        made.system,
        view.body,
        times,
        momenta,
        values["modified_energy"],
        float(scalars.z[0]),
        2 * expected[0],
    )
    assert len(expected) >= turnings
    np.testing.assert_allclose(found.turnings, expected, rtol=0, atol=1e-9)
    assert np.abs(np.arccos(found.z) - np.arccos(scalars.z)).max() < 1e-9
    assert found.mismatch < 1e-9
