"""The seal of a finished store: one digest of its metadata and of the checksum of every chunk.

A chunk ends with its own checksum, which is compared whenever the chunk is read. The seal ties these checksums to their
places: whatever of the metadata or the chunks was changed, exchanged, added or removed since the store was finished is
found when it is opened, at the price of four bytes a chunk. It finds damage, not a forger, who makes a new seal.
"""

import hashlib
import itertools
import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from . import files, zarr3
from .zarr3 import CHECKSUM, DOCUMENT


SEAL = "seal"  # the root attribute


def checksum(place: Path | str, folder: int | None = None) -> bytes:
    """Length and checksum of a chunk, as they stand in its file; a path may be relative to the descriptor of a folder.
    Raises OSError."""
    flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK  # not to wait for a pipe's writer
    descriptor = os.open(place, flags, dir_fd=folder)
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(f"`{place}` is no plain file")
        return status.st_size.to_bytes(8, "little") + os.pread(descriptor, CHECKSUM, max(0, status.st_size - CHECKSUM))
    finally:
        os.close(descriptor)


def of(folder: Path, attributes: dict[str, Any], members: tuple[str, ...]) -> str:
    """The seal of a store with these root attributes (a seal among them is passed over) and members: groups, arrays.
    Raises OSError."""
    whole = hashlib.sha256()
    plain = {key: value for key, value in attributes.items() if key != SEAL}
    whole.update(json.dumps(plain, sort_keys=True).encode())
    for member in sorted(members):
        for place in _content(folder / member):
            name = str(place.relative_to(folder))
            content = place.read_bytes() if place.name == DOCUMENT else checksum(place)
            whole.update(name.encode() + b"\0" + hashlib.sha256(content).digest())
    return whole.hexdigest()


def _content(folder: Path) -> Iterator[Path]:
    """Metadata and chunks of an array, or of the arrays of a group, in order; whatever else is there is not read."""
    yield folder / DOCUMENT
    stored = json.loads((folder / DOCUMENT).read_text(encoding="utf-8"))
    if "shape" in stored:
        chunks = stored["chunk_grid"]["configuration"]["chunk_shape"]
        counts = [range(-(-n // c)) for n, c in zip(stored["shape"], chunks, strict=True)]
        yield from (folder / zarr3.chunk_name(stored, *place) for place in itertools.product(*counts))
        return
    for entry in sorted(folder.iterdir()):
        if entry.is_dir() and entry.name[0] != ".":
            yield from _content(entry)


def put(folder: Path, members: tuple[str, ...], more: dict[str, Any] | None = None) -> None:
    """Adds attributes to the root of a store, and the seal that fits, in one step. Raises OSError."""
    attributes = {key: value for key, value in (_document(folder)["attributes"] | (more or {})).items() if key != SEAL}
    sealed = attributes | {SEAL: of(folder, attributes, members)}
    replace_attributes(folder, sealed, documents(folder, members))


def documents(folder: Path, members: tuple[str, ...]) -> dict[str, Any]:
    """The metadata of groups and arrays, and of the arrays in groups, by path. Raises OSError."""
    found = {}
    for member in members:
        for place in [folder / member / DOCUMENT, *(folder / member).glob(f"[!.]*/{DOCUMENT}")]:
            found[str(place.parent.relative_to(folder))] = json.loads(place.read_text(encoding="utf-8"))
    return found


def remove(folder: Path) -> None:
    """Takes the seal of a store away, in one step. Raises OSError."""
    attributes = _document(folder)["attributes"]
    replace_attributes(folder, {key: value for key, value in attributes.items() if key != SEAL})


def replace_attributes(folder: Path, attributes: dict[str, Any], members: dict[str, Any] | None = None) -> None:
    """Gives the root of a store other attributes, in one step; the metadata of all `members` with them, where those
    no longer change. Raises OSError."""
    files.replace_text(folder / DOCUMENT, zarr3.dump(zarr3.group(attributes, members)).decode())


def _document(folder: Path) -> dict[str, Any]:
    return json.loads((folder / DOCUMENT).read_text(encoding="utf-8"))
