"""Faults of a real disk, on purpose: one operation on a file below a folder fails, or is the last
one.

Ways: "once" (an error), "full" (half a write, and no room from then on), "killed" (half a write,
and nothing more), "power" (the same, and all that was not synced is gone), "names" (the same, but
names are kept: their files are empty), "some" (of each folder and file what is synced or what is
there, or a part of it). In these an operation that changes the disk has the fault;
in "reads", "files" and "locks" one that reads, that opens anything, or that locks fails once.
"""

import errno
import fcntl
import os
import random
import shutil
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


WAYS = ("once", "full", "killed", "power", "names", "some", "reads", "files", "locks")
GROWS = ("open", "write", "mkdir", "link")
SCANDIR = os.scandir  # without faults
# way -> the operations one of which fails once, and how
ONCE = {
    "reads": (("read", "pread", "listdir", "scandir"), errno.EIO),
    "files": (("read", "open"), errno.EMFILE),
    "locks": (("flock",), errno.ENOLCK),
}
CHANGES = (
    *("open", "write", "fsync", "rename", "replace", "mkdir", "unlink", "remove", "rmdir", "link"),
)


class Over(BaseException):
    """The process is gone: nothing that it does reaches the disk any more."""


class Faults:
    """The disk below a folder; all that is there at first is durable."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, root: Path):
        self.root, self.count, self.at, self.way = root, 0, 0, ""
        self.durable: dict[
            int, Any
        ] = {}  # by inode: the content of a file, the names and inodes in a folder
        self.held: list[int] = []  # so that no inode is used again
        self.arm(0, "")
        for name in (*CHANGES, "pread", "listdir", "scandir"):
            monkeypatch.setattr(os, name, self._watched(name, getattr(os, name)))
        monkeypatch.setattr(fcntl, "flock", self._watched("flock", fcntl.flock))

    def arm(self, at: int, way: str) -> None:
        """Let operation `at` from here on be the one with the fault."""
        self.durable, self.count = {}, 0
        self.at, self.way = 0, ""
        for descriptor in self.held:
            os.close(descriptor)
        self.held = []
        for place in (self.root, *self.root.rglob("*")):
            descriptor = os.open(place, os.O_RDONLY)
            self._sync(descriptor)
            os.close(descriptor)
        self.at, self.way = at, way

    def disarm(self) -> None:
        """Begin anew without faults, as another process does; after a power failure, with what is
        durable.
        """
        way, self.way = self.way, ""
        if way in ("power", "names", "some") and self.count >= self.at:
            tree = {str(p.relative_to(self.root)): self._kept(p) for p in self.root.rglob("*")}
            if way != "names":
                here = {p.stat().st_ino: p for p in (self.root, *self.root.rglob("*"))}
                here = here if way == "some" else {}
                tree = dict(self._below(self.root.stat().st_ino, "", here, random.Random(self.at)))
            shutil.rmtree(self.root)
            self.root.mkdir()
            for name, data in tree.items():
                place = self.root / name
                place.mkdir(parents=True, exist_ok=True) if data is None else place.write_bytes(
                    data
                )

    def _kept(self, place: Path) -> bytes | None:
        return None if place.is_dir() else self.durable.get(place.stat().st_ino, b"")

    def _below(self, inode: int, path: str, here: dict[int, Path], chance: random.Random) -> Any:
        """Names and contents in a folder that are durable, or by chance those that are here."""
        names = self.durable.get(inode, {})
        if inode in here and chance.random() < 0.5:
            names = {p.name: (p.stat().st_ino, p.is_dir()) for p in here[inode].iterdir()}
        for name, (child, folder) in names.items():
            data = None if folder else self.durable.get(child, b"")
            if not folder and child in here:
                now = here[child].read_bytes()
                data = chance.choice(
                    [data, now, now[: max(len(data), chance.randrange(len(now) + 1))]]
                )
            yield f"{path}{name}", data
            if folder:
                yield from self._below(child, f"{path}{name}/", here, chance)

    def _sync(self, descriptor: int) -> None:
        status = os.fstat(descriptor)
        self.held.append(os.dup(descriptor))
        if stat.S_ISDIR(status.st_mode):
            with SCANDIR(descriptor) as entries:
                self.durable[status.st_ino] = {
                    e.name: (e.inode(), e.is_dir(follow_symlinks=False)) for e in entries
                }
        else:
            self.durable[status.st_ino] = Path(f"/proc/self/fd/{descriptor}").read_bytes()

    def _is_below(self, place: Any, how: dict[str, Any]) -> bool:
        if isinstance(place, int):
            path = os.readlink(f"/proc/self/fd/{place}")
        else:
            folder = how.get("dir_fd", how.get("src_dir_fd"))
            base = "." if folder is None else os.readlink(f"/proc/self/fd/{folder}")
            path = os.path.abspath(os.path.join(base, place))
        return f"{path}/".startswith(f"{self.root}/")

    def _judge(self, name: str, half: Callable[[], object] = lambda: None) -> None:
        kinds, number = ONCE.get(self.way, (CHANGES, errno.EIO))
        if name not in kinds:
            return
        self.count += 1
        once = self.way == "once" or self.way in ONCE
        if not self.way or self.count < self.at or (once and self.count > self.at):
            return
        if once:
            raise OSError(number, os.strerror(number))
        if self.count == self.at:
            half()
        if self.way != "full":
            raise Over
        if name in GROWS:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def _watched(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def operation(*given: Any, **how: Any) -> Any:
            reads = name == "open" and not given[1] & (os.O_CREAT | os.O_WRONLY)
            watched = self._is_below(given[0] if given else ".", how)
            if watched:
                half = (
                    (lambda: real(given[0], given[1][: len(given[1]) // 2]))
                    if name == "write"
                    else lambda: None
                )
                self._judge("read" if reads else name, half)
            result = real(*given, **how)
            if watched and name == "fsync":
                self._sync(given[0])
            return result

        return operation
