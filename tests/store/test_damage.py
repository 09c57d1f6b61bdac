"""A store that was damaged, or that no release writes, is refused with a sentence."""

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
import zarr
from stores import edited, flip, forge
from typed import typed

import tippetop
from tippetop.errors import StoreError
from tippetop.store import root


def test_nothing_warns_of_a_whole_store_and_its_datasets_are_bare_of_what_only_we_need(
    short_run: Path,
) -> None:
    """zarr warns of every file that is no member of a hierarchy; a warning fails a test."""
    whole = xr.open_datatree(short_run, engine="zarr")
    assert set(whole.children) == {"trajectory", "events"}
    assert xr.open_zarr(short_run).attrs == whole.attrs
    assert len(list(zarr.open_group(short_run, mode="r").members(max_depth=None))) > 20
    run = tippetop.open(short_run)
    for attrs in (run.attributes, run.trajectory.attrs, root.open_group(short_run, "events").attrs):
        assert "end" not in attrs
        assert attrs["status"] == "finished"


@pytest.fixture
def store(short_run: Path, tmp_path: Path) -> Path:
    return shutil.copytree(short_run, tmp_path / "run.zarr")


def test_a_changed_byte_of_a_chunk_is_found_when_its_numbers_are_read(
    store: Path, tmp_path: Path
) -> None:
    """A lazy Dataset raises what zarr raises; a command names the column."""
    flip(store / "trajectory/theta/c.0", 30)
    table = tippetop.open(store).trajectory
    with pytest.raises(ValueError, match="checksum"):
        table["theta"].values  # noqa: B018
    with pytest.raises(StoreError, match="readable column `theta`"):
        root.loaded(table, store)
    assert typed(f"export {store} --to csv --out {tmp_path}/a.csv") == 5


def of_theta(edit: Callable[[dict[str, Any]], Any]) -> Callable[[list[dict[str, Any]]], Any]:
    return lambda records: edit(records[0]["members"]["trajectory/theta"])


FORGED: dict[str, Callable[[list[dict[str, Any]]], Any]] = {
    "no attributes": lambda r: r[0].pop("attributes"),
    "a shape of another kind": of_theta(lambda d: d.update(shape=3)),
    "rows of another table": lambda r: r[1].update(rows={"other": 3}),
    "more rows than chunks": lambda r: r[1]["rows"].update(trajectory=10**15),
    "a path outside": lambda r: r[0]["tables"]["trajectory"].append("../x"),
}


@pytest.mark.parametrize("forged", FORGED)
def test_a_ledger_that_cannot_be_ours_is_refused(forged: str, store: Path) -> None:
    """Its digests fit, as somebody made it."""
    forge(store, FORGED[forged])
    with pytest.raises(StoreError, match="must be a whole store, but is damaged"):
        root.attributes(store)
    assert typed(f"resume {store} --until 0.3") in (
        0,
        5,
    )  # what is derived is made again


def test_chunks_of_another_codec_are_an_error_of_the_store(store: Path, tmp_path: Path) -> None:
    """Its documents fit too; the codec raises an error of a type of its own."""
    codecs = [{"name": "bytes"}, {"name": "zstd", "configuration": {"level": 1}}]
    edited(store, lambda r: r[0]["members"]["trajectory/time"].update(codecs=codecs))
    assert typed(f"export {store} --to csv --out {tmp_path}/a.csv") == 5


def test_chunks_without_rows_are_refused(store: Path) -> None:
    def edit(records: list[dict[str, Any]]) -> None:
        for document in records[0]["members"].values():
            if "shape" in document:
                document["chunk_grid"]["configuration"]["chunk_shape"] = [0]

    edited(store, edit)
    assert typed(f"info {store}") == 5


def test_rows_without_end_are_refused_without_listing_them(store: Path) -> None:
    edited(store, lambda r: r[1]["rows"].update(trajectory=10**12))
    before = time.monotonic()
    assert typed(f"info {store}") == 5
    assert time.monotonic() - before < 5


# --- what ties a store together -----------------------------------------------------------------


@pytest.mark.parametrize(
    "place", ["zarr.json", "trajectory/zarr.json", "trajectory/theta/c.0", "trajectory/x"]
)
@pytest.mark.parametrize("what", ["pipe", "device", "nowhere", "itself"])
def test_what_a_reader_would_wait_for_is_refused(what: str, place: str, store: Path) -> None:
    """Before, a pipe was waited for and /dev/zero was read for ever."""
    if (store / place).is_dir():
        shutil.rmtree(store / place)
    else:
        (store / place).unlink()
    if what == "pipe":
        os.mkfifo(store / place)
    else:
        (store / place).symlink_to(
            {"device": "/dev/zero", "nowhere": "nowhere", "itself": store}[what]
        )
    assert typed(f"info {store}") == 5
