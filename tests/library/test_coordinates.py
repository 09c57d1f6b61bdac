"""Coordinates and shapes: labels of components, and what a number gives."""

import numpy as np
import pytest
from examples import CANONICAL

import tippetop as tt


TOP = tt.TippeTop(**CANONICAL)


def test_components_and_kinds_have_labels() -> None:
    """Those of a stored run are identical: see the runs that are saved in test_public.py."""
    run = tt.run("inverting", until=0.1)
    assert list(run.trajectory["xyz"].values) == ["x", "y", "z"]
    assert list(run.trajectory["wxyz"].values) == ["w", "x", "y", "z"]
    assert float(run.trajectory["axis"].sel(xyz="z")[0]) == pytest.approx(np.cos(0.1))
    assert "turning" in run.events.coords["kind"].attrs["flag_meanings"]


def test_a_number_gives_no_dimension() -> None:
    for number in (3e-4, np.float64(3e-4)):
        assert tt.landscapes.minimal_surface(TOP, D=number, lam=4e-6)["F"].dims == ()
        assert tt.landscapes.potential(TOP, 0.3, D=number, lam=4e-6)["V"].dims == ()
        assert (
            tt.landscapes.turning_angles(TOP, D=number, lam=4e-6, energy=0.05)["theta_min"].dims
            == ()
        )
    assert tt.landscapes.minimal_surface(TOP, D=[3e-4], lam=4e-6)["F"].dims == ("D",)
    assert tt.landscapes.potential(TOP, [0.3], D=[3e-4], lam=4e-6)["V"].dims == ("z", "D")
