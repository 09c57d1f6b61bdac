"""A disk in memory on which operations fail, or power is lost, wherever a test wants it.

Content is durable after a sync of its file, names after a sync of their folder, in any order
before.
"""

import errno
import random
from pathlib import Path

from tippetop.store.folder import Folder


class PowerLost(BaseException):
    """The machine is off: nothing catches it."""


class _File:
    def __init__(self) -> None:
        self.data, self.durable = b"", b""


class ModelFolder(Folder):
    """A folder on such a disk.

    Operation number `fault[1]` fails ("fail") or is the last ("power").
    """

    threads = 1

    def __init__(self) -> None:
        self.unsynced = set()
        self.now: dict[str, _File] = {}
        self.kept: dict[str, _File] = {}
        self.folders, self.kept_folders = {""}, {""}
        self.journal: list[
            tuple[str, str, str, object]
        ] = []  # folder, what, name, more: not on the disk yet
        self.count, self.fault, self.off = 0, ("", 0), False
        self.random = random.Random(0)

    def _operate(self) -> bool:
        """Count an operation; whether it is cut off in the middle."""
        if self.off:
            raise PowerLost
        self.count += 1
        return bool(self.fault[0]) and self.count == self.fault[1]

    def _fail(self) -> None:
        if self.fault[0] == "fail":
            raise OSError(errno.ENOSPC, "No space left on device")
        self.off = True
        raise PowerLost

    def mkdir(self, name: str) -> None:
        if self._operate():
            self._fail()
        if name not in self.folders:
            self.folders.add(name)
            self.journal.append((name.rpartition("/")[0], "mkdir", name, None))
        self.unsynced.add(name.rpartition("/")[0])

    def put(self, name: str, data: bytes, how: int = 0) -> None:
        self._store(name, b"" if how == 0 else self.now[name].data, data, cut=self._operate())

    def append(self, name: str, data: bytes) -> None:
        self.put(name, data, 1)

    def _store(self, name: str, before: bytes, data: bytes, *, cut: bool) -> None:
        if name.rpartition("/")[0] not in self.folders:
            raise FileNotFoundError(name)
        if name not in self.now:
            self.now[name] = _File()
            self.journal.append((name.rpartition("/")[0], "name", name, self.now[name]))
        self.now[name].data = before + (
            data[: self.random.randrange(len(data) + 1)] if cut else data
        )
        if cut:
            self._fail()

    def rename(self, old: str, new: str) -> None:
        if self._operate():
            self._fail()
        self.now[new] = self.now.pop(old)
        self.journal.append((old.rpartition("/")[0], "rename", old, (new, self.now[new])))

    def remove(self, name: str) -> None:
        if self._operate():
            self._fail()
        if self.now.pop(name, None):
            self.journal.append((name.rpartition("/")[0], "remove", name, None))

    def read(self, name: str) -> bytes:
        if name not in self.now:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", name)
        return self.now[name].data

    def tip(self, name: str) -> tuple[int, bytes]:
        data = self.read(name)
        return len(data), data[-4:]

    def names(self, name: str) -> list[str]:
        within = f"{name}/" if name else ""
        return sorted(
            {
                path.removeprefix(within).partition("/")[0]
                for path in self.now
                if path.startswith(within)
            }
        )

    def lock(self, name: str) -> int:
        self.read(name)
        return 0

    def release(self, held: int) -> None:
        pass

    def is_at(self, place: Path, held: int) -> bool:
        return True

    def sync_one(self, name: str) -> None:
        if self._operate():
            self._fail()
        if name in self.now:
            self.now[name].durable = self.now[name].data
            return
        if name not in self.folders:
            raise FileNotFoundError(name)
        for entry in [entry for entry in self.journal if entry[0] == name]:
            self._apply(entry)
            self.journal.remove(entry)

    def _apply(self, entry: tuple[str, str, str, object]) -> None:
        _, what, name, more = entry
        if what == "mkdir":
            self.kept_folders.add(name)
        elif what == "name":
            self.kept[name] = more  # type: ignore[assignment]
        else:
            self.kept.pop(name, None)
        if what == "rename":
            new, file = more  # type: ignore[misc]
            self.kept[new] = file

    def crash(self, seed: int) -> None:
        """Leave what a disk may have after a power failure: any part of what was not synced."""
        chance = self.random = random.Random(seed)
        for entry in self.journal:
            if chance.random() < 0.5:
                self._apply(entry)
        for file in {*self.kept.values(), *self.now.values()}:
            if file.data != file.durable:
                least = len(file.durable) if file.data.startswith(file.durable) else 0
                cut = chance.randrange(least, len(file.data) + 1)
                torn = [
                    file.durable,
                    file.data,
                    file.data[:cut],
                    file.data[:cut] + bytes(len(file.data) - cut),
                ]
                file.durable = chance.choice(torn)
            file.data = file.durable
        whole = {name for name in self.kept_folders if self._parents(name) <= self.kept_folders}
        self.folders, self.kept_folders = whole, set(whole)
        self.kept = {
            name: file for name, file in self.kept.items() if name.rpartition("/")[0] in whole
        }
        self.now, self.journal = dict(self.kept), []
        self.again()

    @staticmethod
    def _parents(name: str) -> set[str]:
        return {name[:i] for i, letter in enumerate(name) if letter == "/"}

    def again(self) -> None:
        """Begin anew, as another process does, without a fault."""
        self.count, self.fault, self.off = 0, ("", 0), False
        self.unsynced = set()

    def tree(self) -> dict[str, bytes]:
        return {name: file.data for name, file in self.now.items()}
