"""Numbers of the library's functions may be texts with units, and what is no number is refused in a
sentence.
"""

import math
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt


def test_a_text_stands_for_its_number() -> None:
    """In modes and regimes, as in scenarios."""
    spin = 1480 * 2 * math.pi / 60
    np.testing.assert_array_equal(
        tt.theory.linear_modes("inverting", omega3="1480 rpm"),
        tt.theory.linear_modes("inverting", omega3=spin),
    )
    assert tt.theory.regime("inverting", "7 g m^3/s") == tt.theory.regime("inverting", 7e-3)
    assert tt.theory.asymptotic_states(
        "inverting", "7e-6 kg m3 s-1"
    ) == tt.theory.asymptotic_states("inverting", 7e-6)


def test_landscapes_rows_and_replays_take_texts_too(tmp_path: Path) -> None:
    text, number = (
        tt.landscapes.potential("inverting", 0.5, D=D, lam=lam).V.item()
        for D, lam in (("0.3 g m^2/s", ["4e-6 kg m3 s-1"]), (3e-4, 4e-6))
    )
    assert text == number
    assert tt.theory.least_energy("inverting", "30 deg", 4e-6) == pytest.approx(
        tt.theory.least_energy("inverting", math.radians(30), "4e-6 kg m3 s-1"), rel=1e-14
    )
    run = tt.run("inverting", until="10 ms", output="keyframes", out=tmp_path / "run.zarr")
    assert run.replay("0 s", "10 ms", "5 ms").time.values.tolist() == [0.0, 0.005, 0.01]
    rows = tt.run("inverting", until="10 ms", output_times=["1 ms", 0.002, 0.003])
    assert rows.trajectory.time.values.tolist() == [0.001, 0.002, 0.003]
    (line, *_) = rows.plot("theta", start="1.5 ms", until="3 ms").axes[0].lines
    assert line.get_xdata().tolist() == [0.002, 0.003]
    assert tt.load("inverting", until="20 ms").until == 0.02


def test_an_ensemble_varies_texts() -> None:
    """Beside numbers, in SI units."""
    mixed = tt.ensemble("inverting", {"omega3": ["1480 rpm", 150.0]}, until="10 ms")
    np.testing.assert_array_equal(mixed["initial.omega3"], [1480 * 2 * math.pi / 60, 150.0])
    np.testing.assert_array_equal(
        tt.ensemble("inverting", {"until": ["20 ms", 0.01]}).t_end, [0.02, 0.01]
    )
