"""Compare zarr v3 written directly with zarr: equal files, and each reads the other's."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from stores import files

from tippetop.columns import Column
from tippetop.store import zarr3
from tippetop.store.folder import Folder


CHUNK, ROWS = 8, 21
KINDS = ("float64", "bool", "int8", "int16", "int32", "int64")


def columns(rng: np.random.Generator) -> dict[str, Column]:
    """Return columns of every type, of one to three dimensions, some of them transposed."""
    words = {"units": "kg m2", "long_name": "θ of a row", "flag_values": [0, 1], "weight": 0.1}
    table = {
        kind: Column(("time",), rng.integers(0, 2, ROWS).astype(kind), words) for kind in KINDS
    }
    vectors = np.asfortranarray(rng.normal(size=(ROWS, 3)))
    return table | {
        "vector": Column(("time", "xyz"), vectors, {}),
        "tensor": Column(("time", "xyz", "part"), rng.normal(size=(ROWS, 3, 2)), {"units": "1"}),
        "gaps": Column(("time",), np.full(ROWS, np.nan), {}),
    }


def test_equal_numbers_are_equal_bytes() -> None:
    """Threads would order the blocks of a large chunk by chance."""
    array = np.random.default_rng(1).normal(size=65536)
    document = zarr3.array(Column(("time",), array, {}), {})
    assert len({zarr3.encode(array, document) for _ in range(500)}) == 1


def directly(path: Path, table: dict[str, Column]) -> None:
    """Write a store without zarr."""
    path.mkdir()
    folder, members = Folder(path), {"group": zarr3.group({})}
    folder.mkdir("group")
    for name, column in table.items():
        document = members[f"group/{name}"] = zarr3.array(column, {"time": (ROWS, CHUNK)})
        folder.mkdir(f"group/{name}")
        for k in range(-(-ROWS // CHUNK)):
            values = column.values[k * CHUNK : (k + 1) * CHUNK]
            folder.write(
                f"group/{name}/{zarr3.chunk_name(document, k)}", zarr3.encode(values, document)
            )
    for name, document in members.items():
        folder.write(f"{name}/zarr.json", zarr3.dump(document))
    folder.write("zarr.json", zarr3.dump(zarr3.group({"title": "a store"}, members)))


def by_zarr(path: Path, table: dict[str, Column]) -> None:
    """Write the same store with zarr."""
    codecs: list[Any] = [
        zarr.codecs.BloscCodec(cname="lz4", clevel=1, shuffle="shuffle"),
        zarr.codecs.Crc32cCodec(),
    ]
    root = zarr.open_group(path, mode="w", zarr_format=3, attributes={"title": "a store"})
    group = root.create_group("group")
    with zarr.config.set({"array.write_empty_chunks": True}):
        for name, column in table.items():
            array = group.create_array(
                name,
                shape=column.values.shape,
                dtype=column.values.dtype,
                chunks=(CHUNK, *column.values.shape[1:]),
                dimension_names=column.dims,
                attributes=column.attrs,
                fill_value=np.nan if column.values.dtype.kind == "f" else 0,
                compressors=codecs,
                chunk_key_encoding={"name": "default", "separator": "."},
            )
            array[:] = column.values


@pytest.fixture
def written(tmp_path: Path, rng: np.random.Generator) -> dict[str, Column]:
    """The columns, in a store of ours and in one of zarr."""
    table = columns(rng)
    directly(tmp_path / "ours", table)
    by_zarr(tmp_path / "zarr", table)
    return table


def test_chunks_are_those_of_zarr_and_documents_are_equal(
    written: dict[str, Column], tmp_path: Path
) -> None:
    ours, theirs = files(tmp_path / "ours"), files(tmp_path / "zarr")
    assert ours.keys() == theirs.keys()
    for name in ours.keys() - {"zarr.json"}:
        if name.endswith("zarr.json"):
            assert json.loads(ours[name]) == json.loads(theirs[name]), name
        else:
            assert ours[name] == theirs[name], name


def test_what_zarr_encodes_is_decoded(written: dict[str, Column], tmp_path: Path) -> None:
    for name, column in written.items():
        place = tmp_path / "zarr" / "group" / name
        document = json.loads((place / "zarr.json").read_text())
        last = zarr3.decode((place / zarr3.chunk_name(document, 2)).read_bytes(), document)
        np.testing.assert_array_equal(last[: ROWS % CHUNK], column.values[2 * CHUNK :])


@pytest.mark.parametrize("byte", [0, 20, -1])
def test_a_changed_byte_is_found(byte: int) -> None:
    column = Column(("time",), np.arange(8.0), {})
    document = zarr3.array(column, {})
    data = bytearray(zarr3.encode(column.values, document))
    data[byte] ^= 1
    with pytest.raises(ValueError, match="checksum"):
        zarr3.decode(bytes(data), document)
