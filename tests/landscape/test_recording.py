"""Test surfaces on disk: written by chunks, resumable, equal to those in memory; and commands."""

import json
import re

import numpy as np
import pandas
import pytest
import xarray as xr
from examples import CANONICAL
from stores import assert_same, exchange
from typed import typed

from tippetop import errors
from tippetop.landscape import surface, surface_recording
from tippetop.landscape.surface_recording import Surface
from tippetop.store import root
from tippetop_kernels import grid


PARAMETERS = {**CANONICAL, "I1": 3.008e-6}
D, LAM = np.linspace(-6e-4, 8e-4, 37), np.linspace(0, 7e-6, 53)
SURFACE = Surface(PARAMETERS, D, LAM, chunk=16)


@pytest.fixture
def place(tmp_path):
    return tmp_path / "F.zarr"


def test_store_is_the_surface(tmp_path, place):
    seen = []
    path = surface_recording.write(
        place,
        SURFACE,
        progress=lambda *a: seen.append(a),
    )
    stored, exact = root.open_group(path, "surface"), surface.minimal_surface(PARAMETERS, D, LAM)
    for name in ("F", "z", "status", "D", "lambda"):
        np.testing.assert_array_equal(stored[name], exact[name])
    assert stored.F.dims == ("D", "lambda")
    assert stored.F.attrs["units"] == "J"
    assert seen == [(i, 12) for i in range(1, 13)]
    assert [p.name for p in tmp_path.iterdir()] == ["F.zarr"]


class Stop(Exception):
    """The power fails."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The store of the surface, which nothing has disturbed."""
    return surface_recording.write(tmp_path_factory.mktemp("whole") / "F.zarr", SURFACE)


def stopped(path, after):
    """Writing stops after some chunks."""

    def stop(done, of):
        if done == after:
            raise Stop

    with pytest.raises(Stop):
        surface_recording.write(path, SURFACE, progress=stop)
    assert root.attributes(path)["status"] == "running"


def test_interrupted_store_goes_on(whole, place, monkeypatch):
    stopped(place, after=5)
    worked = []
    minima = surface.minima
    monkeypatch.setattr(
        surface_recording.surface,
        "minima",
        lambda *a: (a[1].size > 2 and worked.append(1)) or minima(*a),
    )
    surface_recording.write(place, SURFACE)
    assert len(worked) == 7
    assert_same(place, whole)


def test_an_unfinished_surface_is_described_without_digests(place, capsys):
    stopped(place, after=1)
    assert typed(f"info {place}") == 0
    assert not re.search("[0-9a-f]{12}", capsys.readouterr().out)


def test_another_surface_does_not_go_on(place):
    stopped(place, after=1)
    with pytest.raises(errors.StoreError, match="must have the same axes to be continued"):
        surface_recording.write(place, Surface(PARAMETERS, D, LAM * 2, chunk=16))


def test_surface_command(tmp_path, place, capsys):
    out, picture = place, tmp_path / "F.png"
    words = f"--D=-6e-4:8e-4:21 --lambda 0:7e-6:31 --out {out}"
    assert typed(f"surface inverting {words} --figure {picture}") == 0
    assert root.open_group(out, "surface").F.shape == (21, 31)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert typed(f"plot {out} --out {tmp_path}/again.png") == 0
    capsys.readouterr()
    assert typed(f"info {out} --json") == 0
    assert json.loads(capsys.readouterr().out)["content"] == "surface"
    assert typed(f"surface inverting {words} --figure {picture}") == 5  # the picture is there
    assert f"`{picture}` must not exist yet, but does: use --overwrite" in capsys.readouterr().err
    assert typed(f"surface inverting {words}") == 0
    assert "was finished: its chunks are checked" in "".join(capsys.readouterr())


def test_potential_command(tmp_path, capsys):
    out = tmp_path / "V.zarr"
    words = f"--D 3e-4 --lambda 4e-6 --n 101 --out {out} --figure {tmp_path}/V.svg"
    assert typed(f"potential inverting {words} --json") == 0
    found = json.loads(capsys.readouterr().out)
    V = root.open_group(out, "potential").V
    assert V.sizes == {"z": 101}
    assert found["F"] <= V.min() <= found["F"] * 1.001
    assert found["status"] == "attained"
    assert typed(f"plot {out} --out {tmp_path}/again.png") == 0
    assert isinstance(V, xr.DataArray)


def test_interrupted_command_says_how_to_go_on(tmp_path, capsys, monkeypatch):
    calls = []

    def stop(*a):
        calls.append(1)
        raise KeyboardInterrupt

    axes = "--D=-6e-4:8e-4:21 --lambda 0:7e-6:31"
    words = f"surface inverting {axes} --out {tmp_path}/F.zarr"
    with monkeypatch.context() as patched:
        patched.setattr(surface_recording.surface, "minima", stop)
        assert typed(words) == 130
    assert "the same command without --overwrite continues" in capsys.readouterr().err
    assert calls
    assert typed(words) == 0


DAMAGES = {
    "deleted": lambda part: (part / "surface/F/c.0.0").unlink(),
    "empty": lambda part: (part / "surface/z/c.0.1").write_bytes(b""),
    "status": lambda part: (part / "surface/status/c.0.0").write_bytes(b"x"),
    "exchanged": lambda part: exchange(part / "surface/F/c.0.0", part / "surface/F/c.0.1"),
    "metadata": lambda part: edit(part / "surface/F/zarr.json", '"J"', '"eV"'),
    "group": lambda part: (part / "surface/zarr.json").write_text("{}"),
    "root": lambda part: edit(part / "zarr.json", "minimal surface", "maximal surface"),
}


def edit(place, old, new):
    text = place.read_text()
    assert old in text
    place.write_text(text.replace(old, new))


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_unfinished_surface_ends_in_the_same_bits(damage, whole, place):
    """Before, it was finished as it was, with exit code 0, or with a traceback."""
    stopped(place, after=5)
    DAMAGES[damage](place)
    surface_recording.write(place, SURFACE)
    assert_same(place, whole)


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


def test_an_exported_table_of_a_surface_has_its_axes(whole, tmp_path):
    out = tmp_path / "F.csv"
    assert typed(f"export {whole} --to csv --out {out}") == 0
    table = pandas.read_csv(out)
    stored = root.open_group(whole, "surface")
    np.testing.assert_array_equal(table["F [J]"], stored.F.values.ravel())
    np.testing.assert_array_equal(table["D [kg m2 s-1]"], np.repeat(D, len(LAM)))
    np.testing.assert_array_equal(table["lambda [kg m3 s-1]"], np.tile(LAM, len(D)))
