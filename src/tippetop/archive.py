"""Runs and tables of columns <-> zarr stores. A store appears whole or not at all."""

import contextlib
import errno
import fcntl
import json
import math
import os
import platform
import shutil
import uuid
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np


if TYPE_CHECKING:
    import xarray as xr


FORMAT = "tippetop"
FORMAT_VERSION = 1
CHECKPOINT = "checkpoint.json"
LOCK = "run.lock"


class StoreError(OSError):
    """The store or the disk: one sentence, exit code 5."""


def locked(folder: Path) -> int:
    """Takes the lock of a store; the system frees it when the process ends, however it ends. Raises StoreError."""
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        holder = os.read(descriptor, 200).decode(errors="replace").strip() or "another process"
        os.close(descriptor)
        raise StoreError(f"`{folder}` must have one writer, but {holder} is writing it.") from None
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"process {os.getpid()} on {os.uname().nodename}".encode())
    return descriptor


@contextlib.contextmanager
def new_store(target: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Gives a scratch folder beside `target`, which becomes `target` when the block ends well and vanishes when not.

    Raises StoreError at once if `target` exists (and is not ours to overwrite) or cannot be written.
    """
    target = Path(target)
    _refuse_existing(target, overwrite)
    scratch = target.with_name(f".{target.name}.part-{uuid.uuid4().hex[:8]}")
    try:
        scratch.mkdir()
    except OSError as error:
        raise StoreError(f"`{target}` must be writable, but: {error.strerror or error}.") from None
    try:
        yield scratch
        if target.exists():
            old = scratch.with_suffix(".old")
            target.rename(old)
            scratch.rename(target)
            shutil.rmtree(old)
        else:
            scratch.rename(target)
    except OSError as error:
        raise StoreError(f"`{target}` must be written whole, but: {error.strerror or error}.") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _refuse_existing(target: Path, overwrite: bool) -> None:
    if not target.exists():
        return
    if not overwrite:
        raise StoreError(f"`{target}` must not exist yet, but does: remove it, or say --overwrite.")
    try:
        attributes(target)
    except StoreError:
        raise StoreError(f"`{target}` must be a store of tippetop to be overwritten, but is something else.") from None


def replace_text(path: Path, text: str) -> None:
    """Writes a file whole or not at all, also if the machine loses power."""
    scratch = path.with_name(f".{path.name}.part")
    with open(scratch, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(scratch, path)
    synced(path.parent)


def synced(path: Path) -> None:
    """Waits until the disk itself has a file, or what a folder says of its files."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL or not path.is_dir():  # some file systems sync no folders
            raise
    finally:
        os.close(descriptor)


def sweep(folder: Path) -> None:
    """Removes the scratch files that a killed writer leaves: zarr's and our own."""
    for pattern in ("*.partial", ".*.part"):
        for path in folder.rglob(pattern):
            path.unlink()


def finite(value: Any) -> Any:
    """The value as JSON can hold it: numbers that are not finite become None."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def attributes(path: str | Path) -> dict[str, Any]:
    """Root attributes of a store. Raises StoreError if there is none of ours."""
    place = Path(path)
    try:
        found = json.loads((place / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        if found["format"] != FORMAT:
            raise KeyError("format")
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = "does not exist" if not place.exists() else "is none" if not isinstance(error, OSError) else str(error)
        raise StoreError(f"`{path}` must be a store of tippetop, but {why}.") from None
    if found.get("format_version") != FORMAT_VERSION:
        raise StoreError(
            f"`{path}` must have format version {FORMAT_VERSION}, but has {found.get('format_version')}: "
            "use the release that wrote it."
        )
    if found.get("status") == "running":
        try:
            record = json.loads((place / CHECKPOINT).read_text(encoding="utf-8"))
            found |= {"report": record["report"], "reason": record["reason"]}
        except (OSError, ValueError, KeyError):
            pass  # it just finished, or never began: the root attributes stand
    return found


def annotate(path: str | Path, more: dict[str, Any]) -> None:
    """Adds root attributes to a finished store."""
    place = Path(path) / "zarr.json"
    content = json.loads(place.read_text(encoding="utf-8"))
    content["attributes"] |= finite(more)
    replace_text(place, json.dumps(content, indent=2, allow_nan=False))


def open_group(path: str | Path, group: str) -> "xr.Dataset":
    """A group of a store as a labelled Dataset, read when needed. Raises StoreError."""
    import xarray as xr

    attrs = attributes(path)
    try:
        return xr.open_zarr(Path(path), group=group, consolidated=False, chunks=None).assign_attrs(attrs)
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


@lru_cache
def versions() -> dict[str, str]:
    """Versions of what a result depends on."""
    found = {"python": platform.python_version()}
    for name in ("tippetop", "heyoka", "numpy", "zarr"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


@lru_cache
def cpu() -> str:
    """The model of this machine's processor: results are bit-identical only on the same one."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def provenance() -> dict[str, Any]:
    """What every store says of its making."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "Conventions": "CF-1.11",
        "versions": versions(),
        "cpu": cpu(),
        "threads": 1,
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors",
    }
