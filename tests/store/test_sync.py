"""Test the order in which data reach the disk, and a disk that fails."""

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from stores import Disk, short_slices
from typed import typed

import tippetop
from tippetop.errors import StoreError
from tippetop.store import files, root
from tippetop.store.folder import Folder


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    return Disk(monkeypatch)


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


RUN = "run inverting --until 0.1 --set run.columns=\"['theta']\" --out"


@pytest.mark.parametrize(
    "command",
    [
        RUN,
        "run inverting --until 0.1 --set run.output=keyframes --out",
        "run inverting --until 0.05 --set friction.law=coulomb --set friction.mu=0.3 --out",
        "potential inverting --D=3e-4 --lambda=4e-6 --n=400 --out",
        "surface inverting --D=-1e-4:1e-4:20 --lambda=0:1e-5:30 --out",
        "sweep PLAN.toml --workers 1 --out",
    ],
)
def test_a_finished_store_is_on_the_disk(
    command: str,
    file: Path,
    disk: Disk,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Every file and every folder, the folder in which the store lies too."""
    monkeypatch.chdir(file.parent)
    assert typed(f"{command} S.zarr") == 0
    assert disk.late(Path("S.zarr")) == []
    assert Path() not in disk.late(Path())


def test_so_is_what_is_made_from_a_store(
    tmp_path: Path,
    disk: Disk,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A replay, a copy, and a run that was continued into larger chunks."""
    short_slices(monkeypatch)
    run = tippetop.run("inverting", output_step=0.001, until=0.5)
    run.save(tmp_path / "saved")
    times = "--from 0.1 --until 0.2 --step 0.01"
    assert typed(f"replay {tmp_path}/saved {times} --out {tmp_path}/rows") == 0
    monkeypatch.setattr("tippetop.runs.recording.COMMIT_EVERY", 0.0)
    tippetop.resume(tmp_path / "saved", until=2.0)
    assert [disk.late(tmp_path / name) for name in ("saved", "rows")] == [[], []]


def test_a_store_takes_the_place_of_another_before_that_one_goes(
    tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    removed, late = shutil.rmtree, []

    def watched(path: Path, **how: bool) -> None:
        if path.parent == tmp_path:
            late.append(tmp_path in disk.late(tmp_path))
        removed(path, **how)

    words = f"{RUN} {tmp_path}/S.zarr"
    assert typed(words) == 0
    monkeypatch.setattr("shutil.rmtree", watched)
    assert typed(f"{words} --overwrite") == 0
    assert set(late) == {False}


# --- a failing disk: error messages ---


def failing(number: int) -> Callable[..., None]:
    """An operation of the disk that fails."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number))

    return fail


def test_a_disk_without_room_for_a_folder_is_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before, "No such file or directory"."""
    real = os.mkdir

    def mkdir(*place: Any, **how: Any) -> None:
        (failing(errno.ENOSPC) if "dir_fd" in how else real)(*place, **how)

    monkeypatch.setattr(os, "mkdir", mkdir)
    assert typed(f"{RUN} {tmp_path}/S.zarr") == 5
    assert "S.zarr` must be writable, but: No space left on device." in capsys.readouterr().err


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
    capsys: pytest.CaptureFixture[str],
) -> None:
    store = shutil.copytree(whole, tmp_path / "S.zarr")
    monkeypatch.setattr("tippetop.sweeps.sweep_summary.report", failing(errno.EIO))
    assert typed(f"sweep {file} --out {store} --workers 1") == 5
    assert "was finished" not in capsys.readouterr().err
