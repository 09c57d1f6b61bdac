"""Test the words about a disk that fails."""

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typed import refused

from tippetop.errors import StoreError
from tippetop.store import files, root
from tippetop.store.folder import Folder


def test_a_folder_that_cannot_be_synced_is_let_be_and_a_file_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("x")

    def refuse(_: int) -> None:
        raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(os, "fsync", refuse)
    files.synced(tmp_path)
    with pytest.raises(OSError, match="Invalid argument"):
        files.synced(tmp_path, "file")


# --- a failing disk: error messages ---


def failing(number: int) -> Callable[..., None]:
    """An operation of the disk that fails."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number))

    return fail


RUN = "run inverting --until 0.1 --out"


def test_a_disk_without_room_for_a_folder_is_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, "No such file or directory"."""
    real = os.mkdir

    def mkdir(*place: Any, **how: Any) -> None:
        (failing(errno.ENOSPC) if "dir_fd" in how else real)(*place, **how)

    monkeypatch.setattr(os, "mkdir", mkdir)
    assert "S.zarr` must be writable, but: No space left on device." in refused(
        f"{RUN} {tmp_path}/S.zarr", 5
    )


def test_an_unreadable_disk_is_not_a_damaged_store(
    whole: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Folder, "tip", failing(errno.EIO))
    with pytest.raises(StoreError, match=r"S.zarr` must be readable, but: Input/output error"):
        root.attributes(whole)


def test_a_sweep_that_cannot_be_read_is_not_said_to_be_checked(
    file: Path,
    whole: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    store = shutil.copytree(whole, tmp_path / "S.zarr")
    monkeypatch.setattr("tippetop.sweeps.sweep_summary.report", failing(errno.EIO))
    assert "was finished" not in refused(f"sweep {file} --out {store} --workers 1", 5)
