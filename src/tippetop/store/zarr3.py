"""Write the documents and chunks of zarr v3 directly, byte for byte as zarr does.

Zarr itself takes 4 to 5 ms for each array, longer than it takes to integrate a short run; so zarr
is used to read only.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Column


DOCUMENT = "zarr.json"
CHECKSUM = 4  # bytes at the end of a chunk: its CRC-32C


def group(attributes: PlainData, members: Mapping[str, Any] | None = None) -> PlainData:
    """Return the document of a group.

    A root group also contains the documents of all `members`, by path.
    """
    inline = {"kind": "inline", "must_understand": False, "metadata": members}
    more = {"consolidated_metadata": inline} if members else {}
    return {"zarr_format": 3, "node_type": "group", "attributes": attributes, **more}


def array(column: Column, sizes: Mapping[str, tuple[int, int]], fill: Any = None) -> PlainData:
    """Return the document of an array.

    The ledger of a store contains it, and a run can be resumed only if it is still made the same.

    Parameters
    ----------
    column
        Its dimensions, type and attributes are those of the array.
    sizes
        Dimension -> (length, length of a chunk). Any other dimension is as long as the column's
        values, in one chunk.
    fill
        Value of elements that were not written; by default NaN, or 0 if the type has no NaN.
    """
    dtype = column.values.dtype
    default = {"f": "NaN", "b": False}.get(dtype.kind, 0)
    one_chunk = [(n, max(n, 1)) for n in column.values.shape]
    each = [sizes.get(dim, size) for dim, size in zip(column.dims, one_chunk, strict=True)]
    endian = {"configuration": {"endian": "little"}} if dtype.itemsize > 1 else {}
    blosc = {  # as `encode` compresses: a change of one is a change of both
        "typesize": dtype.itemsize,
        "cname": "lz4",
        "clevel": 1,
        "shuffle": "shuffle",
        "blocksize": 0,
    }
    return {
        "zarr_format": 3,
        "node_type": "array",
        "shape": [length for length, _ in each],
        "data_type": dtype.name,
        "chunk_grid": {
            "name": "regular",
            "configuration": {"chunk_shape": [chunk for _, chunk in each]},
        },
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": default if fill is None else dtype.type(fill).item(),
        "codecs": [
            {"name": "bytes", **endian},
            {"name": "blosc", "configuration": blosc},
            {"name": "crc32c"},
        ],
        "attributes": column.attrs,
        "dimension_names": list(column.dims),
        "storage_transformers": [],
    }


def dump(document: PlainData) -> bytes:
    """Return a document as bytes. The order of its keys is kept: reports show attributes in it.

    `ledger` compares the bytes of a sealed store with those made here.
    """
    return json.dumps(document, allow_nan=False).encode()


def chunk_shape(document: Mapping[str, Any]) -> list[int]:
    """Return the shape of the chunks of an array."""
    return document["chunk_grid"]["configuration"]["chunk_shape"]


def chunk_name(document: Mapping[str, Any], *index: int) -> str:
    """Return the path of a chunk in the folder of its array; indices that are left out are 0.

    The name is that of zarr for the separator in `array`; `Ledger._tidy` knows chunks by "c.".
    """
    return ".".join(["c", *map(str, index), *["0"] * (len(document["shape"]) - len(index))])


def encode(values: np.ndarray, document: Mapping[str, Any]) -> bytes:
    """Return a chunk as the bytes of its file. Rows that are missing at its end are filled."""
    from numcodecs import blosc

    values = np.ascontiguousarray(values, document["data_type"])
    chunk = tuple(chunk_shape(document))
    if values.shape != chunk:
        padded = np.full(chunk, np.dtype(document["data_type"]).type(document["fill_value"]))
        padded[tuple(map(slice, values.shape))] = values
        values = padded
    # The order of blocks that several threads compress depends on the scheduler.
    threads = blosc.use_threads
    blosc.use_threads = False
    try:
        # as the codec in `array`: a change of one is a change of both
        packed = blosc.compress(values, b"lz4", 1, blosc.SHUFFLE)
    finally:
        blosc.use_threads = threads
    return packed + checksum(packed)


def checksum(data: bytes) -> bytes:
    """Return the CRC-32C of some bytes, as it ends the file of a chunk."""
    import google_crc32c

    return google_crc32c.value(data).to_bytes(CHECKSUM, "little")


def is_intact(data: bytes) -> bool:
    """Return whether the bytes of a chunk's file have the checksum with which they end."""
    return checksum(data[:-CHECKSUM]) == data[-CHECKSUM:]


def decode(data: bytes, document: Mapping[str, Any]) -> np.ndarray:
    """Return the chunk in the bytes of its file. Raises ValueError if they are damaged."""
    from numcodecs import blosc

    if not is_intact(data):
        raise ValueError("the checksum of a chunk is another")
    values = np.frombuffer(blosc.decompress(data[:-CHECKSUM]), document["data_type"])
    return values.reshape(chunk_shape(document)).copy()
