"""A store that no release writes is refused with a sentence, before zarr or memory meet it."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
import zarr

import tippetop
from tippetop.cli import outcome
from tippetop.errors import StoreError
from tippetop.store import root, skeleton


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a short run."""
    path = tmp_path_factory.mktemp("made") / "run.zarr"
    tippetop.run("inverting", until=0.1, out=path)
    return path


def test_nothing_warns_of_a_whole_store_and_its_datasets_are_bare_of_what_only_we_need(made: Path) -> None:
    """zarr warns of every file that is no member of a hierarchy; a warning fails a test."""
    whole = xr.open_datatree(made, engine="zarr", consolidated=False)
    assert set(whole.children) == {"trajectory", "events"}
    assert {"status", "end", "seal"} <= whole.attrs.keys()
    assert xr.open_zarr(made, consolidated=False).attrs == whole.attrs
    assert len(list(zarr.open_group(made, mode="r").members(max_depth=None))) > 20
    run = tippetop.open(made)
    for attrs in (run.attributes, run.trajectory.attrs, root.open_group(made, "events").attrs):
        assert "end" not in attrs
        assert attrs["status"] == "finished"


@pytest.fixture
def store(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "run.zarr"))


def edited(place: Path, edit: Callable[[dict[str, Any]], Any]) -> None:
    document = json.loads(place.read_text())
    edit(document)
    place.write_text(json.dumps(document))


ARRAYS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "shape": lambda d: d.update(shape=[10**15]),
    "no shape": lambda d: d.pop("shape"),
    "shape of another kind": lambda d: d.update(shape=["many"]),
    "two dimensions": lambda d: d.update(shape=[101, 10**9]),
    "codec": lambda d: d["codecs"].__setitem__(1, {"name": "rot13"}),
    "no codec": lambda d: d.update(codecs=[]),
    "no checksum": lambda d: d["codecs"].pop(),
    "typesize": lambda d: d["codecs"][1]["configuration"].update(typesize=10**9),
    "dtype": lambda d: d.update(data_type="int64"),
    "unknown dtype": lambda d: d.update(data_type={"name": "pickle"}),
    "chunk": lambda d: d["chunk_grid"]["configuration"].update(chunk_shape=[10**12]),
    "no chunk": lambda d: d["chunk_grid"]["configuration"].update(chunk_shape=[0]),
    "no grid": lambda d: d.update(chunk_grid=None),
    "fill": lambda d: d.update(fill_value="x"),
    "names": lambda d: d.update(dimension_names=None),
    "attributes": lambda d: d.update(attributes=[]),
    "flags": lambda d: d["attributes"].update(flag_values=[1, "x"], flag_meanings=3),
    "a group": lambda d: d.update(node_type="group"),
    "another format": lambda d: d.update(zarr_format=2),
    "separator": lambda d: d["chunk_key_encoding"]["configuration"].update(separator="x"),
}


@pytest.mark.parametrize("damage", ARRAYS)
def test_metadata_of_an_array_that_cannot_be_ours_is_refused(damage: str, store: Path) -> None:
    edited(store / "trajectory" / "theta" / "zarr.json", ARRAYS[damage])
    with pytest.raises(StoreError, match=r"must be a whole store, but is damaged: .*theta"):
        skeleton.read(store)


ROOTS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "no report": lambda a: a.pop("report"),
    "a report of another kind": lambda a: a.update(report=[1]),
    "drift": lambda a: a["report"].update(drift={"energy": "x"}),
    "units": lambda a: a.update(units=None),
    "status": lambda a: a.update(status=7),
    "content": lambda a: a.update(content="cake"),
    "another content": lambda a: a.update(content="sweep"),
    "parameters": lambda a: a["parameters"].update(alpha=[0.3]),
    "run": lambda a: a["run"].pop("until"),
    "versions": lambda a: a.update(versions="all"),
}


@pytest.mark.parametrize("damage", ROOTS)
def test_root_attributes_that_cannot_be_ours_are_refused(damage: str, store: Path) -> None:
    edited(store / "zarr.json", lambda document: ROOTS[damage](document["attributes"]))
    with pytest.raises(StoreError, match="must be a whole store, but is damaged"):
        skeleton.read(store)


@pytest.mark.parametrize("part", ["trajectory/theta/c.0", "trajectory/time", "trajectory/zarr.json", "events"])
def test_what_is_missing_is_named(part: str, store: Path) -> None:
    place = store / part
    shutil.rmtree(place) if place.is_dir() else place.unlink()
    with pytest.raises(StoreError, match=r"must be a whole store, but is damaged: .*(theta|time|trajectory|events)"):
        skeleton.read(store)


def test_every_command_that_reads_a_store_refuses_with_five(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before, a shape of 10^15 was a MemoryError."""
    edited(store / "trajectory" / "theta" / "zarr.json", ARRAYS["shape"])
    for words in (
        ["info", str(store)],
        ["plot", str(store), "--out", str(tmp_path / "a.png")],
        ["export", str(store), "--to", "csv", "--out", str(tmp_path / "a.csv")],
        ["resume", str(store)],
    ):
        assert outcome(words) == 5
        assert "theta` must have 976562500000 chunks for its 1000000000000000 rows" in capsys.readouterr().err
    with pytest.raises(StoreError, match="theta"):
        tippetop.open(store)


# --- what ties a store together -------------------------------------------------------------------------------------


def exchange(one: Path, other: Path) -> None:
    mine, yours = one.read_bytes(), other.read_bytes()
    one.write_bytes(yours)
    other.write_bytes(mine)


SEALED: dict[str, Callable[[Path], Any]] = {
    "chunks of two columns": lambda s: exchange(s / "trajectory/theta/c.0", s / "trajectory/phi/c.0"),
    "columns": lambda s: [exchange(s / "trajectory/theta" / f, s / "trajectory/phi" / f) for f in ("zarr.json", "c.0")],
    "a number": lambda s: edited(s / "zarr.json", lambda d: d["attributes"]["parameters"].update(alpha=0.31)),
    "a word": lambda s: edited(s / "zarr.json", lambda d: d["attributes"].update(cpu="abacus")),
    "a unit": lambda s: edited(s / "trajectory/theta/zarr.json", lambda d: d["attributes"].update(units="deg")),
    "a missing column": lambda s: shutil.rmtree(s / "trajectory/theta"),
    "a missing chunk": lambda s: (s / "trajectory/theta/c.0").unlink(),
}


@pytest.mark.parametrize("damage", SEALED)
def test_what_was_changed_after_a_store_was_finished_is_refused(damage: str, store: Path) -> None:
    """Before, all of these were read with exit code 0: each file by itself is sound."""
    skeleton.read(store)
    SEALED[damage](store)
    with pytest.raises(StoreError, match="must be a whole store, but is damaged"):
        skeleton.read(store)


def test_a_store_that_is_annotated_or_older_is_read(store: Path) -> None:
    root.annotate(store, {"note": 1})
    assert skeleton.read(store)["note"] == 1
    edited(store / "zarr.json", lambda document: document["attributes"].pop("seal"))
    assert "seal" not in skeleton.read(store)


@pytest.mark.parametrize("place", ["zarr.json", "trajectory/zarr.json", "trajectory/theta/c.0", "trajectory/x"])
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
        (store / place).symlink_to({"device": "/dev/zero", "nowhere": "nowhere", "itself": store}[what])
    assert outcome(["info", str(store)]) == 5
