"""Coordinates and shapes: the same in memory and on disk, and what a number gives."""

import numpy as np
import pytest
from examples import CANONICAL

import tippetop as tt


TOP = tt.TippeTop(**CANONICAL)


def test_coordinates_are_those_of_memory_when_reopened(tmp_path) -> None:
    run = tt.run("inverting", until=0.5)
    run.save(tmp_path / "a.zarr")
    stored = tt.open(tmp_path / "a.zarr")
    for name in ("trajectory", "events"):
        here, there = getattr(run, name), getattr(stored, name)
        assert set(here.coords) == set(there.coords)
        assert here.drop_attrs().equals(there.load().drop_attrs())
    assert list(stored.trajectory["xyz"].values) == ["x", "y", "z"]
    assert list(stored.trajectory["wxyz"].values) == ["w", "x", "y", "z"]
    assert float(run.trajectory["axis"].sel(xyz="z")[0]) == pytest.approx(np.cos(0.1))
    assert "turning" in stored.events.coords["kind"].attrs["flag_meanings"]
    assert "time" in stored.events.coords


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
