"""What a power failure may not undo: in which order things reach the disk, and what a failing disk leaves."""

import errno
import os
from pathlib import Path

import pytest

from tippetop.errors import StoreError
from tippetop.store import files


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_failure_at_any_step_leaves_the_old_text(step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.json"
    files.replace_text(path, "old")

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, step, fail)
        with pytest.raises((OSError, StoreError), match="No space left"):
            files.replace_text(path, "new")
    assert path.read_text() == "old"
    files.replace_text(path, "new")
    assert path.read_text() == "new"


def test_the_text_is_on_the_disk_before_it_has_its_name_and_the_folder_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The order in which a power failure can do no harm."""
    order, fsync, replace = [], os.fsync, os.replace

    def synced(descriptor: int) -> None:
        order.append("folder" if Path(f"/proc/self/fd/{descriptor}").resolve() == tmp_path.resolve() else "text")
        fsync(descriptor)

    def named(*paths: object) -> None:
        order.append("name")
        replace(*paths)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", named)
    files.replace_text(tmp_path / "a.json", "x")
    assert order == ["text", "name", "folder"]


def test_a_folder_that_cannot_be_synced_is_let_be_and_a_file_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("x")

    def refuse(_: int) -> None:
        raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(os, "fsync", refuse)
    files.synced(tmp_path)
    with pytest.raises(OSError, match="Invalid argument"):
        files.synced(tmp_path / "file")
