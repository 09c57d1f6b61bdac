"""The command line as people and programs use it: exit codes, JSON, one sentence per fault, nothing
half-written.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from tippetop.cli import outcome


def said(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> tuple[str, str]:
    assert outcome(arguments) == code
    return capsys.readouterr()


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stores") / "run.zarr"
    assert outcome(["run", "inverting", "--until", "7", "--out", str(path), "--json"]) == 0
    return path


def test_run_writes_the_store_of_the_contract(store: Path) -> None:
    trajectory = xr.open_zarr(store, group="trajectory", consolidated=False)
    names = (
        "theta theta_dot phi phi_dot omega3 nu_x nu_y axis L x y jellett routh energy "
        "modified_energy normal_force"
    )
    for name in names.split():
        assert trajectory[name].attrs["units"], name
        assert trajectory[name].attrs["long_name"], name
        assert np.all(np.isfinite(trajectory[name])), name
    assert trajectory["axis"].dims == ("time", "xyz")
    assert trajectory.sizes["time"] == 7001
    events = xr.open_zarr(store, group="events", consolidated=False)
    assert set(events.variables) >= {
        "time",
        "kind",
        "theta",
        "theta_dot_sign",
        "amplitude",
        "significant",
    }
    assert events["kind"].attrs["flag_meanings"].split()[:3] == ["turning", "liftoff", "equator"]
    root = xr.open_zarr(store).attrs
    assert {
        "status",
        "parameters",
        "friction",
        "initial",
        "tolerance",
        "precision",
        "versions",
        "cpu",
    } <= set(root)
    assert root["format_version"] == 2


def test_info_is_one_json_object_with_the_keys_of_the_contract(
    store: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    info = json.loads(said(capsys, "info", str(store), "--json")[0])
    keys = "status t_end steps event_counts inversion nutational_band drift normal_force versions"
    assert set(keys.split()) <= set(info)
    assert set(info["inversion"]) == {"first_equator", "last_equator", "inverted_at"}
    assert info["inversion"]["first_equator"] == pytest.approx(5.879749518045799, abs=1e-12)
    assert info["inversion"]["inverted_at"] == pytest.approx(6.943847616774212, abs=1e-12)
    assert set(info["drift"]) >= {"jellett", "energy_balance", "axis_norm"}


def test_run_json_equals_info_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "a.zarr")
    out = said(capsys, "run", "inverting", "--until", "1", "--json", "--out", path)[0]
    assert json.loads(out) == json.loads(said(capsys, "info", path, "--json")[0])


def test_a_run_without_a_store_says_that_it_has_no_orientation(capsys) -> None:
    """Nobody could read it; what is printed is what was integrated."""
    found = json.loads(said(capsys, "run", "inverting", "--until", "0.1", "--json")[0])
    assert found["run"]["orientation"] is False
    assert found["t_end"] == 0.1


def test_an_existing_store_is_refused_and_overwritten_only_when_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.zarr"
    arguments = ["run", "inverting", "--until", "0.1", "--out", str(path)]
    said(capsys, *arguments)
    assert "must not exist yet" in said(capsys, *arguments, code=5)[1]
    said(capsys, *arguments, "--overwrite")
    other = tmp_path / "mine"
    other.mkdir()
    (other / "precious").write_text("x")
    arguments = ["run", "inverting", "--until", "0.1", "--out", str(other), "--overwrite"]
    assert "must be a store of tippetop" in said(capsys, *arguments, code=5)[1]
    assert (other / "precious").exists()


def test_a_place_that_cannot_be_written_is_said_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file" / "a.zarr", tmp_path / "nowhere" / "a.zarr"):
        err = said(capsys, "run", "inverting", "--out", str(place), code=5)[1]
        assert err.count("\n") == 1
        assert "must be writable" in err


def test_physics_that_stops_a_run_exits_with_3_and_keeps_the_store(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "stiff.zarr"
    sets = ["--set", "friction.mu=1e12", "--set", "initial.theta=0.0", "--set", "initial.nu_y=0.1"]
    assert "too stiff" in said(capsys, "run", "inverting", *sets, "--out", str(path), code=3)[1]
    assert json.loads(said(capsys, "info", str(path), "--json")[0])["status"] == "stalled"
