"""Test potential, surface, turning angles and bands against 60 digits and known numbers."""

import landscape_oracle as oracle
import mpmath as mp
import numpy as np
import pytest
import xarray as xr
from examples import CANONICAL, HEAVY
from limits import assert_near

from tippetop.landscape import marked_lines, potential, surface, turning
from tippetop.landscape.landscape_body import top
from tippetop.mechanics.theory import spinning
from tippetop_kernels.level_crossings import Level
from tippetop_kernels.minimise import Status


TOP, HEAVY_TOP = top(CANONICAL), top(HEAVY, "heavy-top")

# --- the potential ------------------------------------------------------------------------------


def potential_of(D, lam, b):
    """The oracle's potential as a function of z."""
    return lambda z: oracle.potential(z, mp.mpf(D), mp.mpf(lam), b)


@pytest.mark.parametrize("z", [-0.7, 0.1, 1 - 1e-6, 1 - 1e-12, 1e-9 - 1, 1e-15 - 1])
@pytest.mark.parametrize("line", [1, -1, 0])
def test_potential_keeps_its_digits(z, line):
    """Compare near the poles, on and off the marked lines, with the source's form in 60 digits."""
    b, lam = oracle.body(oracle.FIGURE), 4e-6
    for away in (0.0, 1e-13, 1e-7, 0.3):
        D = 2.2e-4 if line == 0 else float(spinning.slope(line, b)) * lam * (1 + away)
        found = potential.potential(top(oracle.FIGURE), z, D, lam)
        exact = potential_of(D, lam, b)(mp.mpf(z))
        assert oracle.ulps(found.V.item(), exact) <= 6
        slope = mp.diff(potential_of(D, lam, b), mp.mpf(z), h=mp.mpf(10) ** -25)
        scale = abs(exact) / (1 - mp.mpf(z) ** 2)
        assert abs(found.V_z.item() - slope) <= 1e-14 * scale


# --- the minimal surface ------------------------------------------------------------------------


def test_surface_does_not_know_the_grid():
    """A point has the same F, to the bit, alone, in a row and on two threads."""
    D, lam = np.linspace(-6e-4, 8e-4, 37), np.linspace(0, 7e-6, 53)
    one, two = (surface.minimal_surface(TOP, D, lam, threads=n) for n in (1, 2))
    xr.testing.assert_identical(one, two)
    for i, j in ((0, 0), (17, 30), (36, 52)):
        alone = surface.minimal_surface(TOP, D[i], lam[j])
        assert alone.F.item() == one.F[i, j].item()
        assert alone.z.item() == one.z[i, j].item()


@pytest.mark.parametrize(
    ("end", "status", "theta"), [(0, Status.AT_LOWER_END, 0.0), (1, Status.AT_UPPER_END, np.pi)]
)
def test_spinning_states_lie_on_the_surface(end, status, theta):
    """F is V at their pole, which it approaches: upright for every lambda, inverted from lambda_pi
    on; below, F is strictly lower. (5.1)
    """
    lam_pi = marked_lines.marked_lines(TOP, 0.0).lambda_pi
    assert lam_pi == pytest.approx(1.70683e-6, rel=1e-5)  # section 14
    some = np.array([0.1, 0.5, 0.9, 0.99, 1.01, 1.1, 3.0, 10.0])
    lam = lam_pi * np.concatenate([-some[::-1], some])
    lines = marked_lines.marked_lines(TOP, lam)
    for i, value in enumerate(lam):
        found = surface.minimal_surface(TOP, lines.D[end, i].item(), value)
        E = lines.E[end, i].item()
        on_surface = end == 0 or abs(value) >= lam_pi
        assert lines.on_surface[end, i] == on_surface
        if on_surface:
            assert found.status.item() == status
            assert found.theta.item() == theta
            assert found.z.item() == np.cos(theta)
            assert found.F.item() == pytest.approx(E, rel=2e-15)
        else:
            assert found.status.item() == Status.ATTAINED
            assert found.F.item() < E * (1 - 1e-9)


def test_nothing_moves_at_rest():
    """D = lambda = 0: the infimum m g R (1 - alpha) is approached at theta = 0."""
    found = surface.minimal_surface(TOP, [-1e-300, 0.0, 1e-30], [-1e-30, 0.0, 1e-300])
    weight = CANONICAL["m"] * CANONICAL["g"] * CANONICAL["R"] * 0.7
    np.testing.assert_allclose(found.F, weight, rtol=3e-16)
    assert found.status[1, 1] == Status.AT_LOWER_END
    assert not np.isin(found.status, [Status.UNSETTLED, Status.UNDEFINED]).any()


def test_what_is_not_finite_is_undefined():
    found = surface.minimal_surface(TOP, [1e-4, np.nan, np.inf], [0.0, 1e-6, np.nan])
    undefined = found.status == Status.UNDEFINED
    np.testing.assert_array_equal(undefined, [[False, False, True], [True] * 3, [True] * 3])
    for name in ("F", "z", "theta", "F_D", "F_lambda"):
        np.testing.assert_array_equal(np.isnan(found[name]), undefined)


def test_sleeping_top_lies_on_the_surface_when_it_is_stable():
    """L3 = Lz: theta = 0 is the infimum iff L3^2 >= 4 m g l I1*."""
    threshold = np.sqrt(
        4 * HEAVY["m"] * HEAVY["g"] * HEAVY["l"] * (HEAVY["I1"] + HEAVY["m"] * HEAVY["l"] ** 2)
    )
    for factor, status in ((0.9, Status.ATTAINED), (1.1, Status.AT_UPPER_END)):
        found = surface.minimal_surface(HEAVY_TOP, factor * threshold, factor * threshold)
        assert found.status.item() == status
        assert (found.theta.item() == 0) == (factor > 1)


# --- turning angles and periods -----------------------------------------------------------------


def test_rolling_top_swings_as_its_reference_run():
    """Reproduce reference case 6: a rolling tippe top integrated with 200 bits (section 14)."""
    found = turning.turning_angles(
        TOP,
        3.176113719312522795797e-4,
        1.770830502934459498575855e-6,
        1.810356427261974764621e-2,
    )
    assert found.theta_min.item() == pytest.approx(0.512263136142123, rel=2e-14)
    assert found.theta_max.item() == pytest.approx(1.0, rel=2e-14)
    assert found.period.item() == pytest.approx(0.080478798753980198, rel=1e-12)
    assert found.level.item() == Level.ABOVE


def test_heavy_top_swings_as_its_closed_form():
    """Reference case 7: 2 K(k)/W; cuspidal start at theta = 0.6, L3 = 0.01 (sections 8, 14)."""
    L3, z0 = 0.01, np.cos(0.6)
    E = L3**2 / 2 / HEAVY["I3"] + HEAVY["m"] * HEAVY["g"] * HEAVY["l"] * z0
    found = turning.turning_angles(HEAVY_TOP, L3, L3 * z0, E)
    assert found.theta_min.item() == pytest.approx(0.6, rel=1e-12)
    assert found.theta_max.item() == pytest.approx(0.7376469624934865, rel=1e-12)
    assert found.period.item() == pytest.approx(0.1786029610277087905, rel=1e-11)


def test_small_nutations_have_the_period_of_the_second_derivative():
    D, lam = 3e-4, 4e-6
    F = surface.minimal_surface(TOP, D, lam).F.item()
    found = turning.turning_angles(TOP, D, lam, F * (1 + np.array([1e-3, 1e-4, 1e-5])))
    away = np.abs(found.period / found.small_period - 1).values
    assert away[2] < 1e-5
    np.testing.assert_allclose(away[:-1] / away[1:], 10, rtol=0.05)  # the square of the amplitude


def test_turning_angles_are_where_the_potential_takes_the_energy():
    rng, b = np.random.default_rng(7), oracle.body(CANONICAL)
    D, lam = rng.uniform(-5e-4, 5e-4, 15), rng.uniform(1e-7, 7e-6, 15)
    F = np.array([surface.minimal_surface(TOP, x, y).F.item() for x, y in zip(D, lam, strict=True)])
    E = F * (1 + 10 ** rng.uniform(-10, 1, 15))
    found = turning.turning_angles(TOP, D, lam, E)
    assert (found.theta_min < found.theta_star).all()
    assert (found.theta_star < found.theta_max).all()
    for i in range(15):
        for name in ("theta_min", "theta_max"):
            V = oracle.potential(
                mp.cos(mp.mpf(found[name][i].item())), mp.mpf(D[i]), mp.mpf(lam[i]), b
            )
            slope = mp.diff(
                lambda t, i=i: oracle.potential(mp.cos(t), mp.mpf(D[i]), mp.mpf(lam[i]), b),
                found[name][i].item(),
            )
            assert abs(V - E[i]) <= 4e-16 * abs(slope) * np.pi + 1e-15 * E[i]


def test_levels_say_how_the_energy_lies():
    F = surface.minimal_surface(TOP, 3e-4, 4e-6).F.item()
    found = turning.turning_angles(TOP, 3e-4, 4e-6, [2 * F, F * (1 + 1e-13), 0.5 * F, np.nan])
    assert found.level.values.tolist() == [
        Level.ABOVE,
        Level.TOUCHING,
        Level.BELOW,
        Level.UNDEFINED,
    ]
    assert found.theta_min[1] == found.theta_max[1] == found.theta_star[1]
    np.testing.assert_array_equal(np.isnan(found.theta_min), [False, False, True, True])


# --- along a run --------------------------------------------------------------------------------


def test_band_of_an_inversion_holds_it_and_meets_its_turnings(inverting_run):
    from tippetop.landscape import run_landscape

    groups, attrs = inverting_run
    found, logged, _ = run_landscape.band(groups["trajectory"], groups["events"], attrs)
    theta = found.theta.values
    assert (
        theta >= found.theta_min.values - 1e-6
    ).all()  # the square root of the rounding of E~, at a touch
    assert (theta <= found.theta_max.values + 1e-6).all()
    assert logged.time.size > 300
    assert np.abs(logged.theta - logged.edge).max() < 2e-5
    assert np.median(np.abs(logged.theta - logged.edge)) < 1e-7


@pytest.fixture(scope="module")
def inverting_run():
    import tippetop

    run = tippetop.run("inverting", until=8)
    return run.datasets(), run.attributes


def test_band_of_a_rolling_top_stands_still():
    """In pure rolling D, lambda and E~ are constant, and theta swings from edge to edge."""
    import tippetop
    from tippetop.scenario import build

    tables = {
        "system": "rolling-tippe-top",
        "parameters": CANONICAL,
        "initial": {"theta": 1.0, "phi_dot": 20.0, "omega3": 60.0},
        "run": {"until": 0.5, "output_step": 0.001},
    }
    run = tippetop.run(build.problem(tables)).datasets()
    found = turning.band(top(CANONICAL, "rolling-tippe-top"), run["trajectory"])
    for name in ("theta_min", "theta_max", "period"):
        assert float(np.ptp(found[name].values)) < 1e-10
    turnings = run["events"].theta.values[run["events"].kind.values == 0]
    assert_near(np.sort(turnings)[:5], found.theta_min[0], 1e-12)
    assert_near(np.sort(turnings)[-5:], found.theta_max[0], 1e-12)
