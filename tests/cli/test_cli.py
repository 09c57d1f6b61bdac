"""The command line as people and programs use it: exit codes, JSON, one sentence per fault, nothing
half-written.
"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr


def test_run_writes_the_store_of_the_contract(inversion: Path) -> None:
    trajectory = xr.open_zarr(inversion, group="trajectory", consolidated=False)
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
    events = xr.open_zarr(inversion, group="events", consolidated=False)
    names = "time kind theta theta_dot_sign amplitude significant"
    assert set(events.variables) >= set(names.split())
    assert events["kind"].attrs["flag_meanings"].split()[:3] == ["turning", "liftoff", "equator"]
    root = xr.open_zarr(inversion).attrs
    names = "status parameters friction initial tolerance precision versions cpu"
    assert set(names.split()) <= set(root)
    assert root["format_version"] == 2


def test_info_is_one_json_object_with_the_keys_of_the_contract(
    inversion: Path, said: Callable
) -> None:
    info = json.loads(said(f"info {inversion} --json")[0])
    keys = "status t_end steps event_counts inversion nutational_band drift normal_force versions"
    assert set(keys.split()) <= set(info)
    assert set(info["inversion"]) == {"first_equator", "last_equator", "inverted_at"}
    assert info["inversion"]["first_equator"] == pytest.approx(5.879749518045799, abs=1e-12)
    assert info["inversion"]["inverted_at"] == pytest.approx(6.943847616774212, abs=1e-12)
    assert set(info["drift"]) >= {"jellett", "energy_balance", "axis_norm"}


def test_run_json_equals_info_json(tmp_path: Path, said: Callable) -> None:
    path = str(tmp_path / "a.zarr")
    out = said(f"run inverting --until 1 --json --out {path}")[0]
    assert json.loads(out) == json.loads(said(f"info {path} --json")[0])


def test_a_run_without_a_store_says_that_it_has_no_orientation(said: Callable) -> None:
    """Nobody could read it; what is printed is what was integrated."""
    found = json.loads(said("run inverting --until 0.1 --json")[0])
    assert found["run"]["orientation"] is False
    assert found["t_end"] == 0.1
