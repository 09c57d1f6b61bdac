"""Where tumbling states exist, the least Jellett integral of one, and the curves of all asymptotic
states.
"""

import itertools
import math

import numpy as np
import pytest
from examples import GLIDING, with_gamma

from tippetop.mechanics.theory import regimes, thresholds, tumbling
from tippetop.mechanics.theory.least_energy import asymptotic_states


GAMMAS = (0.6, 0.72, 0.8, 0.936, 1.2, 1.5)
"""alpha is 0.3: below 0.7 tumbling states end before the upright pole, above 1.3 before the
inverted one.
"""
every_gamma = pytest.mark.parametrize("gamma", GAMMAS)


@every_gamma
def test_tumbling_states_exist_between_their_limits_and_nowhere_else(gamma: float) -> None:
    b, (low, high) = with_gamma(gamma), tumbling.tumbling_limits(with_gamma(gamma))
    assert np.isfinite(tumbling.tumbling(np.array([low + 1e-9, high - 1e-9]), b)).all()
    beyond = np.array([z for z in (low - 1e-9, high + 1e-9) if -1 <= z <= 1])
    assert np.isnan(tumbling.tumbling(beyond, b)).all()
    assert len(beyond) == (gamma < 0.7 or gamma > 1.3)


def test_the_least_lambda_of_a_tumbling_state_is_that_of_a_dense_scan_of_each_body() -> None:
    some = [with_gamma(gamma) for gamma in (0.75, 0.8, 0.936, 1.2)]
    together = GLIDING._replace(I1=np.array([b.I1 for b in some]))
    found = tumbling.lambda_t(together)
    for b, least in zip(some, found.tolist(), strict=True):
        exact = tumbling.tumbling_jellett(np.linspace(-1, 1, 200_001), b).min()
        assert least == pytest.approx(exact, rel=1e-5)
        assert tumbling.lambda_t(b) == least
    upright = np.array([thresholds.lambda_u(b) for b in some])
    assert (found < (1 - 1e-9) * upright).tolist() == [
        True,
        True,
        False,
        False,
    ]  # below gamma_plus, which is 0.84


@every_gamma
def test_curves_of_tumbling_states_join_and_are_as_stable_as_the_regime_says(gamma: float) -> None:
    b, most = with_gamma(gamma), 1e-5
    made = [branch for branch in tumbling.branches(b, most) if branch.kind == "tumbling"]
    low, high = tumbling.tumbling_limits(b)
    assert (made[0].z[0], made[-1].z[-1]) == pytest.approx((low, high), abs=1e-5)
    assert made[0].z[0] > low
    for before, after in itertools.pairwise(made):
        assert before.z[-1] == after.z[0]
        assert before.stable is not after.stable
    for branch in made:
        assert (np.diff(branch.z) > 0).all()
        assert np.diff(branch.z).max() < 2e-3
        for z, lam in list(zip(branch.z, branch.lam, strict=True))[5:-5:100]:
            found = regimes.regime(float(lam), b)
            states = found.tumbling if branch.stable else found.unstable
            assert min(abs(math.cos(theta) - z) for theta in states) < 1e-6
    for pole, limit in (
        (-1.0, thresholds.lambda_s(b)),
        (1.0, thresholds.lambda_u(b)),
    ):  # spins lose them there
        if math.isfinite(limit):
            assert tumbling.tumbling_jellett(pole, b) == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("lam", [1e3, 1e300])
def test_beyond_every_tumbling_state_there_is_none(lam: float) -> None:
    """Roots at infinity were found at the equator, and a square overflowed."""
    assert regimes.regime(lam, GLIDING).tumbling == ()
    if lam < 1e150:
        assert [state.kind for state in asymptotic_states(lam, GLIDING)] == ["upright", "inverted"]
