"""Thresholds, tumbling states, linear modes and regimes."""

import dataclasses
import math

import examples
import numpy as np
import pytest
from examples import GLIDING, with_gamma

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import gliding
from tippetop.mechanics.friction import Coulomb, Viscous
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.theory import modes, regimes, thresholds, tumbling
from tippetop.problem import Problem
from tippetop.runs import forecast
from tippetop.runs.run import solve


TIP = contact.Touch(0.1, 0.0, -0.04, 8e-5, 5e-5, 9.82, Viscous(0.3))


def test_published_thresholds() -> None:
    """Canonical top: Friedl (1997), Leine and Glocker (2003), the source."""
    found = {name: t.value for name, t in thresholds.thresholds(GLIDING).items()}
    assert found["lambda_u"] == pytest.approx(1.23952e-6, rel=1e-5)
    assert found["lambda_de"] == pytest.approx(2.04048e-6, rel=1e-5)
    assert found["lambda_s"] == pytest.approx(3.43887972e-6, rel=1e-8)
    assert found["spin_upright"] == pytest.approx(27.6679170948, rel=1e-11)
    assert found["spin_inverted"] == pytest.approx(41.3326889577, rel=1e-11)
    assert found["spin_full"] == pytest.approx(76.7607080642, rel=1e-11)
    assert found["gamma_c"] == pytest.approx(0.7465, abs=5e-5)
    assert found["gamma_plus"] == pytest.approx(0.84, abs=1e-12)


def test_published_linear_modes() -> None:
    expected = [
        1.206845166719 + 168.048551617954j,
        -0.161265295486 - 0.847112112075j,
        -7.848366130776 - 1.552584544047j,
    ]
    np.testing.assert_allclose(modes.linear_modes(155.0, GLIDING), expected, rtol=1e-11)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("gamma", [0.72, 0.8, 0.936, 1.2])
def test_modes_change_sign_at_the_thresholds(gamma: float, inverted: bool) -> None:
    """Linear modes and Theorem 3.3.2 agree, for any friction coefficient."""
    b = with_gamma(gamma)
    limit = thresholds.lambda_s(b) if inverted else thresholds.lambda_u(b)
    for mu in (0.01, 0.3, 3.0):
        for factor in (0.99, 1.01):
            spin = thresholds.spin_of(factor * limit, b, inverted=inverted)
            growth = modes.linear_modes(spin, b._replace(friction=Viscous(mu)), inverted=inverted)[
                0
            ].real
            assert (growth < 0) == ((factor > 1) == inverted)


# --- tumbling -----------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [0.6, 0.72, 0.936, 1.2, 1.5])
def test_tumbling_states_are_steady(gamma: float) -> None:
    """All rates of the Euler form but phi' vanish; lambda is that of the formula; the quartic finds
    the state again.
    """
    b = with_gamma(gamma)
    low, high = tumbling.tumbling_limits(b)
    for z in np.linspace(low, high, 9)[1:-1]:
        phi_dot, omega3 = tumbling.tumbling(z, b)
        e = gliding.EulerState(math.acos(z), 0.0, phi_dot, omega3, 0, 0)
        rates = gliding.euler_rates(e, b)
        assert abs(rates.theta_dot) + abs(rates.phi_dot) + abs(rates.omega3) < 1e-9 * phi_dot**2
        assert abs(rates.nu_x) + abs(rates.nu_y) < 1e-10
        normal_force = contact.g_n(gliding.euler_scalars(e, b), b)
        assert normal_force == pytest.approx(b.m * b.g, rel=1e-12)
        lam = float(contact.jellett(gliding.euler_scalars(e, b), b))
        assert tumbling.tumbling_jellett(z, b) == pytest.approx(lam, rel=1e-12)
        assert np.abs(tumbling.tumbling_states(lam, b) - z).min() < 1e-6


def test_regimes_follow_gamma() -> None:
    """Bistability below gamma_+, two stable spins below gamma_c, as the corrected theorem says."""
    b = with_gamma(0.936)
    assert (
        regimes.regime(0.5 * thresholds.lambda_u(b), b).sentence()
        == "only the upright spin is stable"
    )
    between = regimes.regime(0.5 * (thresholds.lambda_u(b) + thresholds.lambda_s(b)), b)
    assert not between.upright
    assert not between.inverted
    assert len(between.tumbling) == 1
    assert (
        regimes.regime(1.1 * thresholds.lambda_s(b), b).sentence()
        == "only the inverted spin is stable"
    )
    b = with_gamma(0.8)  # gamma_c < 0.8 < gamma_+: a fold, tumbling states near z = 1 are unstable
    folded = regimes.regime(0.97 * thresholds.lambda_u(b), b)
    assert folded.upright
    assert len(folded.tumbling) == 1
    assert len(folded.unstable) == 1
    b = with_gamma(0.72)  # below gamma_c: lambda_s < lambda_u
    assert thresholds.lambda_s(b) < thresholds.lambda_u(b)
    both = regimes.regime(0.5 * (thresholds.lambda_u(b) + thresholds.lambda_s(b)), b)
    assert both.upright
    assert both.inverted
    assert "both stable" in both.sentence()
    assert thresholds.lambda_u(with_gamma(0.6)) == math.inf
    assert thresholds.lambda_s(with_gamma(1.4)) == math.inf


# --- heavy tops ---------------------------------------------------------------------------------


def test_sleeping_top_with_a_fixed_tip() -> None:
    """Stable above 2 sqrt(m g l I1*)/I3 [T 5.54]."""
    limit = thresholds.sleeping_spin(TIP)
    assert modes.rolling_modes(0.99 * limit, TIP)[0].real > 0
    assert abs(modes.rolling_modes(1.01 * limit, TIP)[0].real) < 1e-6


def start_of(
    name: str, theta: float = 0.1, law: tuple = ("viscous", {"mu": 0.3}), **more: float
) -> Problem:
    """A start of a system with its usual numbers."""
    usual = SYSTEMS[name].initial
    initial = {"theta": theta, **{key: value for key, value in more.items() if key in usual}}
    return examples.problem(name, examples.numbers_of(name), initial, 1.0, law)


def test_every_system_of_ours_has_an_outlook() -> None:
    for name in SYSTEMS:
        assert forecast.assessment(start_of(name, theta_dot=1.0))["regime"]
    canonical = forecast.assessment(start_of("tippe-top", omega3=155.0))
    assert canonical["fate"] == "ends in the inverted spin, unless it lifts off"


@pytest.mark.parametrize("name", SYSTEMS)
def test_nothing_is_said_of_a_system_that_brings_no_theory(name: str) -> None:
    """No threshold, no regime, no fate: knowledge comes with the record, not with a name."""
    made = start_of(name)
    known = dict.fromkeys(("outlook", "motion", "borders", "landscape"))
    toy = dataclasses.replace(made.system, inverts=False, **known)
    made = dataclasses.replace(made, system=toy, until=1e6)
    assert set(forecast.assessment(made)) - {"contact_point"} == {"at_start", "expected"}
    assert forecast.comments(made) == {}


NO_FRICTION = [
    ("none", {}),
    ("viscous", {"mu": 0.0}),
    ("coulomb", {"mu": 0.0, "eps": 1e-3}),
    ("mixed", {"mu": 0.0, "mu_coulomb": 0.0, "eps": 1e-3}),
    ("stribeck", {"mu": 0.0, "mu_static": 0.0, "v_s": 0.1, "eps": 1e-3}),
    ("latitude", {"mu": 0.0, "mu_stem": 0.0}),
]


@pytest.mark.parametrize("law", NO_FRICTION, ids=lambda law: law[0])
def test_mu_zero_is_no_friction_under_any_law(law: tuple) -> None:
    tippe = forecast.assessment(start_of("tippe-top", law=law, omega3=155.0))
    assert tippe["fate"] == "theta nutates for ever, unless it lifts off"
    assert tippe["regime"] == "no friction: nothing is lost, and no state attracts"
    heavy = forecast.assessment(start_of("gliding-heavy-top", law=law, omega3=155.0))
    assert heavy["regime"].startswith("without friction the upright spin is ")
    assert "fate" not in heavy


@pytest.mark.parametrize("name", ["gliding-cylinder", "rolling-cylinder"])
def test_a_cylinder_rocks_at_the_frequency_that_is_named(name: str) -> None:
    """Against a run: it turns every half period; without friction its centre of mass stays above
    one place.
    """
    made = start_of(name, 1e-4, ("none", {}))
    named = float(forecast.assessment(made)["regime"].split()[-2])
    made = dataclasses.replace(made, until=20 * math.pi / named)
    np.testing.assert_allclose(
        np.diff(solve(made).events.of("turning").time), math.pi / named, rtol=1e-5
    )


def test_modes_beyond_the_doubles_are_nan_and_the_outlook_says_no_rate() -> None:
    """A Coulomb law with eps = 5e-324. Before, a traceback of the eigenvalues."""
    law = Coulomb(mu=0.3, eps=5e-324)
    assert np.isnan(modes.linear_modes(155.0, GLIDING._replace(friction=law))).all()
    assert not modes.is_unstable(155.0, GLIDING._replace(friction=law))
    with np.errstate(all="ignore"):
        made = start_of("gliding-heavy-top", law=("coulomb", {"mu": 0.3, "eps": 5e-324}))
        regime = forecast.assessment(made)["regime"]
    assert regime.startswith("upright spin unstable at every speed: the top")
