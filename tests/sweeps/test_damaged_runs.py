"""The folder of single runs in a sweep is looked at before the sweep is continued."""

import shutil
from pathlib import Path

import pytest

from tippetop.errors import StoreError
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.store import RUNS, _there


def test_a_sweep_whose_runs_are_no_group_is_not_continued(file: Path, whole: Path, tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    shutil.copytree(whole, store)
    plan = Plan.from_toml(file)
    (store / RUNS).mkdir(exist_ok=True)
    (store / RUNS / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    assert _there(store, plan) == store
    (store / RUNS / "zarr.json").write_bytes(b"\x02\x01\x33\x08 no metadata")
    with pytest.raises(StoreError, match=RUNS):
        _there(store, plan)
