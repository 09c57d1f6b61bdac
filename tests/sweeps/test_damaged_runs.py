"""The folder of single runs in a sweep is looked at before the sweep is continued."""

import shutil
from pathlib import Path

import pytest
from stores import assert_same

import tippetop
from tippetop.errors import StoreError
from tippetop.store.root import RUNS


def test_a_group_of_runs_whose_document_is_damaged_is_described_again(
    file: Path, whole: Path, tmp_path: Path
) -> None:
    store = shutil.copytree(whole, tmp_path / "S.zarr")
    (store / RUNS / "zarr.json").write_bytes(b"\x02\x01\x33\x08 no metadata")
    with pytest.raises(StoreError, match=RUNS):
        tippetop.open(store)
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_a_run_of_another_top_is_not_taken_for_one_of_the_plan(
    file: Path, whole: Path, tmp_path: Path
) -> None:
    """Exchanged, or continued to another end: each is sound, and not what the plan makes.

    It is made again, as a folder that is gone.
    """
    store = shutil.copytree(whole, tmp_path / "S.zarr")
    with pytest.raises(StoreError, match="must lie outside of every store"):
        tippetop.resume(store / RUNS / "5", until=1.0)
    shutil.rmtree(store / RUNS / "5")
    tippetop.run("inverting", until=0.5, out=tmp_path / "other.zarr")
    shutil.copytree(tmp_path / "other.zarr", store / RUNS / "5")
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)
    shutil.rmtree(store / RUNS)
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)
