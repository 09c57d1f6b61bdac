"""Columns that grow in chunks: whatever pieces the rows come in, the files are the same; damage is told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from stores import Disk, assert_same, files

from tippetop.columns import Column
from tippetop.errors import StoreError
from tippetop.store import chunks, tables
from tippetop.store.chunks import Appender
from tippetop.store.folder import Folder


CHUNK, ROWS = 8, 45  # five whole chunks and a part


def columns(rows: slice = slice(None)) -> dict[str, Column]:
    """Columns of one and of two dimensions, and of flags."""
    time = np.arange(ROWS) / 7
    values = {"time": time, "axis": np.stack([np.sin(time), np.cos(time), -time], axis=1), "flag": np.arange(ROWS) < 0}
    dims = {"axis": ("time", "xyz")}
    return {name: Column(dims.get(name, ("time",)), v[rows], {"units": "1"}) for name, v in values.items()}


def table(path: Path) -> dict[str, Any]:
    """The arrays of the group."""
    return tables.read_member(path, "trajectory")


def new(path: Path, of: dict[str, Column] | None = None, chunk: int = CHUNK) -> Appender:
    """An empty table in a new store."""
    path.mkdir()
    return Appender.created(chunks.create(path, {}), "trajectory", of or columns(slice(0, 0)), chunk)


def reopened(path: Path, rows: int) -> Appender:
    """The table of a store, as it was when so many rows were acknowledged."""
    again = Appender(Folder(path), "trajectory", columns(slice(0, 0)), CHUNK)
    again.reopen(rows, path)
    return again


def write(appender: Appender) -> None:
    """Writes what waits, for good."""
    appender.flush()
    appender.folder.sync()


def whole(path: Path) -> Path:
    """All rows in one piece."""
    appender = new(path)
    appender.append(columns())
    write(appender)
    return path


def read(path: Path) -> dict[str, np.ndarray]:
    return {name: array[:] for name, array in tables.read_member(path, "trajectory").items()}


def assert_holds(path: Path, rows: int = ROWS) -> None:
    found = read(path)
    assert set(found) == {"time", "axis", "flag"}
    for name, column in columns(slice(rows)).items():
        np.testing.assert_array_equal(found[name], column.values, err_msg=name)


def test_each_chunk_of_a_row_must_be_there(tmp_path: Path) -> None:
    """Whatever the axis: zarr would fill it."""
    root = zarr.create_group(tmp_path / "a")
    array = root.create_array("values", shape=(4, 6), chunks=(2, 3), dtype=float)
    array[:] = np.arange(24.0).reshape(4, 6)
    np.testing.assert_array_equal(chunks._rows(array, 1, 3), array[1:3])
    chunks.chunk_file(array, 2, 3).unlink()
    np.testing.assert_array_equal(chunks._rows(array, 0, 2), array[:2])
    with pytest.raises(OSError, match="a chunk of `values` is missing"):
        chunks._rows(array, 1, 3)


def test_columns_are_kept_with_their_types_names_and_attributes(tmp_path: Path) -> None:
    assert_holds(whole(tmp_path / "a"))
    arrays = table(tmp_path / "a")
    assert arrays["axis"].metadata.dimension_names == ("time", "xyz")
    assert arrays["axis"].chunks == (CHUNK, 3)
    assert arrays["flag"].dtype == np.bool_
    assert arrays["time"].attrs["units"] == "1"


@pytest.mark.parametrize("flush", [False, True])
@pytest.mark.parametrize("pieces", [[45], [1] * 45, [8, 8, 8, 8, 8, 5], [7, 0, 38], [40, 5]], ids=str)
def test_the_files_do_not_depend_on_the_pieces_nor_on_flushes(pieces: list[int], flush: bool, tmp_path: Path) -> None:
    appender, start = new(tmp_path / "a"), 0
    for count in pieces:
        appender.append(columns(slice(start, start + count)))
        start += count
        assert appender.rows == start
        if flush:
            write(appender)
            assert_holds(tmp_path / "a", start)
    write(appender)
    assert_same(tmp_path / "a", whole(tmp_path / "whole"))


def test_only_whole_chunks_are_written_before_a_flush_which_says_how_many_rows_there_are(tmp_path: Path) -> None:
    appender = new(tmp_path / "a")
    appender.append(columns(slice(0, 13)))
    assert [place.name for place in (tmp_path / "a/trajectory/time").glob("c.*")] == ["c.0"]
    assert len(read(tmp_path / "a")["time"]) == 0
    write(appender)
    assert len(read(tmp_path / "a")["time"]) == 13
    before = files(tmp_path / "a")
    write(appender)
    assert files(tmp_path / "a") == before


@pytest.mark.parametrize("flushed", [True, False])
@pytest.mark.parametrize("acknowledged", [0, 5, 8, 19, 40])
def test_what_was_not_acknowledged_is_cut_and_the_rest_goes_on(
    acknowledged: int, flushed: bool, tmp_path: Path
) -> None:
    """As after a kill: rows beyond the checkpoint are on the disk, whole or in part, also where no metadata tell."""
    appender = new(tmp_path / "a")
    appender.append(columns(slice(0, acknowledged)))
    write(appender)
    appender.append(columns(slice(acknowledged, 43)))
    if flushed:
        write(appender)
    again = reopened(tmp_path / "a", acknowledged)
    assert again.rows == acknowledged
    again.append(columns(slice(acknowledged, None)))
    write(again)
    assert_same(tmp_path / "a", whole(tmp_path / "whole"))


class Killed(Exception):
    """The writer dies."""


@pytest.mark.parametrize("after", [0, 1, 5])
def test_a_writer_killed_while_it_cuts_leaves_no_chunk_too_few(
    after: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, what it was about to cut was taken for damage: the store could never be resumed."""
    whole(tmp_path / "a")
    removed, remove = [], Folder.remove

    def die(folder: Folder, name: str) -> None:
        if len(removed) == after:
            raise Killed
        removed.append(name)
        remove(folder, name)

    with monkeypatch.context() as patched:
        patched.setattr(Folder, "remove", die)
        with pytest.raises(Killed):
            reopened(tmp_path / "a", 8)
    chunks.verify(table(tmp_path / "a"))  # every chunk that its metadata promises
    appender = reopened(tmp_path / "a", 8)
    appender.append(columns(slice(8, None)))
    write(appender)
    assert_same(tmp_path / "a", whole(tmp_path / "b"))


def test_fewer_rows_than_acknowledged_are_an_error(tmp_path: Path) -> None:
    whole(tmp_path / "a")
    with pytest.raises(StoreError, match="must hold the 46 acknowledged rows, but has 45"):
        reopened(tmp_path / "a", 46)


def test_flags_are_set_in_rows_written_and_waiting(tmp_path: Path) -> None:
    appender = new(tmp_path / "a")
    appender.append(columns())
    appender.mark("flag", [0, 9, 39, 40, 44])
    write(appender)
    assert np.flatnonzero(read(tmp_path / "a")["flag"]).tolist() == [0, 9, 39, 40, 44]


def test_everything_written_is_synced_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    disk, group = Disk(monkeypatch), tmp_path / "a" / "trajectory"
    appender = new(tmp_path / "a")
    appender.append(columns(slice(0, 20)))
    appender.flush()
    some = {group, group / "time" / "c.2", group / "axis" / "zarr.json.new"}
    assert some < set(disk.late(tmp_path / "a"))
    appender.folder.sync()
    assert disk.late(tmp_path / "a") == []
    disk.synced.clear()
    appender.folder.sync()
    assert disk.synced == {}
    appender.mark("flag", [3])
    appender.folder.sync()
    flags = group / "flag"
    assert disk.synced.keys() == {place.stat().st_ino for place in (flags, flags / "c.0")}


# --- damage ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("harm", ["flipped", "cut", "missing"])
def test_a_damaged_chunk_is_named(harm: str, tmp_path: Path) -> None:
    whole(tmp_path / "a")
    chunks.verify(table(tmp_path / "a"))
    victim = tmp_path / "a" / "trajectory" / "axis" / "c.2.0"
    content = bytearray(victim.read_bytes())
    if harm == "missing":
        victim.unlink()
    else:
        content[len(content) // 2] ^= 1
        victim.write_bytes(content if harm == "flipped" else content[:-3])
    with pytest.raises(StoreError, match="axis` must be readable in rows 16 to 24"):
        chunks.verify(table(tmp_path / "a"))


# --- reading --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 8, 13, 45, 100])
def test_pieces_make_the_whole(rows: int, tmp_path: Path) -> None:
    whole(tmp_path / "a")
    found = list(chunks.pieces(tmp_path / "a", "trajectory", ["time", "axis"], rows))
    assert all(set(piece) == {"time", "axis"} for piece in found)
    assert all(len(piece["time"]) == rows for piece in found[:-1])
    np.testing.assert_array_equal(np.concatenate([piece["axis"] for piece in found]), columns()["axis"].values)


def test_no_group_is_a_sentence(tmp_path: Path) -> None:
    whole(tmp_path / "a")
    for path, name in ((tmp_path / "a", "events"), (tmp_path / "b", "trajectory")):
        with pytest.raises(StoreError, match=f"must hold a readable group `{name}`"):
            chunks.digest(path, name)


@pytest.mark.parametrize(("count", "most"), [(1000, 2000), (1000, 100), (999, 10), (1001, 500)])
def test_a_thin_reading_keeps_the_extremes_of_every_bin(
    count: int, most: int, tmp_path: Path, rng: np.random.Generator
) -> None:
    """No value between two kept rows lies outside the kept values of its neighbourhood."""
    values = np.cumsum(rng.normal(size=count))
    values[count // 3] = np.nan
    of = {n: Column(("time",), v, {}) for n, v in (("time", np.arange(float(count))), ("value", values))}
    appender = new(tmp_path / "a", of, 64)
    appender.append(of)
    write(appender)
    found = chunks.digest(tmp_path / "a", "trajectory", "value", most)
    rows = found["time"].values.astype(int)
    assert np.all(np.diff(rows) > 0)
    assert rows[-1] == count - 1
    np.testing.assert_array_equal(found["value"].values, values[rows])
    if most >= count:
        assert len(rows) == count
        return
    assert len(rows) <= most + 2
    size = -(-count // (most // 2))
    for start in range(0, count, size):
        inside = rows[(rows >= start) & (rows < start + size)]
        part = np.nan_to_num(values[start : start + size])
        assert np.nan_to_num(values[inside]).min() == part.min()
        assert np.nan_to_num(values[inside]).max() == part.max()
