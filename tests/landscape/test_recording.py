"""Test surfaces on disk: written by chunks, equal to those in memory; and commands."""

import numpy as np
import pandas
import pytest
import xarray as xr
from examples import CANONICAL
from typed import refused, reported, typed

from tippetop.landscape import surface, surface_recording
from tippetop.landscape.landscape_body import top
from tippetop.store import root
from tippetop_kernels import grid


TOP = top({**CANONICAL, "I1": 3.008e-6})
D, LAM = np.linspace(-6e-4, 8e-4, 37), np.linspace(0, 7e-6, 53)


@pytest.fixture
def place(tmp_path):
    return tmp_path / "F.zarr"


def test_store_is_the_surface(tmp_path, place):
    seen = []
    surface_recording.write(place, TOP, D, LAM, chunk=16, progress=lambda *a: seen.append(a))
    stored, exact = root.open_group(place, "surface"), surface.minimal_surface(TOP, D, LAM)
    for name in ("F", "z", "status", "D", "lambda"):
        np.testing.assert_array_equal(stored[name], exact[name])
    assert stored.F.dims == ("D", "lambda")
    assert stored.F.attrs["units"] == "J"
    assert seen == [(i, 12) for i in range(1, 13)]
    assert [p.name for p in tmp_path.iterdir()] == ["F.zarr"]


def test_surface_command(tmp_path, place):
    out, picture = place, tmp_path / "F.png"
    words = f"--D=-6e-4:8e-4:21 --lambda 0:7e-6:31 --out {out}"
    assert typed(f"surface inverting {words} --figure {picture}") == 0
    assert root.open_group(out, "surface").F.shape == (21, 31)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert typed(f"plot {out} --out {tmp_path}/again.png") == 0
    assert reported(f"info {out}")["content"] == "surface"
    assert typed(f"surface inverting {words}") == 5  # the store is there


def test_potential_command(tmp_path):
    out = tmp_path / "V.zarr"
    words = f"--D 3e-4 --lambda 4e-6 --n 101 --out {out} --figure {tmp_path}/V.svg"
    found = reported(f"potential inverting {words}")
    V = root.open_group(out, "potential").V
    assert V.sizes == {"z": 101}
    assert found["F"] <= V.min() <= found["F"] * 1.001
    assert found["status"] == "attained"
    assert typed(f"plot {out} --out {tmp_path}/again.png") == 0
    assert isinstance(V, xr.DataArray)


def test_an_interrupted_command_leaves_nothing(tmp_path, monkeypatch):
    def stop(*a):
        raise KeyboardInterrupt

    monkeypatch.setattr(surface_recording.surface, "minima", stop)
    axes = "--D=-6e-4:8e-4:21 --lambda 0:7e-6:31"
    assert "nothing more was stored" in refused(
        f"surface inverting {axes} --out {tmp_path}/F.zarr", 130
    )
    assert list(tmp_path.iterdir()) == []


def test_the_command_computes_on_as_many_threads_as_are_asked_for(tmp_path, monkeypatch):
    asked, usual = [], grid.on_threads
    monkeypatch.setattr(
        grid,
        "on_threads",
        lambda work, n, threads: (asked.append(threads), usual(work, n, threads)),
    )
    axes = "--D -1e-4:1e-4:3 --lambda 0:1e-5:3"
    words = f"--out {tmp_path}/F.zarr --figure {tmp_path}/F.png --threads 1"
    assert typed(f"surface inverting {axes} {words}") == 0
    assert set(asked) == {1}


def test_an_exported_table_of_a_surface_has_its_axes(place, tmp_path):
    surface_recording.write(place, TOP, D, LAM, chunk=16)
    out = tmp_path / "F.csv"
    assert typed(f"export {place} --to csv --out {out}") == 0
    table = pandas.read_csv(out)
    stored = root.open_group(place, "surface")
    np.testing.assert_array_equal(table["F [J]"], stored.F.values.ravel())
    np.testing.assert_array_equal(table["D [kg m2 s-1]"], np.repeat(D, len(LAM)))
    np.testing.assert_array_equal(table["lambda [kg m3 s-1]"], np.tile(LAM, len(D)))
