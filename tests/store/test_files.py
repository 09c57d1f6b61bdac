"""Test that files and folders appear whole or not at all, and replace nothing unasked."""

import contextlib
import errno
import os
import signal
import stat
import warnings
from pathlib import Path
from unittest.mock import Mock

import pytest
from forked import Forked

from tippetop.errors import StoreError
from tippetop.store import files, ledger, provenance, root
from tippetop.store.ledger import LEDGER, Ledger
from tippetop.store.root import new_store


class Stop(Exception):
    """Something ends the block."""


def made_store(path: Path, title: str = "old", **how: bool) -> Path:
    """A store of ours with nothing in it."""
    with new_store(path, **how) as scratch:
        Ledger.created(
            scratch, ledger.header({**provenance.provenance(), "title": title}, {})
        ).release()
    return path


def content(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# --- files ----------------------------------------------------------------------------------------


def killed(code: str) -> bool:
    """Whether Python that runs in a process of its own was killed."""
    process = Forked(prelude=code)
    process.communicate()
    return process.returncode == -signal.SIGKILL


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(Stop), files.replacing(path) as scratch:
        scratch.write_text("half")
        raise Stop
    assert path.read_text() == "old"
    with files.replacing(path) as scratch:
        scratch.write_text("new")
    assert path.read_text() == "new"
    assert content(tmp_path) == ["a.txt"]


def test_a_file_that_came_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with (
        pytest.raises(StoreError, match="must not exist yet"),
        files.replacing(path, overwrite=False) as scratch,
    ):
        scratch.write_text("mine")
        path.write_text("yours")
    assert path.read_text() == "yours"
    with (
        pytest.raises(StoreError, match="must not exist yet"),
        files.replacing(path, overwrite=False),
    ):
        pass
    assert content(tmp_path) == ["a.csv"]


def test_a_link_is_replaced_and_not_what_it_points_to(tmp_path: Path) -> None:
    elsewhere, path = tmp_path / "elsewhere", tmp_path / "a.txt"
    elsewhere.write_text("precious")
    path.symlink_to(elsewhere)
    with files.replacing(path) as scratch:
        scratch.write_text("new")
    assert (elsewhere.read_text(), path.read_text(), path.is_symlink()) == (
        "precious",
        "new",
        False,
    )


def test_only_a_file_is_overwritten(tmp_path: Path) -> None:
    """Neither a pipe or a device (as /dev/full), which would be a file afterwards, nor a folder."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path, Path(), Path("/")):
        with (
            pytest.raises(StoreError, match=r"must be (a file|the name of a file)"),
            files.replacing(path),
        ):
            pass
    assert stat.S_ISFIFO(os.lstat(pipe).st_mode)
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_disk_that_fails_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(
        StoreError, match=r"^`a` must be writable, but: No space left on device. Buy one.$"
    ):
        with files.writing("a", "Buy one."):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(StoreError, match=r"^as it was$"), files.writing("a"):
        raise StoreError("as it was")


# --- folders --------------------------------------------------------------------------------------


def test_of_two_that_make_one_store_the_first_wins_and_the_second_is_told(tmp_path: Path) -> None:
    """Both began when there was none."""
    path = tmp_path / "S.zarr"
    with pytest.raises(StoreError, match="another process has made it"), new_store(path) as scratch:
        (scratch / "second").write_text("")
        made_store(path, "first")
    assert '"title": "first"' in (path / "zarr.json").read_text()
    assert content(tmp_path) == ["S.zarr"]


KILLED = """
import os
from pathlib import Path
from tippetop.store.root import new_store
with new_store(Path({path!r}), overwrite=True) as scratch:
    (scratch / "half").write_text("")
    os.kill(os.getpid(), 9)
"""


def test_what_a_killed_overwrite_leaves_beside_a_store_goes_with_the_next(tmp_path: Path) -> None:
    path = made_store(tmp_path / "S.zarr")
    assert killed(KILLED.format(path=str(path)))
    (stale,) = (p for p in tmp_path.iterdir() if p != path)
    others = [tmp_path / name for name in (".S.zarr.part-mine", ".T.zarr.part-" + "0" * 32)]
    for other in others:
        other.mkdir()
    with (
        pytest.warns(UserWarning, match="a killed run left it") as warned,
        new_store(path, overwrite=True) as scratch,
    ):
        (scratch / "new").write_text("")
    assert [str(w.message) for w in warned] == [f"`{stale}` is removed: a killed run left it."]
    assert sorted(tmp_path.iterdir()) == sorted([path, *others])


KILLED_AT = """
import os, shutil
from pathlib import Path
from test_files import made_store
from tippetop.store import files
{place} = lambda *_, **__: os.kill(os.getpid(), 9)
made_store(Path({path!r}), "new", overwrite=True)
"""


@pytest.mark.parametrize(
    ("place", "remains"), [("files.rename_new", "old"), ("shutil.rmtree", "new")]
)
def test_an_overwrite_that_is_killed_leaves_one_store_whole(
    place: str, remains: str, tmp_path: Path
) -> None:
    """Between its two renames the old one, which is put back, and after them the new one."""
    path = made_store(tmp_path / "S.zarr")
    assert killed(KILLED_AT.format(place=place, path=str(path)))
    assert len(content(tmp_path)) > 1
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "`.*S.zarr.*` is (put back|removed): a killed run")
        with pytest.raises(StoreError, match="must not exist yet"):
            made_store(path)
        assert root.attributes(path)["title"] == remains
        made_store(path, "newest", overwrite=True)
    assert content(tmp_path) == ["S.zarr"]


def test_an_old_store_is_kept_until_another_program_frees_its_place(tmp_path: Path) -> None:
    path = made_store(tmp_path / "S.zarr")
    assert killed(KILLED_AT.format(place="files.rename_new", path=str(path)))
    path.mkdir()
    with pytest.raises(StoreError, match="must not exist yet"):
        made_store(path)
    path.rmdir()
    with pytest.warns(UserWarning, match="put back"):
        files.put_back(path)
    assert root.attributes(path)["title"] == "old"


def test_a_store_that_is_being_written_is_not_overwritten(tmp_path: Path) -> None:
    path = made_store(tmp_path / "S.zarr")
    with (
        Ledger.opened(path),
        pytest.raises(StoreError, match=rf"process {os.getpid()} on .* is writing it"),
    ):
        with new_store(path, overwrite=True):
            pass
    assert content(path) == [LEDGER, "zarr.json"]


def test_nobody_begins_to_write_a_store_while_it_is_overwritten(tmp_path: Path) -> None:
    path = made_store(tmp_path / "S.zarr")
    with new_store(path, overwrite=True) as scratch:
        (scratch / "new").write_text("")
        with pytest.raises(StoreError, match="must have one writer"):
            Ledger.opened(path)
    assert content(path) == ["new"]


def test_a_link_is_no_place_for_a_store(tmp_path: Path) -> None:
    path = tmp_path / "link.zarr"
    path.symlink_to(made_store(tmp_path / "S.zarr"))
    for overwrite in (False, True):
        with pytest.raises(StoreError, match="is a link"), new_store(path, overwrite=overwrite):
            pass
    path.unlink()
    path.symlink_to(tmp_path / "nowhere")
    with pytest.raises(StoreError, match="is a link"), new_store(path):
        pass


@pytest.mark.parametrize("aside", [False, True])
def test_only_a_store_of_ours_is_replaced(aside: bool, tmp_path: Path) -> None:
    """Another folder stays, where the name of its ledger is ours, and also under a name aside."""
    path, foreign = tmp_path / "S.zarr", tmp_path / (".S.zarr.replaced" if aside else "S.zarr")
    foreign.mkdir()
    (foreign / LEDGER).write_text("0123456789abcdef of another program")
    (foreign / "notes").write_text("precious")
    if aside:
        made_store(path)
    with contextlib.suppress(StoreError):
        made_store(path, "new", overwrite=True)
    assert (foreign / "notes").read_text() == "precious"
    assert content(tmp_path) == sorted({"S.zarr", foreign.name})


@pytest.mark.parametrize("name", [".", "/"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_folder_without_a_name_is_no_place_for_a_store(name: str, overwrite: bool) -> None:
    with pytest.raises(StoreError, match=r"^`[./]` must be the name of a new store, such as"):
        made_store(Path(name), overwrite=overwrite)


def test_a_disk_that_fails_after_the_exchange_leaves_the_new_store_and_its_own_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, error = made_store(tmp_path / "S.zarr"), OSError(errno.EIO, os.strerror(errno.EIO))
    with monkeypatch.context() as patch, pytest.raises(StoreError, match="Input/output error"):
        patch.setattr(files, "synced", Mock(side_effect=error))
        made_store(path, "new", overwrite=True)
    assert root.attributes(path)["title"] == "new"
    made_store(path, "newest", overwrite=True)
    assert content(tmp_path) == ["S.zarr"]


# --- the lock -------------------------------------------------------------------------------------


def test_a_killed_holder_leaves_a_free_lock(tmp_path: Path) -> None:
    path = made_store(tmp_path / "S.zarr")
    code = "import os; from pathlib import Path; from tippetop.store.ledger import Ledger; "
    assert killed(code + f"lock = Ledger.opened(Path({str(path)!r})); os.kill(os.getpid(), 9)")
    with Ledger.opened(path) as lock:
        lock.check()


@pytest.mark.parametrize("fate", ["moved", "removed", "replaced"])
def test_a_writer_learns_that_its_folder_is_gone(fate: str, tmp_path: Path) -> None:
    folder = made_store(tmp_path / "S")
    with Ledger.opened(folder) as lock:
        lock.check()
        if fate == "removed":
            (folder / LEDGER).unlink()
        else:
            folder.rename(tmp_path / "elsewhere")
        if fate == "replaced":
            made_store(folder)
        with pytest.raises(StoreError, match="was moved, removed or replaced"):
            lock.check()


def test_a_place_that_cannot_be_read_is_not_called_moved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Ledger.opened(made_store(tmp_path / "S")) as lock:
        with monkeypatch.context() as patch, pytest.raises(OSError, match="Stale"):
            error = OSError(errno.ESTALE, os.strerror(errno.ESTALE))
            patch.setattr(os, "lstat", Mock(side_effect=error))
            lock.check()
        lock.check()


@pytest.mark.parametrize("number", [errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK, errno.EMFILE])
def test_without_locks_files_are_written_and_a_store_names_what_is_missing(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing hidden stays behind, whatever fails."""
    error = OSError(number, os.strerror(number))
    monkeypatch.setattr("fcntl.flock", Mock(side_effect=error))
    lacks = number != errno.EMFILE
    with pytest.raises(StoreError, match=r"no locks \(flock\)" if lacks else "Too many open files"):
        made_store(tmp_path / "S.zarr")
    with contextlib.nullcontext() if lacks else pytest.raises(StoreError, match="Too many"):
        files.write_text(tmp_path / "x.toml", "new", overwrite=False)
    assert content(tmp_path) == ["x.toml"] * lacks


@pytest.mark.parametrize("inside", ["trajectory", "zarr.json", "pipe"])
def test_nothing_inside_a_store_is_followed_when_it_is_written(inside: str, tmp_path: Path) -> None:
    path, elsewhere = made_store(tmp_path / "S.zarr"), tmp_path / "elsewhere"
    (path / "trajectory").mkdir()
    if inside == "pipe":
        os.mkfifo(path / inside)
    else:
        (path / inside).rename(elsewhere)
        (path / inside).symlink_to(elsewhere)
    with pytest.raises(StoreError, match="neither followed nor written"):
        files.refuse_links(path)


KILLED_EXPORT = """
import os
from pathlib import Path
from tippetop.store.files import replacing
with replacing(Path({path!r})) as scratch:
    scratch.write_text("half")
    os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize("there", [False, True])
def test_what_a_killed_writer_of_a_file_leaves_goes_with_the_next(
    there: bool, tmp_path: Path
) -> None:
    """Before, it stayed for ever; also where the next is refused because the file is there."""
    path = tmp_path / "a.csv"
    assert killed(KILLED_EXPORT.format(path=str(path)))
    (stale,) = tmp_path.iterdir()
    if there:
        path.write_text("whole")
    with pytest.warns(UserWarning, match=f"{stale.name}` is removed: a killed run left it"):
        with contextlib.suppress(StoreError), files.replacing(path, overwrite=False) as scratch:
            scratch.write_text("whole")
    assert path.read_text() == "whole"
    assert content(tmp_path) == ["a.csv"]


def test_a_file_that_another_process_is_writing_is_not_stale(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with files.replacing(path) as scratch:
        files.remove_stale(path)
        scratch.write_text("mine")
        with files.replacing(path) as other:
            other.write_text("yours")
    assert path.read_text() == "mine"


# --- what a user names ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["zarr.json", "time/x.csv", "new.zarr"])
def test_no_target_lies_in_a_store(name: str, tmp_path: Path) -> None:
    """Nor by way of a link, or of `..`; the store stays as it is."""
    store = made_store(tmp_path / "a.zarr")
    (store / "time").mkdir()
    (tmp_path / "link").symlink_to(store)
    before = (store / "zarr.json").read_bytes()
    for place in (store, tmp_path / "link", store / ".." / "a.zarr"):
        with (
            pytest.raises(StoreError, match="must lie outside of every store"),
            files.replacing(place / name),
        ):
            raise AssertionError
        with (
            pytest.raises(StoreError, match="must lie outside of every store"),
            new_store(place / name),
        ):
            raise AssertionError
    assert content(store) == [LEDGER, "time", "zarr.json"]
    assert (store / "zarr.json").read_bytes() == before
