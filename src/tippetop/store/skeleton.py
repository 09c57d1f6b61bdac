"""The skeleton of a store: what its `zarr.json` files say, read as plain JSON and refused unless it can be ours.

Everything that opens a store comes here first: neither zarr nor memory meets a shape, a codec or an attribute that no
release of ours writes.
"""

import json
import math
import os
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from ..errors import StoreError
from . import ledger, seal, zarr3
from .checkpoint import DERIVED
from .patterns import ATTRIBUTES, OPTIONAL, REPORT, RUN, WORDS
from .provenance import FORMAT, FORMAT_VERSION
from .zarr3 import DOCUMENT


GROUPS = {"run": ("trajectory", "events"), "sweep": ("sweep",), "surface": ("surface",), "potential": ("potential",)}
OF_CHUNKS = ("chunk_status", "chunk_checksum")  # of a sweep
SIZES = {"float64": 8, "int64": 8, "int32": 4, "int16": 2, "int8": 1, "bool": 1}  # [bytes]
CODECS = (["bytes", "blosc", "crc32c"], ["bytes", "zstd"])  # the second: surfaces of release 0.1
MOST_CHUNK, MOST_ELEMENTS = 1 << 30, 1 << 42  # bytes of a chunk (ours: 8 MiB); elements of an array laid out ahead
DEEPEST = 8  # folders in one another


def root_of(path: str | Path) -> dict[str, Any]:
    """The root attributes as they stand in a store. Raises StoreError if there is none of ours."""
    place = Path(path)
    if ledger.is_ledger(place):
        return ledger.read(place, chunks=False).attributes
    try:
        document = _document(place)
        stored = document["attributes"]
        if stored["format"] != FORMAT or document["zarr_format"] != 3 or document["node_type"] != "group":
            raise KeyError("format")
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise StoreError(f"`{path}` {_no_store(place, error)}.") from None
    if "content" in stored:
        raise StoreError(
            f"`{path}` was written by a preview of tippetop (format 1): make it again, or read its numbers "
            "with xarray.open_zarr."
        )
    if stored.get("format_version") != FORMAT_VERSION:
        raise StoreError(
            f"`{path}` must have format version {FORMAT_VERSION}, but has {stored.get('format_version')}: "
            "use the release that wrote it."
        )
    return stored


def refuse_foreign(path: Path) -> None:
    """Raises StoreError if tippetop did not write what is there; what is damaged is not refused."""
    if not ledger.is_ledger(path):
        root_of(path)


def read(path: str | Path, *, whole: bool = True) -> dict[str, Any]:
    """The root attributes of a store whose skeleton is sound.

    Parameters
    ----------
    path
        The store.
    whole
        Whether a finished store must have the file of every chunk too; False where what is missing is computed anew.

    Raises
    ------
    StoreError
        There is no store of ours, or its metadata cannot be what we wrote: one sentence that names the first fault.
    """
    place = Path(path)
    if ledger.is_ledger(place):
        return ledger.read(place, chunks=whole).attributes
    attrs = root_of(path)
    content = attrs.get("content", "run")
    try:
        if not isinstance(content, str) or content not in GROUPS:
            raise _Fault("content", f"must be one of {', '.join(list(GROUPS)[1:])}")
        refuse_pipes(place)
        _like(attrs, WORDS | ATTRIBUTES[content], "")
        if content == "run":
            _like(attrs["report"], REPORT, "report.")
            _like(attrs["run"], RUN, "run.")
            _like(attrs, OPTIONAL, "")
        for group in groups_of(attrs):
            arrays = members(place, group)
            if content == "run":
                _rows(place / group, arrays, running=attrs["status"] == "running", whole=whole)
            elif content == "sweep":
                _laid_out(place, group, arrays, attrs, whole=whole and attrs["status"] != "running")
            elif content == "surface":
                _surface(place / group, arrays, attrs, whole=whole)
            else:
                _bounded(place / group, arrays)
        if whole and seal.SEAL in attrs and attrs.get("status") != "running":
            _sealed(place, attrs)
    except _Fault as fault:
        raise StoreError(f"`{path}` must be a whole store, but is damaged: {fault}.") from None
    except OSError as error:
        raise _unreadable(path, error) from None
    return attrs


def has_keyframes(attrs: Mapping[str, Any]) -> bool:
    """Whether a store with these root attributes is that of a run with keyframes; the rows of a replay are none."""
    return "content" not in attrs and attrs["run"].get("output") == "keyframes" and "replay" not in attrs


def groups_of(attrs: Mapping[str, Any]) -> tuple[str, ...]:
    """The groups of a store with these root attributes."""
    more = ["keyframes"] if has_keyframes(attrs) else []
    more += ["phases", "impacts"] if "content" not in attrs and "contact" in attrs else []
    derived = "content" not in attrs and attrs["run"].get("sensitivities") and "replay" not in attrs
    more += DERIVED if derived else []
    return (*GROUPS[attrs.get("content", "run")], *more)


def members(place: Path, group: str) -> dict[str, dict[str, Any]]:
    """The metadata of the arrays of a group, by name. Raises _Fault, a StoreError."""
    folder = place / group
    _node(folder, "group")
    folders = [entry for entry in sorted(folder.iterdir()) if entry.is_dir() and entry.name[0] != "."]
    stored = {entry.name: _array(entry) for entry in folders}
    if not stored:
        raise _Fault(folder, "must hold columns")
    return stored


def compare(place: Path, group: str, wanted: Mapping[str, dict[str, Any]], *, rows: bool = False) -> None:
    """Compares a group with the metadata that it must have; the number of rows too, if so. Raises StoreError."""
    stored = members(place, group)
    if odd := sorted(stored.keys() ^ wanted.keys()):
        state = "is missing" if odd[0] in wanted else "is no column of it"
        raise _Fault(place / group, f"must have the columns of its scenario, but `{odd[0]}` {state}")
    for name, document in wanted.items():
        mine, yours = ({**each, "shape": each["shape"][0 if rows else 1 :]} for each in (document, stored[name]))
        if differ := [key for key in mine if not _same(mine[key], yours.get(key))]:
            raise _Fault(place / group / name, f"must be the column of its scenario, but differs in {differ[0]}")


def _same(one: Any, other: Any) -> bool:
    """Whether plain data are equal, types included."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def sealed_members(attrs: Mapping[str, Any]) -> tuple[str, ...]:
    """Groups and arrays of a store with these root attributes that its seal covers."""
    return (*groups_of(attrs), *(OF_CHUNKS if attrs.get("content") == "sweep" else ()))


def _sealed(place: Path, attrs: dict[str, Any]) -> None:
    """Compares a finished store with its seal."""
    try:
        here = seal.of(place, attrs, sealed_members(attrs))
    except (OSError, ValueError) as error:
        raise _Fault(place, f"must be readable, but: {error}") from None
    inline = _document(place).get("consolidated_metadata", {}).get("metadata")
    if here != attrs[seal.SEAL] or inline not in (None, seal.documents(place, sealed_members(attrs))):
        raise _Fault(place, "must hold what its seal says, but a number of its metadata or a chunk is another")


def refuse_pipes(folder: Path, depth: int = 0) -> None:
    """Refuses what a reader would wait for, or read for ever: pipes, devices, links to nowhere, folders without end.
    Raises StoreError."""
    if depth > DEEPEST:
        raise _Fault(folder, f"must not be deeper than {DEEPEST} folders")
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.is_dir():
                    refuse_pipes(Path(entry.path), depth + 1)
                elif not entry.is_file():
                    raise _Fault(entry.path, "must be a file or a folder")
    except _Fault:
        raise
    except OSError as error:
        raise _unreadable(folder, error) from None


class _Fault(StoreError):
    """What is wrong, and where."""

    def __init__(self, where: Any, sentence: str):
        super().__init__(f"`{where}` {sentence}")


def _unreadable(path: str | Path, error: OSError) -> StoreError:
    return StoreError(f"`{path}` must be readable, but: {error.strerror or error}.")


def _document(folder: Path) -> dict[str, Any]:
    place = folder / DOCUMENT
    if place.exists() and not place.is_file():
        raise OSError(f"`{place}` is no plain file")
    return json.loads(place.read_text(encoding="utf-8"))


def _node(folder: Path, kind: str) -> dict[str, Any]:
    """The metadata of a group or an array."""
    try:
        stored = _document(folder)
    except (OSError, ValueError, RecursionError) as error:
        sentence = error.strerror if isinstance(error, OSError) else error
        raise _Fault(folder / DOCUMENT, f"must be readable, but: {sentence}") from None
    right = isinstance(stored, dict) and stored.get("zarr_format") == 3 and stored.get("node_type") == kind
    if not right or not isinstance(stored.get("attributes"), dict):
        raise _Fault(folder / DOCUMENT, f"must be the metadata of a zarr {kind}")
    return stored


def group(folder: Path) -> dict[str, Any]:
    """The metadata of a group. Raises StoreError if it is none."""
    return _node(folder, "group")


def _array(folder: Path) -> dict[str, Any]:
    """The metadata of an array such as `tables.create_table` makes."""
    stored = _node(folder, "array")

    def sizes(value: Any, least: int) -> bool:
        return isinstance(value, list) and all(type(n) is int and n >= least for n in value)

    def must(condition: bool, key: str) -> None:
        if not condition:
            text = json.dumps(stored.get(key))
            raise _Fault(folder, f"must have a {key} that tippetop writes, but has {text[:80]}")

    must(sizes(stored.get("shape"), 0) and len(stored["shape"]) > 0, "shape")
    must(stored.get("data_type") in list(SIZES), "data_type")
    size, shape, grid = SIZES[stored["data_type"]], stored["shape"], stored.get("chunk_grid") or {}
    must(isinstance(grid, dict) and isinstance(grid.get("configuration"), dict), "chunk_grid")
    chunk = grid["configuration"].get("chunk_shape")
    must(grid.get("name") == "regular" and sizes(chunk, 1) and len(chunk) == len(shape), "chunk_grid")
    must(math.prod(chunk) * size <= MOST_CHUNK, "chunk_grid")
    keys = [{"name": "default", "configuration": {"separator": separator}} for separator in "./"]
    must(stored.get("chunk_key_encoding") in keys, "chunk_key_encoding")
    must(stored.get("storage_transformers", []) == [], "storage_transformers")
    names = stored.get("dimension_names")
    must(
        isinstance(names, list) and len(names) == len(shape) and all(isinstance(n, str) for n in names),
        "dimension_names",
    )
    fill, real = stored.get("fill_value"), stored["data_type"] == "float64"
    must(fill in ("NaN", 0) if real else fill in (0, -1), "fill_value")
    codecs = stored.get("codecs") or []
    must(isinstance(codecs, list) and all(isinstance(c, dict) for c in codecs), "codecs")
    must([c.get("name") for c in codecs] in CODECS, "codecs")
    settings = [c.get("configuration", {}) for c in codecs]
    must(all(isinstance(c, dict) for c in settings), "codecs")
    must(settings[0] == ({} if size == 1 else {"endian": "little"}), "codecs")
    if codecs[1]["name"] == "blosc":
        ours = {"typesize": size, "cname": "lz4", "clevel": 1, "shuffle": "shuffle", "blocksize": 0}
        must(settings[1] == ours and settings[2] == {}, "codecs")
    else:
        must(settings[1] == {"level": 0, "checksum": False}, "codecs")
    words = stored["attributes"]
    must(all(isinstance(words.get(k, ""), str) for k in ("units", "long_name", "flag_meanings")), "attributes")
    flags = words.get("flag_values", [])
    must(isinstance(flags, list) and ("flag_values" in words) == ("flag_meanings" in words), "attributes")
    must(all(type(n) is int for n in flags) and len(flags) == len(words.get("flag_meanings", "").split()), "attributes")
    return stored


def _like(value: Any, pattern: Any, where: str) -> None:
    """Compares plain data with a pattern: types, and tables of them."""
    for key, wanted in pattern.items():
        name = key.removesuffix("?")
        if name not in value:
            if key == name:
                raise _Fault(f"{where}{name}", "is missing from the root attributes")
        elif not _fits(value[name], wanted):
            raise _Fault(f"{where}{name}", f"must be what tippetop writes, but is {json.dumps(value[name])[:80]}")


def _fits(value: Any, wanted: Any) -> bool:
    if isinstance(wanted, dict):
        ((_, each),) = wanted.items()
        return isinstance(value, dict) and all(_fits(v, each) for v in value.values())
    if isinstance(wanted, list):
        return isinstance(value, list) and all(_fits(v, wanted[0]) for v in value)
    kinds = wanted if isinstance(wanted, tuple) else (wanted,)
    return value is None if value is None and None in kinds else type(value) in kinds


def _rows(folder: Path, arrays: dict[str, Any], *, running: bool, whole: bool) -> None:
    """Tables that grow: as many rows as there are chunks for; while they are written, a chunk more."""
    key = "start" if folder.name == "phases" else "time"
    if key not in arrays:
        raise _Fault(folder, f"must have the column `{key}`")
    lengths = {name: array["shape"][0] for name, array in arrays.items()}
    for name, array in arrays.items():
        chunk = array["chunk_grid"]["configuration"]["chunk_shape"]
        if array["shape"][1:] != chunk[1:] or array["dimension_names"][0] != arrays[key]["dimension_names"][0]:
            raise _Fault(folder / name, "must be a column of its table")
        needed = -(-lengths[name] // chunk[0])
        places = (folder / name / zarr3.chunk_name(array, i) for i in range(needed))
        missing = next((i for i, place in enumerate(places) if not place.is_file()), needed)
        if missing < needed - (1 if running else 0) and (whole or needed > missing + 1):
            raise _Fault(
                folder / name, f"must have {needed} chunks for its {lengths[name]} rows, but chunk {missing} is missing"
            )
    if not running and len(set(lengths.values())) > 1:
        odd = next(name for name, n in lengths.items() if n != lengths[key])
        raise _Fault(folder / odd, f"must have {lengths[key]} rows, but has {lengths[odd]}")


def _files(folder: Path, most: int) -> int:
    """Count the chunks along the first axis, up to one more than `most`. Raises OSError."""
    if (folder / "c").is_dir():  # of earlier releases
        return sum(1 for entry in islice((folder / "c").iterdir(), most + 1) if entry.name.isdigit())
    found: set[str] = set()
    for entry in folder.iterdir():
        found |= {entry.name.split(".")[1]} if entry.name.startswith("c.") else set()
        if len(found) > most:
            break
    return len(found)


def _laid_out(place: Path, group: str, arrays: dict[str, Any], attrs: dict[str, Any], *, whole: bool) -> None:
    """The table of a sweep: a row per top."""
    tops, chunk = attrs["tops"], attrs["chunk"]
    if not 0 < tops <= MOST_ELEMENTS or chunk < 1 or math.prod(attrs["shape"]) != tops:
        raise _Fault("tops", "must be the product of the root attribute `shape`")
    if len(attrs["shape"]) != len(attrs["dimensions"]):
        raise _Fault("shape", "must have a number for each of `dimensions`")
    if odd := sorted(arrays.keys() ^ {*attrs["coordinates"], *attrs["columns"]}):
        raise _Fault(place / group / odd[0], "must be a column, and in the root attributes")
    of_chunks = {name: _array(place / name) for name in OF_CHUNKS}
    for name, array in [*arrays.items(), *of_chunks.items()]:
        rows, size = (-(-tops // chunk), None) if name in of_chunks else (tops, chunk)
        grid = array["chunk_grid"]["configuration"]["chunk_shape"]
        if array["shape"] != [rows, *grid[1:]] or (size is not None and grid[0] != size):
            raise _Fault(name, f"must have {rows} rows, but has the shape {array['shape']}")
        folder = place / name if name in of_chunks else place / group / name
        if whole and _files(folder, -(-rows // grid[0])) < -(-rows // grid[0]):
            raise _Fault(folder, "must have all of its chunks")


def _surface(folder: Path, arrays: dict[str, Any], attrs: dict[str, Any], *, whole: bool) -> None:
    """F, z and status over the two axes."""
    axes = {name: axis[2] if len(axis) == 3 else None for name, axis in attrs["axes"].items()}
    if arrays.keys() != {*axes, "F", "z", "status"} or len(axes) != 2:
        raise _Fault(folder, f"must have the columns F, z, status and {', '.join(axes)}")
    _bounded(folder, arrays)
    for name, array in arrays.items():
        if array["shape"] != ([axes[name]] if name in axes else list(axes.values())):
            raise _Fault(folder / name, f"must have the shape of its axes, but has {array['shape']}")
        grid = array["chunk_grid"]["configuration"]["chunk_shape"]
        rows = -(-array["shape"][0] // grid[0])
        if whole and name == "status" and _files(folder / name, rows) < rows:  # of F and z, chunks of NaN are not there
            raise _Fault(folder / name, "must have all of its chunks")


def _bounded(folder: Path, arrays: dict[str, Any]) -> None:
    for name, array in arrays.items():
        if math.prod(array["shape"]) > MOST_ELEMENTS:
            raise _Fault(folder / name, f"must have a shape that tippetop writes, but has {array['shape']}")


def _no_store(place: Path, error: Exception) -> str:
    """Why a path is not a store of ours."""
    if not place.exists():
        return "does not exist"
    if not place.is_dir():
        return "is a file, not a store: a store is a folder that `tippetop run --out` writes"
    if isinstance(error, OSError) and not isinstance(error, FileNotFoundError):
        return f"must be a store of tippetop, but cannot be read: {error.strerror or error}"
    return "must be a store of tippetop, but is another folder"
