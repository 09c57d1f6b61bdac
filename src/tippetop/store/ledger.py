"""What is acknowledged in a store: an append-only file of records, each with a digest of itself and
of the one before.

The first record is the header: the attributes of the store, the documents of its groups and
arrays, and which arrays make a table. Every further record acknowledges chunks, and a tail: the
rows that do not fill a chunk, and the state of a run. Acknowledged chunks never change. Whatever
else is in the store is derived, and made again when the store is opened to be written, or was
never acknowledged, and is removed.

A finished store has a ledger of two records, the header and the seal: equal runs leave equal files.
"""

import contextlib
import dataclasses
import hashlib
import itertools
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import StoreError
from . import zarr3
from .folder import NEW, Folder
from .provenance import FORMAT_VERSION
from .zarr3 import CHECKSUM, DOCUMENT


LEDGER = "ledger.jsonl"
TAIL = "tail-"
DIGITS = 16  # hexadecimal, of a digest
PATH = re.compile(
    r"[^./\0][^/\0]*(/[^./\0][^/\0]*)?"
)  # of a group or an array: of nothing outside the store
CHUNK = re.compile(r"\d+(\.\d+)*")
WHOLE = "tippetop resume, or the command that wrote it, completes it"


class Damaged(Exception):
    """What a ledger or an acknowledged file is not."""


@dataclass
class Acknowledged:
    """What the records of a ledger add up to."""

    header: dict[str, Any]
    attributes: dict[str, Any]  # of the root group
    chunks: dict[str, str] = field(default_factory=dict)  # TABLE/INDEX -> mark
    failed: dict[str, str] = field(
        default_factory=dict
    )  # TABLE/INDEX -> why it could not be computed
    rows: dict[str, int] = field(default_factory=dict)  # of the tables that grow
    tail: list[str] = field(default_factory=list)  # name and mark
    end: Any = None  # where a finished run can be continued
    changed: dict[str, Any] = field(
        default_factory=dict
    )  # attributes that the header has otherwise
    writer: str = "another process"
    closing: bool = False  # whether all is acknowledged
    seal: bool = False  # and the ledger has its last form

    @classmethod
    def of(cls, records: list[dict[str, Any]]) -> "Acknowledged":
        """Add up the records of a ledger."""
        state = cls(records[0], dict(records[0]["attributes"]))
        for record in records[1:]:
            state.add(record)
        return state

    def add(self, record: dict[str, Any]) -> None:
        """Add one record."""
        self.chunks |= record.get("chunks", {})
        self.failed |= record.get("failed", {})
        self.failed = {
            key: sentence for key, sentence in self.failed.items() if key not in self.chunks
        }
        self.changed = ({} if "closing" in record else self.changed) | record.get("changed", {})
        self.attributes = self.header["attributes"] | self.changed
        for name in ("rows", "tail", "end", "writer", "closing"):
            setattr(self, name, record.get(name, getattr(self, name)))
        self.seal = "seal" in record

    def record(self, *names: str) -> dict[str, Any]:
        """Return these fields as a record, without those that are empty."""
        return {name: value for name in names if (value := getattr(self, name))}

    def documents(self) -> dict[str, dict[str, Any]]:
        """Return the document of every array and group by its path; that of the root last, its path
        empty.
        """
        members = {path: dict(document) for path, document in self.header["members"].items()}
        for table, rows in self.rows.items():
            for path in self.header["tables"][table]:
                members[path]["shape"] = [rows, *members[path]["shape"][1:]]
        return {**members, "": zarr3.group(self.attributes, members)}

    def unsealed(self, rows_of: dict[str, int]) -> Iterator[str]:
        """Yield the chunks of so many rows that only the tail acknowledges; what is in their files
        is derived.
        """
        for table, rows in rows_of.items():
            grid = self.header["members"][self.header["tables"][table][0]]["chunk_grid"]
            keys = (
                f"{table}/{k}" for k in range(-(-rows // grid["configuration"]["chunk_shape"][0]))
            )
            yield from (key for key in keys if key not in self.chunks)

    def files(self, key: str) -> list[str]:
        """Return the names of the files of a chunk."""
        table, _, index = key.partition("/")
        members, place = self.header["members"], list(map(int, index.split(".")))
        return [
            f"{path}/{zarr3.chunk_name(members[path], *place)}"
            for path in self.header["tables"][table]
        ]


def mark(tips: Mapping[str, tuple[int, bytes]]) -> str:
    """Return the mark of a chunk: a digest of name, size and last bytes of its files, which are
    their checksums.
    """
    whole = hashlib.sha256()
    for name, (size, tip) in sorted(tips.items()):
        whole.update(f"{name} {size} {tip.hex()}\n".encode())
    return whole.hexdigest()[:DIGITS]


def tip(data: bytes) -> tuple[int, bytes]:
    """Return the size and the last bytes of a file."""
    return len(data), data[-CHECKSUM:]


def mark_of_tail(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:DIGITS]


def _line(before: str, record: dict[str, Any]) -> tuple[str, bytes]:
    """Return the digest of a record, and its line."""
    body = json.dumps(record, allow_nan=False, separators=(",", ":")).encode()
    digest = hashlib.sha256(before.encode() + body).hexdigest()[:DIGITS]
    return digest, digest.encode() + b" " + body + b"\n"


def _lines(records: list[dict[str, Any]]) -> tuple[str, bytes]:
    """Return the digest of the last record, and the lines of a ledger."""
    before, whole = "", b""
    for record in records:
        before, line = _line(before, record)
        whole += line
    return before, whole


def records_of(raw: bytes) -> list[dict[str, Any]]:
    """Return the records of a ledger.

    A last line that is not whole was never acknowledged. Raises Damaged.
    """
    records: list[dict[str, Any]] = []
    before, lines = "", raw.split(b"\n")
    for number, line in enumerate(lines[:-1], 1):
        digest, _, body = line.partition(b" ")
        if digest != hashlib.sha256(before.encode() + body).hexdigest()[:DIGITS].encode():
            if any(lines[number:]):
                raise Damaged(f"line {number} of `{LEDGER}` is damaged")
            break
        records.append(json.loads(body))
        before = digest.decode()
    if not records:
        raise Damaged(f"`{LEDGER}` has no whole line")
    header = records[0]
    if header.get("format") != FORMAT_VERSION:
        raise Damaged(f"its format is {header.get('format')}: use the release that wrote it")
    keys = (key for record in records for key in record.get("chunks", {}))
    if not all(map(PATH.fullmatch, header["members"])) or any(
        key.partition("/")[0] not in header["tables"] or not CHUNK.fullmatch(key.partition("/")[2])
        for key in keys
    ):
        raise Damaged(f"`{LEDGER}` names what cannot be in a store")
    return records


def acknowledged(raw: bytes) -> Acknowledged:
    """Return what the bytes of a ledger acknowledge.

    Raises Damaged, and what records of another form raise.
    """
    state = Acknowledged.of(records_of(raw))
    state.documents()
    for key in [*state.chunks, *itertools.islice(state.unsealed(state.rows), 1)]:
        state.files(key)
    return state


def header(
    attributes: dict[str, Any], members: dict[str, Any], tables: dict[str, list[str]]
) -> dict[str, Any]:
    """Return the header of a new store.

    Parameters
    ----------
    attributes
        Of the root group.
    members
        The documents of groups and arrays by path; arrays that grow have no rows.
    tables
        Table -> the paths of the arrays whose chunks are written together.
    """
    return {
        "format": FORMAT_VERSION,
        "attributes": attributes,
        "members": members,
        "tables": tables,
    }


class Ledger:
    """The ledger of a store that is being written, locked. A context that releases the lock.

    Where an operation of the disk failed, nothing more is written: a page that could not be synced
    may look written and be lost.
    """

    def __init__(self, folder: Folder, path: Path):
        self.folder, self.path = folder, path
        self.state: Acknowledged
        self.pending: dict[
            str, dict[str, tuple[int, bytes]]
        ] = {}  # chunks that the next commit acknowledges
        self.broken: OSError | None = None
        self.laid_out = False  # whether all folders were made
        self.held: int | None = None

    @classmethod
    def created(
        cls, path: Path, head: dict[str, Any], folder: Folder | None = None, *, bare: bool = False
    ) -> "Ledger":
        """Make the store of a header in an empty folder. Raises OSError.

        One that is `bare` has its root document only, which contains all others, until rows are
        acknowledged: a short run takes less time so.
        """
        self = cls(folder or Folder(path), path)
        self.state = Acknowledged.of([json.loads(json.dumps(head))])
        with self._released_on_failure():
            if bare:
                self.folder.write(DOCUMENT, zarr3.dump(self.state.documents()[""]), derived=True)
            else:
                self._lay_out()
            self._compact()
        return self

    @classmethod
    def locked(cls, path: Path) -> "Ledger":
        """Lock a store that is to be replaced, and read nothing. Raises StoreError, OSError."""
        self = cls(Folder(path), path)
        self._lock()
        return self

    @classmethod
    def opened(cls, path: Path, folder: Folder | None = None) -> "Ledger":
        """Open a store to write it, as its ledger acknowledges it; one that was being finished is
        finished.

        Raises
        ------
        StoreError
            Another process writes it.
        OSError
            The disk.
        """
        self = cls(folder or Folder(path), path)
        with self._released_on_failure():
            self._lock()
            with sound(path):
                self.state = acknowledged(raw := self.folder.read(LEDGER))
            records = records_of(raw)
            self.before, whole = _lines(records)
            if (
                whole != raw
            ):  # after the last record: the beginning of one that was never acknowledged
                self._replace(records)
            self._lay_out()
            if not self.state.seal:
                self._complete() if self.state.closing else self._compact()
            self._tidy()
        return self

    @contextlib.contextmanager
    def _released_on_failure(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.release()
            raise

    def _lock(self) -> None:
        while not self.in_place():  # its last writer replaced it while we waited
            self.release()
            try:
                self.held = self.folder.lock(LEDGER)
            except BlockingIOError:
                with sound(self.path):
                    writer = acknowledged(self.folder.read(LEDGER)).writer
                raise StoreError(
                    f"`{self.path}` must have one writer, but {writer} is writing it."
                ) from None

    def in_place(self) -> bool:
        """Return whether the folder that is locked is still in its place."""
        return self.held is not None and self.folder.is_at(self.path / LEDGER, self.held)

    def check(self) -> None:
        """Raise StoreError if the folder is no longer in its place."""
        if not self.in_place():
            raise StoreError(
                f"`{self.path}` must stay in its place while it is written, but was moved, "
                "removed or replaced: "
                "what was there is gone from here, and nothing more is written."
            )

    def release(self) -> None:
        """Let others write."""
        if self.held is not None:
            self.folder.release(self.held)
            self.held = None

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    @contextlib.contextmanager
    def _whole(self) -> Iterator[None]:
        if self.broken is not None:
            raise self.broken
        try:
            yield
        except OSError as error:
            self.broken = error
            self.check()  # a folder that is gone is the cause, not the disk
            raise

    def _lay_out(self) -> None:
        """Make folders and documents; a power failure may undo them until something in them is
        acknowledged.
        """
        self._make_folders()
        self._describe(self.state, derived=True)

    def _make_folders(self) -> None:
        for path in self.state.header["members"] if not self.laid_out else ():
            self.folder.mkdir(path)
        self.laid_out = True

    def _describe(self, state: Acknowledged, *, derived: bool = False) -> None:
        for path, document in state.documents().items():
            name, data = f"{path}/{DOCUMENT}".lstrip("/"), zarr3.dump(document)
            if _found(self.folder.read, name) != data:
                self.folder.write(name, data, derived=derived)
            elif not derived:
                self.folder.unsynced |= {name, path}

    def _replace(self, records: list[dict[str, Any]]) -> None:
        """Give the ledger these records, in one step; the new file is locked before it has its
        name.
        """
        self.before, whole = _lines(records)
        self.folder.put(LEDGER + NEW, whole)
        self.folder.sync_one(LEDGER + NEW)
        held = self.folder.lock(LEDGER + NEW)
        try:
            self.folder.rename(LEDGER + NEW, LEDGER)
        except BaseException:
            self.folder.release(held)
            raise
        self.release()
        self.held = held
        self.folder.sync_one("")

    def _compact(self) -> None:
        """Replace the ledger by what it acknowledges: what another process appended may not be on
        the disk yet.
        """
        state = self.state
        state.failed, state.writer = {}, f"process {os.getpid()} on {os.uname().nodename}"
        self._replace([state.header, state.record("chunks", "rows", "tail", "changed", "writer")])

    def _tidy(self) -> None:
        """Remove what was never acknowledged: chunks, tails, and files that were being written."""
        chunks = {name for key in self.state.chunks for name in self.state.files(key)}
        kept, removed = self.state.tail[:1], False
        for place in ["", *self.state.header["members"]]:
            for name in self.folder.names(place):
                path = f"{place}/{name}".lstrip("/")
                tail = place == "" and name.startswith(TAIL) and name not in kept
                chunk = name.startswith("c.") and "shape" in self.state.header["members"].get(
                    place, {}
                )
                if tail or name.endswith(NEW) or (chunk and path not in chunks):
                    self.folder.remove(path)
                    removed = removed or not place
        if removed:
            self.folder.sync_one("")

    def _complete(self) -> None:
        """Finish what was interrupted after its last record."""
        self._describe(self.state)
        self.folder.sync()
        self._seal()

    def put(self, key: str, values: Mapping[str, np.ndarray]) -> None:
        """Write a chunk, from the values of its columns by name; the next commit
        acknowledges it.
        """
        members, files = self.state.header["members"], {}
        for name in self.state.files(key):
            path = name.rpartition("/")[0]
            files[name] = zarr3.encode(values[path.rpartition("/")[2]], members[path])
        with self._whole():
            self._make_folders()
            for name, data in files.items():
                self.folder.write(name, data)
            self.pending[key] = {name: tip(data) for name, data in files.items()}

    def commit(self, tail: bytes | None = None, **record: Any) -> None:
        """Acknowledge the chunks that were put, with a tail if there is one: data first, then the
        record.
        """
        with self._whole():
            old = self.state.tail[:1]
            if tail is not None:
                number = int(old[0].removeprefix(TAIL)) + 1 if old else 1
                name = f"{TAIL}{number:08d}"
                self.folder.write(name, tail)
                record["tail"] = [name, mark_of_tail(tail)]
            self.folder.sync()
            record = {name: value for name, value in record.items() if value}
            if self.pending:
                record["chunks"] = {key: mark(tips) for key, tips in self.pending.items()}
            self.before, line = _line(self.before, record)
            self.folder.append(LEDGER, line)
            self.folder.sync_one(LEDGER)
            self.state.add(record)
            self.pending = {}
            if tail is not None:
                for name in old:
                    self.folder.remove(name)

    def derive(self, files: Mapping[str, bytes]) -> None:
        """Write copies of rows that a tail acknowledges, and the documents that describe them, for
        other readers.
        """
        with self._whole():
            self._make_folders()
            for name, data in files.items():
                self.folder.write(name, data, derived=True)
            self._describe(self.state, derived=True)

    def finish(self, changed: dict[str, Any], **record: Any) -> None:
        """Acknowledge that all is there; `changed` are the last attributes.

        From then on the store is finished.
        """
        record |= {"changed": changed, "closing": True}
        with self._whole():
            closed = dataclasses.replace(self.state)
            closed.add(record)
            self._make_folders()
            self._describe(closed)
        self.commit(**record)
        with self._whole():
            self._seal()

    def _seal(self) -> None:
        """Give the ledger of a store that is whole its last form."""
        state = self.state
        state.tail, state.seal, state.chunks = (
            [],
            True,
            dict(sorted(state.chunks.items(), key=_by_number)),
        )
        self._replace(
            [state.header, state.record("chunks", "rows", "end", "changed", "closing", "seal")]
        )
        self._tidy()

    def forget(self, keys: list[str]) -> None:
        """Continue without some chunks, and without the end of a finished store: they are to be
        written again.
        """
        self.restart(self.state.header, self.state.chunks.keys() - set(keys))

    def restart(
        self, head: dict[str, Any], keys: Iterable[str], tail: bytes | None = None, **record: Any
    ) -> None:
        """Continue from some of the chunks, with another header and tail, in one step."""
        with self._whole():
            if tail is not None:
                record["tail"] = [f"{TAIL}{1:08d}", mark_of_tail(tail)]
                self.folder.write(record["tail"][0], tail)
                self.folder.sync()
            chunks = {key: self.state.chunks[key] for key in keys}
            self.state = Acknowledged.of(
                [json.loads(json.dumps(head)), {"chunks": chunks, **record}]
            )
            self._compact()
            self.laid_out = False
            self._lay_out()
            self._tidy()

    def unsound(self) -> list[str]:
        """Return the acknowledged chunks whose files are missing, damaged or others; every byte is
        read.
        """
        return [key for key, marked in self.state.chunks.items() if not self._sound(key, marked)]

    def _sound(self, key: str, marked: str) -> bool:
        tips = {}
        for name in self.state.files(key):
            try:
                data = self.folder.read(name)
            except OSError:
                return False
            if not zarr3.whole(data):
                return False
            tips[name] = tip(data)
        return mark(tips) == marked

    def tail(self) -> bytes | None:
        """Return the acknowledged tail, or None. Raises Damaged."""
        if not self.state.tail:
            return None
        name, marked = self.state.tail
        data = _found(self.folder.read, name)
        if data is None or mark_of_tail(data) != marked:
            raise Damaged(f"`{name}` is another")
        return data


def _by_number(item: tuple[str, str]) -> tuple[str, list[int]]:
    table, _, index = item[0].partition("/")
    return table, list(map(int, index.split(".")))


def read(path: Path, *, chunks: bool = True) -> Acknowledged:
    """Return what the ledger of a store acknowledges, once the store is found to be that.

    Size and last bytes of every chunk are compared, and the content of every document; a changed
    byte within a chunk is found when its numbers are read.

    Parameters
    ----------
    path
        The store.
    chunks
        Whether chunks and documents are compared too.

    Raises
    ------
    StoreError
        It is not, or cannot be read.
    """
    with sound(path):
        try:
            folder = Folder(path.resolve())
            state = acknowledged(folder.read(LEDGER))
            if chunks:
                _compare(folder, state)
        except OSError as error:
            raise StoreError(
                f"`{path}` must be readable, but: {error.strerror or error}."
            ) from None
    return state


@contextlib.contextmanager
def sound(path: Path) -> Iterator[None]:
    """A block in which what a ledger or a file must not be becomes a StoreError."""
    try:
        yield
    except (Damaged, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise StoreError(f"`{path}` must be a whole store, but is damaged: {error}.") from None


def _compare(folder: Folder, state: Acknowledged) -> None:
    """Compare a store with its ledger. Raises Damaged."""
    rows: dict[str, int] = {}
    for member, document in state.documents().items():
        name = f"{member}/{DOCUMENT}".lstrip("/")
        data = _found(folder.read, name)
        if data is None and member and not (state.rows or state.chunks):
            continue  # a run that has just begun
        if data != zarr3.dump(document):
            stored = {} if state.seal else _of_before(data, document)
            if not stored:
                raise Damaged(
                    f"`{name}` is not what its ledger says" + ("" if state.seal else f": {WHOLE}")
                )
            document = stored
        rows[member] = document.get("shape", [0])[0]
    for group in {path.partition("/")[0] for path in state.header["members"]}:
        for name in folder.names(group):
            path = f"{group}/{name}"
            known = path in state.header["members"] or name.isdigit() or name[0] == "."  # runs
            if not known and _found(folder.tip, f"{path}/{DOCUMENT}"):
                raise Damaged(f"`{path}` is not in its ledger")
    for key in state.unsealed(
        {table: rows[state.header["tables"][table][0]] for table in state.rows}
    ):
        if missing := [name for name in state.files(key) if not _found(folder.tip, name)]:
            raise Damaged(f"`{missing[0]}` is missing: {WHOLE}")
    for key, marked in state.chunks.items():
        tips = {name: _found(folder.tip, name) for name in state.files(key)}
        if missing := [name for name, stored in tips.items() if stored is None]:
            raise Damaged(f"`{missing[0]}` is missing")
        if mark({name: stored for name, stored in tips.items() if stored}) != marked:
            raise Damaged(f"a file of its chunk `{key}` is another")


def _of_before(data: bytes | None, document: dict[str, Any]) -> dict[str, Any]:
    """Return a document of an unfinished store as it was at an earlier commit; empty if it cannot
    be that.
    """
    try:
        stored = json.loads(data or b"{}")
        wanted = json.loads(zarr3.dump(document))
        if "shape" in wanted:
            fewer = 0 <= stored["shape"][0] <= wanted["shape"][0]
            wanted["shape"][0] = stored["shape"][0]
            return stored if fewer and stored == wanted else {}
        names = stored["attributes"].keys() == wanted["attributes"].keys()
        return stored if names and stored["node_type"] == "group" else {}
    except (ValueError, LookupError, TypeError, AttributeError):
        return {}


def _found(read: Callable[[str], Any], name: str) -> Any:
    """Return what is read of a file, or None if there is no such file."""
    try:
        return read(name)
    except (FileNotFoundError, NotADirectoryError):
        return None


def is_ledger(path: Path) -> bool:
    """Return whether a folder is a store with a ledger."""
    return os.path.lexists(path / LEDGER)
