"""Our arrays against zarr: the same files, byte for byte, whatever is written; and each reads what the other wrote."""

import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from numcodecs import blosc
from zarr.codecs import BloscCodec, Crc32cCodec

from tippetop.columns import Column
from tippetop.store import tables


CASES = [
    ("float64", (), None),
    ("float64", (3,), np.nan),
    ("int64", (), -1),
    ("int32", (2, 2), None),
    ("int16", (), None),
    ("int8", (), -1),
    ("bool", (), None),
]
ATTRIBUTES = {"units": "rad", "long_name": "ϑ of the axis", "flag_values": [0, 1]}


def theirs(path: Path, kind: str, more: tuple[int, ...], fill: Any) -> Any:
    """The same array, made by zarr."""
    group = zarr.open_group(store=str(path), mode="a", zarr_format=3, attributes={"x": 1.5}).create_group("table")
    with zarr.config.set({"array.write_empty_chunks": True}):
        return group.create_array(
            "a",
            shape=(0, *more),
            chunks=(4, *more),
            dtype=kind,
            dimension_names=("time", *"xyz"[: len(more)]),
            attributes=ATTRIBUTES,
            fill_value=fill if fill is not None else np.nan if kind == "float64" else 0,
            compressors=[BloscCodec(cname="lz4", clevel=1, shuffle="shuffle"), Crc32cCodec()],
        )


def ours(path: Path, kind: str, more: tuple[int, ...], fill: Any) -> Any:
    group = tables.create_root(path, {"x": 1.5}).create_group("table")
    column = Column(("time", *"xyz"[: len(more)]), np.zeros((0, *more), kind), ATTRIBUTES)
    return tables.create_table(group, {"a": column}, {"time": (0, 4)}, fill={} if fill is None else {"a": fill})["a"]


def files(path: Path) -> dict[str, bytes]:
    return {str(p.relative_to(path)): p.read_bytes() for p in path.rglob("*") if p.is_file()}


@pytest.mark.parametrize(("kind", "more", "fill"), CASES, ids=str)
def test_the_files_are_those_of_zarr(kind: str, more: tuple[int, ...], fill: Any, tmp_path: Path) -> None:
    values = (np.arange(11 * np.prod(more, dtype=int)).reshape(11, *more) % 7).astype(kind)
    made = {"ours": ours(tmp_path / "ours", kind, more, fill), "theirs": theirs(tmp_path / "theirs", kind, more, fill)}
    for name, array in made.items():
        array.resize(11 if name == "ours" else (11, *more))
        array[:11] = values
        array[3:6] = values[5:8]
        array[7] = 0
    assert files(tmp_path / "ours") == files(tmp_path / "theirs")
    read: Any = zarr.open(store=str(tmp_path / "ours"), mode="r", path="table/a")
    mine = tables.read_member(tmp_path / "theirs", "table")["a"]
    np.testing.assert_array_equal(read[:], mine[:])
    for key in (slice(2, 9), slice(5, 5), 6, ..., (slice(3, 11), ...), slice(None, -3)):
        np.testing.assert_array_equal(mine[key], read[key])
    assert mine.dims == read.metadata.dimension_names
    assert mine.attrs == dict(read.attrs)


def test_a_chunk_that_is_not_there_is_its_fill_value(tmp_path: Path) -> None:
    array = ours(tmp_path / "s", "int8", (), -1)
    array.resize(6)
    assert array[:].tolist() == [-1] * 6
    array[5] = 3
    assert array[:].tolist() == [-1, -1, -1, -1, -1, 3]
    assert not (tmp_path / "s/table/a/c/0").exists()


def test_metadata_are_what_is_made(tmp_path: Path) -> None:
    column = Column(("time", "xyz"), np.zeros((0, 3)), {})
    wanted = tables.metadata({"a": column}, {"time": (8, 4)})
    tables.create_table(tables.create_root(tmp_path / "s", {}), {"a": column}, {"time": (8, 4)})
    assert json.loads((tmp_path / "s/a/zarr.json").read_text()) == wanted["a"]


def test_no_threads_are_begun_nor_forbidden_to_others(tmp_path: Path) -> None:
    array = ours(tmp_path / "s", "float64", (), None)
    array.resize(4)
    before, blosc.use_threads = blosc.use_threads, None
    try:
        array[:] = 1.0
        thread = threading.Thread(target=array.__setitem__, args=(slice(None), 2.0))
        thread.start()
        thread.join()
        assert blosc.use_threads is None
        assert array[:].tolist() == [2.0] * 4
    finally:
        blosc.use_threads = before
