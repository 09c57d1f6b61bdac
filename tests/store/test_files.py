"""Files appear whole or not at all; a store has one writer, and the system frees the lock of one that was killed."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tippetop.errors import StoreError
from tippetop.store import files


HOLD = """
import sys, time
from pathlib import Path
from tippetop.store import files
held = files.locked(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(60)
"""


def holder(folder: Path) -> subprocess.Popen:
    """A process that holds the lock of a folder."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_a_folder_has_one_writer_and_a_killed_one_leaves_it_free(tmp_path: Path) -> None:
    with holder(tmp_path) as process:
        with pytest.raises(StoreError, match=f"must have one writer, but process {process.pid} on .* is writing it"):
            files.locked(tmp_path)
        process.send_signal(signal.SIGKILL)
        process.wait()
    files.locked(tmp_path)
    with pytest.raises(StoreError, match=f"process {os.getpid()} on"):
        files.locked(tmp_path)


def test_folders_have_locks_of_their_own(tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        files.locked(tmp_path / name)


def test_a_text_is_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    for text in ("λ first", "second, longer than the first", ""):
        files.replace_text(path, text)
        assert path.read_text(encoding="utf-8") == text
        assert list(tmp_path.iterdir()) == [path]


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


def test_scratch_files_of_a_killed_writer_go_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "c").mkdir()
    keep = [tmp_path / "zarr.json", tmp_path / "c" / "0", tmp_path / "c" / "partial"]
    gone = [tmp_path / ".checkpoint.json.part", tmp_path / "c" / "0.abc.partial"]
    for path in (*keep, *gone):
        path.write_text("x")
    files.sweep(tmp_path)
    assert [path.exists() for path in keep] == [True] * 3
    assert [path.exists() for path in gone] == [False] * 2
