"""The ledger of a store: an append-only file of records that acknowledge files.

It promises that what `commit` has acknowledged survives a kill and a power failure, that a reader
finds a store as of one commit, and that damage is found. Data are synced before the record that
lists them; each record has a digest of itself and of the one before; a chunk has a checksum, and
never changes once acknowledged. Other files are derived, and made again, or were never
acknowledged: they are set aside when a store is continued, and removed when it is sealed.

The first record is the header: the attributes of the store, the documents of its groups and
arrays, and which arrays form a table. Every further record acknowledges chunks, and a tail: the
rows that do not fill a chunk, and the state of a run. A finished store has a ledger of two records,
the header and the seal: equal runs make equal files. The first two lines of a ledger are renamed
into place; each further line is appended.
"""

import contextlib
import hashlib
import json
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..errors import StoreError
from . import zarr3
from .folder import NEW, Folder
from .provenance import FORMAT_VERSION
from .zarr3 import CHECKSUM, DOCUMENT


LEDGER = "ledger.jsonl"
TAIL = "tail-"
WRITER = "writer" + NEW  # the name of the process that has the lock
DIGITS = 16  # hexadecimal, of a digest
PATH = re.compile(r"[^./\0][^/\0]*(/[^./\0][^/\0]*)?")  # of a group or an array, inside the store
WHOLE = "tippetop resume, or the command that wrote it, completes it"
COPY = "put a copy of it back, or read the numbers with xarray.open_zarr"


# errors that a ledger with other types, shapes or depths than ours can raise
FORGED = (
    *(ValueError, LookupError, TypeError, AttributeError),
    *(ArithmeticError, MemoryError, RecursionError),
)


class Damaged(ValueError):
    """Raised if a ledger or an acknowledged file is damaged."""


@dataclass
class Acknowledged:
    """The content of a store according to its ledger: the sum of all records.

    `acknowledged` makes it from the bytes of a ledger; `Ledger` keeps one up to date as `state`.
    The names of all fields but `header` are the keys of the records, a stored format.
    """

    header: PlainData
    chunks: dict[str, str] = field(default_factory=dict)  # TABLE/INDEX -> mark
    failed: dict[str, str] = field(default_factory=dict)  # TABLE/INDEX -> why it failed
    rows: dict[str, int] = field(default_factory=dict)  # by table, of those that grow
    tail: str = ""  # the name of its file, which contains its digest
    end: Any = None  # what `Integration.encoded` returns: where a finished run can be continued
    changed: PlainData = field(default_factory=dict)  # attributes other than in the header
    seal: bool = False  # everything is acknowledged

    @classmethod
    def of(cls, records: list[PlainData]) -> "Acknowledged":
        """Return the sum of the records of a ledger."""
        state = cls(records[0])
        for record in records[1:]:
            state.add(record)
        return state

    def add(self, record: PlainData) -> None:
        """Add one record after the header: its fields, by their names here, all optional.

        `chunks`, `failed` and `changed` are added, others replace; a chunk that is acknowledged has
        no longer failed, and the changed attributes of a seal replace all.
        """
        self.chunks |= record.get("chunks", {})
        failed = self.failed | record.get("failed", {})
        self.failed = {key: why for key, why in failed.items() if key not in self.chunks}
        self.changed = ({} if "seal" in record else self.changed) | record.get("changed", {})
        for name in ("rows", "tail", "end", "seal"):
            setattr(self, name, record.get(name, getattr(self, name)))

    @property
    def attributes(self) -> PlainData:
        """Return the attributes of the root group."""
        return self.header["attributes"] | self.changed

    def sum(self) -> PlainData:
        """Return all but the header as one record, without empty fields and failures.

        Chunks are sorted, here and in the state, so that equal stores have equal ledgers.
        """
        self.chunks = dict(sorted(self.chunks.items()))
        names = ("chunks", "rows", "tail", "end", "changed", "seal")
        return {name: value for name in names if (value := getattr(self, name))}

    def documents(self) -> dict[str, PlainData]:
        """Return the document of every array and group by its path; last that of the root, "".

        `_describe` writes them in this order. Growing arrays get the acknowledged number of rows.
        """
        members = {path: dict(document) for path, document in self.header["members"].items()}
        for table, rows in self.rows.items():
            for path in self.header["tables"][table]:
                members[path]["shape"] = [rows, *members[path]["shape"][1:]]
        return {**members, "": zarr3.group(self.attributes, members)}

    def files(self, key: str) -> list[str]:
        """Return the names of the files of a chunk, one for each array, inside the store.

        `key` is TABLE/INDEX; the index has a number for each dimension, as in "surface/0.3".
        """
        table, _, index = key.partition("/")
        members = self.header["members"]
        place = list(map(int, index.split(".")))
        return [
            f"{path}/{zarr3.chunk_name(members[path], *place)}"
            for path in self.header["tables"][table]
        ]


def digest(data: bytes) -> str:
    """Return a short SHA-256 digest of some bytes."""
    return hashlib.sha256(data).hexdigest()[:DIGITS]


def mark(tips: Mapping[str, tuple[int, bytes]]) -> str:
    """Return the digest of a chunk that records contain, from the tips of its files by name.

    A tip is the size and the last bytes, which are the checksum of the file. Stored ledgers contain
    the result: a digest of another text would make all old stores seem damaged.
    """
    return digest(repr(sorted(tips.items())).encode())


def mark_of(files: Mapping[str, bytes]) -> str:
    """Return the mark of a chunk from the contents of its files."""
    return mark({name: (len(data), data[-CHECKSUM:]) for name, data in files.items()})


def lines(records: list[PlainData], before: str = "") -> tuple[str, bytes]:
    """Return the digest of the last record, and the records as lines of a ledger.

    `before` is the digest of the record before them, "" for the header: each digest includes it.
    `has_ledger` compares the first bytes: a digest, a space and `{"format":` without spaces.
    """
    written = b""
    for record in records:
        body = json.dumps(record, allow_nan=False, separators=(",", ":")).encode()
        before = digest(before.encode() + body)
        written += before.encode() + b" " + body + b"\n"
    return before, written


def records_of(raw: bytes) -> list[PlainData]:
    """Return the records of a ledger, without an append that was cut off. Raises Damaged.

    Such an append has no end of line, and is not one of the first two lines; nor does one follow
    a seal. Any other bad line is damaged, and may have been acknowledged.
    """
    records: list[PlainData] = []
    *each, rest = raw.split(b"\n")
    before = ""
    for number, line in enumerate(each, 1):
        known, _, body = line.partition(b" ")
        if known.decode(errors="replace") != digest(before.encode() + body):
            raise Damaged(f"line {number} of `{LEDGER}` is damaged: {COPY}")
        records.append(json.loads(body))
        before = known.decode()
    if len(records) < 2 or (rest and records[-1].get("seal")):
        raise Damaged(f"`{LEDGER}` is cut or has a line too many: {COPY}")
    if records[0].get("format") != FORMAT_VERSION:
        raise Damaged(f"its format is {records[0].get('format')}: use the release that wrote it")
    if not all(map(PATH.fullmatch, records[0]["members"])):
        raise Damaged(f"`{LEDGER}` names what cannot be in a store")
    return records


def has_ledger(path: Path) -> bool:
    """Return whether a folder contains a ledger of ours, damaged or not: only then is it replaced.

    `header` puts `format` first, and `lines` writes it without spaces.
    """
    with contextlib.suppress(OSError):
        return Folder(path).read(LEDGER)[DIGITS:].startswith(b' {"format":')
    return False


def acknowledged(raw: bytes) -> Acknowledged:
    """Return the content that the bytes of a ledger acknowledge.

    The documents and the file names of all chunks are made here too, only as a check: a forged
    ledger fails now rather than after other code trusts it. Raises Damaged, or any error in
    `FORGED`: call it inside `sound`, which converts them to a StoreError.
    """
    state = Acknowledged.of(records_of(raw))
    state.documents()
    for key in state.chunks:
        state.files(key)
    return state


def header(attributes: PlainData, tables: Mapping[str, Mapping[str, PlainData]]) -> PlainData:
    """Return the header of a new store. Its first key is `format`, by which `has_ledger` finds it.

    Parameters
    ----------
    attributes
        Of the root group.
    tables
        Table -> path -> document of the arrays whose chunks are written together; arrays that grow
        have no rows. The order of paths is that of the columns in a tail (`Table.tail`).
    """
    members: PlainData = {}
    for arrays in tables.values():
        members |= {path.partition("/")[0]: zarr3.group({}) for path in arrays} | dict(arrays)
    head = {
        "format": FORMAT_VERSION,
        "attributes": attributes,
        "members": members,
        "tables": {table: list(arrays) for table, arrays in tables.items()},
    }
    return json.loads(json.dumps(head))  # as it will be read: lists, no tuples


class Ledger:
    """The locked ledger of a store that is being written; a context that releases the lock.

    `created`, `opened` and `locked` make one. `key` names a chunk, "trajectory/3"; a tail is the
    rows that fill no chunk.

    After an error of the disk nothing more is written: a page that could not be synced may look
    written and be lost.
    """

    def __init__(self, path: Path):
        """Prepare the ledger of a store; the class methods lock it, and read or make it."""
        self.folder = Folder(path)
        self.path = path
        self.state: Acknowledged
        # `_compact` sets `before`: the digest of the last record, which that of the next includes
        self.pending: dict[str, str] = {}  # key -> mark of chunks for the next commit
        self.broken: OSError | None = None
        self.held: int | None = None

    @classmethod
    def created(cls, path: Path, head: PlainData) -> "Ledger":
        """Create a store with this header in an empty folder, and lock it. Raises OSError.

        Its root document contains all others, which are written when rows are acknowledged, so
        that a short run takes less time.
        """
        self = cls(path)
        self.state = Acknowledged.of([head])
        with self.released_on_failure():
            self._make_folders()
            self.folder.write(DOCUMENT, zarr3.dump(self.state.documents()[""]), derived=True)
            self._compact()
            self._lock()
        return self

    @classmethod
    def locked(cls, path: Path) -> "Ledger":
        """Lock a store that will be replaced, without reading it. Raises StoreError, OSError."""
        self = cls(path)
        with self.released_on_failure():
            self._lock()
        return self

    @classmethod
    def opened(cls, path: Path) -> "Ledger":
        """Lock a store and read its ledger, to continue it; nothing is changed yet.

        Call `recover` or `restart` before `commit`: they make the ledger to which it appends.

        Raises
        ------
        StoreError
            If another process writes it, or its ledger or tail is damaged.
        OSError
            If reading fails.
        """
        self = cls.locked(path)
        with self.released_on_failure(), sound(path):
            self.state = acknowledged(self.folder.read(LEDGER))
            self.tail()
        return self

    def recover(self) -> None:
        """Write the derived files of a store again, and set aside files that it does not list.

        Call it only when it is certain that the store will be continued.
        """
        self._make_folders()
        # `_compact` drops an append that was cut off: it is kept aside
        if torn := self.folder.read(LEDGER).rpartition(b"\n")[2]:
            self.folder.write("torn" + NEW, torn)
        self._describe()
        self.folder.sync()
        self._compact()
        self._tidy()

    @contextlib.contextmanager
    def released_on_failure(self) -> Iterator[None]:
        """Release the lock if the block fails."""
        try:
            yield
        except BaseException:
            self.release()
            raise

    def _lock(self) -> None:
        """Lock the store, if it is not, and write the name of this process for others."""
        while not self.in_place():  # its last writer replaced it while we waited
            self.release()
            try:
                self.held = self.folder.lock(LEDGER)
            except BlockingIOError:
                writer = _found(self.folder.read, WRITER) or b"another process"
                raise StoreError(
                    f"`{self.path}` must have one writer, but {os.fsdecode(writer)} is writing it."
                ) from None
        with contextlib.suppress(OSError):  # a full disk
            self.folder.put(WRITER, f"process {os.getpid()} on {os.uname().nodename}".encode())

    def in_place(self) -> bool:
        """Return whether the locked ledger is still at the path of the store."""
        return self.held is not None and self.folder.is_at(self.path / LEDGER, self.held)

    def check(self) -> None:
        """Raise StoreError if the store was moved, removed or replaced since it was locked."""
        if not self.in_place():
            raise StoreError(
                f"`{self.path}` must stay in its place while it is written, but was moved, "
                "removed or replaced: nothing more is written."
            )

    def release(self) -> None:
        """Release the lock, so that other processes can write."""
        if self.held is not None:
            try:
                with contextlib.suppress(OSError):  # while locked: then it is not that of another
                    self.folder.remove(WRITER)
            finally:
                os.close(self.held)
                self.held = None

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    @contextlib.contextmanager
    def _unless_broken(self) -> Iterator[None]:
        """Let the block write if no write has failed yet, and the store is in its place.

        After an error of the disk nothing more is written. Nothing is rolled back: what no commit
        has acknowledged does not count.
        """
        if self.broken is not None:
            raise self.broken
        self.check()
        try:
            yield
        except OSError as error:
            self.broken = error
            self.check()  # a folder that is gone is the cause, not the disk
            raise

    def _make_folders(self) -> None:
        """Make the folders of all arrays."""
        for path in self.state.header["members"]:
            self.folder.mkdir(path)

    def _describe(self, *, derived: bool = False) -> None:
        """Write the documents of root, groups and arrays that differ from their files.

        The root is last, as readers begin with it. `derived` documents are not synced.
        """
        for path, document in self.state.documents().items():
            name = f"{path}/{DOCUMENT}".lstrip("/")
            data = zarr3.dump(document)
            if _found(self.folder.read, name) != data:
                self.folder.write(name, data, derived=derived)
            elif not derived:  # it may be written, but not synced
                self.folder.unsynced |= {name, path}

    def _compact(self) -> None:
        """Replace the ledger by two records: the header, and the sum of all others.

        The disk may lack what another process appended, so all is written again. The new file is
        locked before it is renamed, so that the store is never without a lock. Failures are
        dropped: a sweep that is continued tries these chunks again.
        """
        state = self.state
        state.failed = {}
        self.before, whole = lines([state.header, state.sum()])
        self.folder.put(LEDGER + NEW, whole)
        self.folder.sync_one(LEDGER + NEW)
        held = self.folder.lock(LEDGER + NEW)
        try:
            self.folder.rename(LEDGER + NEW, LEDGER)
        except BaseException:
            os.close(held)
            raise
        if self.held is not None:
            os.close(self.held)
        self.held = held
        self.folder.sync_one("")

    def _tidy(self) -> None:
        """Set aside chunks and tails that are not acknowledged; remove them from a sealed store.

        A file that is set aside gets the name of one that is being written, which replaces it.
        """
        members = self.state.header["members"]
        kept = {name for key in self.state.chunks for name in self.state.files(key)}
        kept |= {self.state.tail, WRITER}
        for place in ["", *members]:
            # chunks of an array, tails in the root; a group contains neither: () matches no name
            ours = "c." if "shape" in members.get(place, {}) else () if place else TAIL
            for name in self.folder.names(place):
                path = f"{place}/{name}".lstrip("/")
                if path in kept:
                    continue
                if self.state.seal and (name.startswith(ours) or name.endswith(NEW)):
                    self.folder.remove(path)
                elif name.startswith(ours) and not name.endswith(NEW):
                    self.folder.rename(path, path + NEW)

    def put(self, key: str, values: Mapping[str, np.ndarray]) -> None:
        """Write a chunk, TABLE/INDEX, from the values of its columns by name.

        The next commit acknowledges it; until then it does not count.
        """
        members = self.state.header["members"]
        files = {}
        with self._unless_broken():
            for name in self.state.files(key):
                path = name.rpartition("/")[0]
                files[name] = zarr3.encode(values[path.rpartition("/")[2]], members[path])
                self.folder.write(name, files[name])
            self.pending[key] = mark_of(files)

    def commit(self, tail: bytes | None = None, **record: Any) -> None:
        """Acknowledge the chunks since the last commit, and a tail.

        When it returns, they are on the disk: data are synced first, then the record. `tail` is the
        content of the tail, which replaces the one before; None, in sweeps: none is written.
        `record` are further fields of `Acknowledged`, such as `rows`.
        """
        with self._unless_broken():
            old = self.state.tail
            record |= {"chunks": self.pending, "tail": self._write_tail(tail)}
            self.folder.sync()
            record = {name: value for name, value in record.items() if value}
            self.before, line = lines([record], self.before)
            self.folder.put(LEDGER, line, os.O_APPEND)
            self.folder.sync_one(LEDGER)
            self.state.add(record)
            self.pending = {}
            if old not in ("", self.state.tail):
                self.folder.remove(old)

    def _write_tail(self, tail: bytes | None) -> str:
        """Write a tail, if there is one; return the name of its file, or ""."""
        if tail is None:
            return ""
        name = TAIL + digest(tail)
        self.folder.write(name, tail)
        return name

    def derive(self, files: Mapping[str, bytes]) -> None:
        """Write documents and further files for readers, which `recover` can make again."""
        with self._unless_broken():
            for name, data in files.items():
                self.folder.write(name, data, derived=True)
            self._describe(derived=True)

    def finish(self, changed: PlainData, **record: Any) -> None:
        """Seal the store: acknowledge that it is complete.

        `changed` are all attributes that differ from the header, not only new ones; `record` are
        further fields of `Acknowledged`. The ledger becomes its sum, so that equal stores have
        equal ledgers.
        """
        with self._unless_broken():
            record |= {"chunks": self.pending, "tail": "", "changed": changed, "seal": True}
            self.state.add(record)
            self._describe()
            self.folder.sync()
            self._compact()
            self._tidy()

    def restart(
        self, head: PlainData, keys: Collection[str], tail: bytes | None = None, **record: Any
    ) -> None:
        """Replace the content of the store in one step, to continue from an earlier state.

        Everything else that was acknowledged is dropped: other chunks, the end, the seal, changed
        attributes. No chunk may be pending.

        Parameters
        ----------
        head
            The new header, with the same members.
        keys
            The chunks that stay.
        tail
            The new tail.
        record
            Further fields of the record, such as `rows`.
        """
        with self._unless_broken():
            record["tail"] = self._write_tail(tail)
            self.folder.sync()
            record["chunks"] = {k: v for k, v in self.state.chunks.items() if k in keys}
            self.state = Acknowledged.of([head, record])
            self._compact()
            self.derive({})
            self._tidy()

    def unsound(self) -> list[str]:
        """Return the keys of acknowledged chunks that are missing or damaged; reads every byte."""
        bad = []
        for key, marked in self.state.chunks.items():
            files = {name: _found(self.folder.read, name) or b"" for name in self.state.files(key)}
            if mark_of(files) != marked or not all(map(zarr3.is_intact, files.values())):
                bad.append(key)
        return bad

    def tail(self) -> bytes | None:
        """Return the acknowledged tail, or None. Raises Damaged."""
        return _tail(self.folder, self.state)


def read(path: Path, *, chunks: bool = True) -> Acknowledged:
    """Return the content of a store according to its ledger, after comparing the two.

    No lock is taken: if another process commits meanwhile, the store is compared again. A changed
    byte within a chunk is found only when its numbers are read.

    Parameters
    ----------
    path
        The store.
    chunks
        Whether the files are compared with the ledger: the content of every document and of the
        tail, and sizes and checksums of all chunks. If not, only the ledger itself is checked, by
        the digests of its lines.

    Raises
    ------
    StoreError
        If the store is damaged, or cannot be read.
    """
    with sound(path):
        try:
            folder = Folder(path.resolve())
            while True:
                state = acknowledged(raw := folder.read(LEDGER))
                try:
                    if chunks:
                        _compare(folder, state)
                    return state
                except Damaged:
                    if raw == folder.read(LEDGER):  # no commit came between
                        raise
        except OSError as error:
            raise StoreError(
                f"`{path}` must be readable, but: {error.strerror or error}."
            ) from None


@contextlib.contextmanager
def sound(path: Path) -> Iterator[None]:
    """Convert the errors of a damaged or forged ledger or file to a StoreError."""
    try:
        yield
    except FORGED as error:
        why = str(error) or type(error).__name__
        raise StoreError(f"`{path}` must be a whole store, but is damaged: {why}.") from None


def _compare(folder: Folder, state: Acknowledged) -> None:
    """Compare a store with its ledger. Raises Damaged, on which `read` tries again.

    Another process may commit meanwhile. It writes documents last, after the chunks derived from
    the tail, so only the rows that a stored document counts are sure to be in chunks: `rows` is the
    stored number, at most that of the ledger.
    """
    members = state.header["members"]
    remedy = "" if state.seal else f": {WHOLE}"
    rows: dict[str, int] = {}
    for path, document in state.documents().items():
        name = f"{path}/{DOCUMENT}".lstrip("/")  # as in `_describe`
        data = _found(folder.read, name)
        if data is None and path and not (state.rows or state.chunks):
            continue  # a store that has just been created
        stored: PlainData = {}
        with contextlib.suppress(ValueError):
            stored = json.loads(data or b"")
        # a group has no shape, and counts as 0 rows
        rows[path], most = (each.get("shape", [0])[0] for each in (stored, document))
        same = data == zarr3.dump(document) if state.seal else _fixed(stored) == _fixed(document)
        if not same or rows[path] > most:
            raise Damaged(f"`{name}` is not what its ledger says{remedy}")
    _tail(folder, state)

    def keys() -> Iterator[str]:
        """Yield the keys of acknowledged chunks, then those of chunks that repeat rows of a tail.

        The latter are derived for readers, and have no mark; sweeps write none.
        """
        yield from state.chunks
        for table in state.rows:  # the tables that grow; their arrays have equal numbers of rows
            path = state.header["tables"][table][0]
            rows_per_chunk, *parts = zarr3.chunk_shape(members[path])
            if parts:  # the events of a sweep
                continue
            every = (f"{table}/{k}" for k in range(-(-rows[path] // rows_per_chunk)))
            yield from (key for key in every if key not in state.chunks)

    for key in keys():
        tips = {name: _found(folder.tip, name) for name in state.files(key)}
        if missing := [name for name, stored in tips.items() if stored is None]:
            raise Damaged(f"`{missing[0]}` is missing{remedy}")
        if mark(tips) != state.chunks.get(key, mark(tips)):
            raise Damaged(f"a file of its chunk `{key}` is another")


def _tail(folder: Folder, state: Acknowledged) -> bytes | None:
    """Return the acknowledged tail, or None. Raises Damaged.

    The name of its file has its digest, as `_write_tail` makes it.
    """
    data = _found(folder.read, state.tail) if state.tail else None
    if state.tail != (TAIL + digest(data) if data else ""):
        raise Damaged(f"`{state.tail}` is another or missing")
    return data


def _fixed(document: PlainData) -> PlainData:
    """Return the parts of a zarr document that commits do not change: all but shape or attributes.

    Documents are written after the record, so those of an unfinished store may be older.
    """
    varying = ("shape",) if "shape" in document else ("attributes", "consolidated_metadata")
    return {key: value for key, value in document.items() if key not in varying}


def _found(read: Callable[[str], Any], name: str) -> Any:
    """Return read(name), or None if there is no such file; `read` is a method of a `Folder`."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        return read(name)
    return None
