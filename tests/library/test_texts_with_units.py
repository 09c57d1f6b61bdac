"""Numbers of the library's functions may be texts with units, and what is no number is refused in a sentence."""

import math

import numpy as np
import pytest

import tippetop as tt


def test_a_text_stands_for_its_number() -> None:
    """In modes, regimes, accelerations and nutation, as in scenarios."""
    spin = 1480 * 2 * math.pi / 60
    np.testing.assert_array_equal(
        tt.linear_modes("inverting", omega3="1480 rpm"), tt.linear_modes("inverting", omega3=spin)
    )
    assert tt.regime("inverting", "7 g m^3/s") == tt.regime("inverting", 7e-3)
    assert tt.asymptotic_states("inverting", "7e-6 kg m3 s-1") == tt.asymptotic_states("inverting", 7e-6)
    half = tt.accelerations("inverting", theta="30 deg", omega3="100 rad/s")
    assert half == pytest.approx(tt.accelerations("inverting", theta=math.radians(30), omega3=100.0), rel=1e-14)
    given = {"theta": 0.1, "D": 4e-4, "lam": 7e-6}
    assert tt.nutation("inverting", energy="100 mJ", **given) == tt.nutation("inverting", energy=0.1, **given)


def test_an_ensemble_varies_texts() -> None:
    """Beside numbers, in SI units."""
    mixed = tt.ensemble("inverting", {"omega3": ["1480 rpm", 150.0]}, until="10 ms")
    np.testing.assert_array_equal(mixed["initial.omega3"], [1480 * 2 * math.pi / 60, 150.0])
    np.testing.assert_array_equal(tt.ensemble("inverting", {"until": ["20 ms", 0.01]}).t_end, [0.02, 0.01])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: tt.linear_modes("inverting", omega3="3 kg"), "`omega3` must be in rad s-1 .*but is"),
        (lambda: tt.ensemble("inverting", {"omega3": ["3 kg"]}), "`omega3` must be in rad s-1 .*but is"),
        (lambda: tt.ensemble("inverting", {"omega3": [None]}), "`omega3` must be an array of numbers"),
        (lambda: tt.least_energy("inverting", "x", 1.0), "`theta` must be a number or an array of numbers"),
        (
            lambda: tt.least_energy("inverting", [1, 2], [1, 2, 3]),
            r"must have shapes that broadcast.*\(2,\) and \(3,\)",
        ),
        (lambda: tt.potential("inverting", ["a"], D=1e-4, lam=7e-6), "`z` must be a number or an array of numbers"),
        (lambda: tt.turning_angles("inverting", D="a", lam=7e-6, energy=1), "`D` must be a number or an array"),
        (
            lambda: tt.turning_angles("inverting", D=[1, 2], lam=7e-6, energy=[1, 2, 3]),
            "must have shapes that broadcast",
        ),
    ],
)
def test_what_is_no_number_is_refused(call, sentence: str) -> None:
    with pytest.raises(tt.InputError, match=sentence):
        call()
