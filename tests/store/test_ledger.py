"""Test the ledger under faults: acknowledged data are kept, finished stores are equal."""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
import xarray as xr
from disk import ModelFolder, PowerLost
from nightly import at_night
from stores import exchange, files, flip

from tippetop.columns import Column
from tippetop.errors import StoreError
from tippetop.store import ledger, zarr3
from tippetop.store.folder import Folder
from tippetop.store.ledger import LEDGER, Ledger
from tippetop.store.table import Table


CHUNK, STEPS, PLACE = 8, 45, Path("store")
COLUMNS: dict[str, dict[str, np.ndarray]] = {
    "trajectory": {"time": np.zeros(0), "theta": np.zeros(0), "axis": np.zeros((0, 3))},
    "events": {
        "time": np.zeros(0),
        "kind": np.zeros(0, np.int16),
        "significant": np.zeros(0, bool),
    },
}


def header() -> dict[str, Any]:
    """The header of a toy run: two tables, one of which has a late column."""
    tables: dict[str, dict[str, Any]] = {}
    for group, columns in COLUMNS.items():
        for name, empty in columns.items():
            column = Column((group, *["xyz"] * (empty.ndim - 1)), empty, {"units": "1"})
            table = tables.setdefault("events-late" if name == "significant" else group, {})
            table[f"{group}/{name}"] = zarr3.array(column, {group: (0, CHUNK)})
    return ledger.header({"status": "running"}, tables)


class Toy:
    """A run that is made of its state: a counter and a number.

    It commits where `commits` says so.
    """

    def __init__(self, store: Ledger):
        self.store, self.i, self.h = store, 0, 1.0
        self.tables = {name: Table(store, name) for name in store.state.header["tables"]}
        tail = store.tail()
        if tail is not None:
            head, _, data = tail.partition(b"\n")
            state = json.loads(head)
            self.i, self.h = state["i"], state["h"]
            for name, table in self.tables.items():
                data = table.restore(*state["tables"][name], data)

    def step(self) -> None:
        self.i, self.h = self.i + 1, (self.h * 1.37 + 0.11) % 1.0
        row = {"time": self.i / 1000, "theta": self.h, "axis": [self.h, -self.h, self.i]}
        self.tables["trajectory"].append({name: np.array([value]) for name, value in row.items()})
        events = self.tables["events"]
        if self.h > 0.4:
            event = {"time": self.i / 1000, "kind": np.int16(self.i % 3), "significant": False}
            for table in (events, self.tables["events-late"]):
                table.append({name: np.array([value]) for name, value in event.items()})
        elif events.rows:
            self.tables["events-late"].mark("significant", [self.i % events.rows])

    def commit(self) -> None:
        state = {
            "i": self.i,
            "h": self.h,
            "tables": {name: (table.written, table.rows) for name, table in self.tables.items()},
        }
        tail = json.dumps(state).encode() + b"\n" + b"".join(map(Table.tail, self.tables.values()))
        self.store.commit(tail, rows=self.rows())
        self.store.derive(dict(file for table in self.tables.values() for file in table.derived()))

    def rows(self) -> dict[str, int]:
        return {name: table.rows for name, table in self.tables.items()}

    def finish(self) -> None:
        for table in self.tables.values():
            table.finish()
        self.store.finish({"status": "finished"}, rows=self.rows(), end={"h": self.h})


def go(
    folder: Folder, place: Path, chance: random.Random, note: Callable[[int], None] = lambda _: None
) -> None:
    """Begin or continue a toy run, and finish it; call `note` with the acknowledged steps."""
    with mock.patch.object(ledger, "Folder", return_value=folder):
        try:
            store = Ledger.opened(place)
            store.recover()
        except FileNotFoundError:
            store = Ledger.created(place, header())
    with store:
        if store.state.seal:
            return
        toy = Toy(store)
        while toy.i < STEPS:
            toy.step()
            if chance.random() < 0.15:
                toy.commit()
                note(toy.i)
        toy.finish()
        note(STEPS)


def steps_in(folder: ModelFolder) -> int:
    """The steps that a store acknowledges."""
    try:
        state = ledger.Acknowledged.of(ledger.records_of(folder.read(LEDGER)))
    except FileNotFoundError:
        return 0
    if state.seal:
        return STEPS
    return json.loads(folder.read(state.tail).partition(b"\n")[0])["i"] if state.tail else 0


def undisturbed() -> ModelFolder:
    folder = ModelFolder()
    go(folder, PLACE, random.Random(1))
    return folder


def disturbed(kind: str, at: int, seed: int, wanted: dict[str, bytes]) -> None:
    """Continue a run with a fault at one operation, perhaps with more, until it is finished."""
    chance, folder, known = random.Random(1000 * at + seed), ModelFolder(), [0]
    folder.random, folder.fault = chance, (kind, at)
    for attempt in range(40):
        try:
            go(
                folder,
                PLACE,
                random.Random(1 if not attempt else attempt + seed),
                lambda i: known.append(i),
            )
            break
        except PowerLost:
            folder.crash(chance.randrange(10**6))
        except OSError:
            folder.again()
            if chance.random() < 0.5:
                folder.crash(chance.randrange(10**6))
        assert steps_in(folder) >= max(known), (
            f"{kind} at {at}: {max(known)} steps were acknowledged"
        )
        if LEDGER not in folder.now:  # it was never renamed to its place
            folder = ModelFolder()
        if chance.random() < 0.4 and attempt < 6:
            folder.fault = (chance.choice(["fail", "power"]), chance.randrange(1, 120))
    for _ in range(2):
        found = folder.tree()
        found.pop(ledger.WRITER, None)  # its removal may fail; the next writer removes it
        assert sorted(found) == sorted(wanted), (kind, at, seed)
        assert [name for name in found if found[name] != wanted[name]] == [], (kind, at, seed)
        folder.crash(seed)
        assert steps_in(folder) == STEPS, "what is finished is on the disk"
        go(folder, PLACE, random.Random(0))  # which removes the tail, if its removal was undone


def campaign(kinds: tuple[str, ...], stride: int, seeds: int) -> int:
    """Faults at every operation; their number."""
    calm = undisturbed()
    cases = [
        (k, at, s) for k in kinds for at in range(1, calm.count + 1, stride) for s in range(seeds)
    ]
    for case in cases:
        disturbed(*case, calm.tree())
    return len(cases)


@pytest.mark.parametrize(("stride", "seeds", "least"), [(14, 1, 50), at_night(1, 3, 2500)])
def test_nothing_acknowledged_is_lost_and_finished_stores_are_equal(
    stride: int, seeds: int, least: int
) -> None:
    assert campaign(("fail", "power"), stride, seeds) > least


@pytest.mark.parametrize("left_out", ["data", "ledger", "names"])
def test_a_sync_that_is_left_out_is_found(left_out: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The campaign can fail: without any one of the three, something acknowledged is lost."""
    sync_one, synced = ModelFolder.sync_one, ModelFolder.sync

    def less(folder: ModelFolder, name: str) -> None:
        if name != {"ledger": LEDGER, "names": ""}[left_out]:
            sync_one(folder, name)

    def none(folder: ModelFolder) -> None:
        folder.unsynced = {
            name
            for name in folder.unsynced
            if not name.rpartition("/")[2].startswith(("c.", "tail"))
        }
        synced(folder)

    monkeypatch.setattr(
        ModelFolder, *(("sync", none) if left_out == "data" else ("sync_one", less))
    )
    with pytest.raises((AssertionError, StoreError, FileNotFoundError)):
        campaign(("power",), stride=3, seeds=2)


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    """A finished store on a real disk."""
    go(Folder(tmp_path), tmp_path, random.Random(5))
    return tmp_path


def test_a_store_on_a_real_disk_is_that_of_the_model_and_xarray_reads_it(finished: Path) -> None:
    wanted = undisturbed().tree()
    assert files(finished) == wanted
    table = xr.open_zarr(finished, group="trajectory").load()
    np.testing.assert_array_equal(table["time"], np.arange(1, STEPS + 1) / 1000)
    assert ledger.read(finished).attributes["status"] == "finished"


def test_rows_of_an_unfinished_store_are_read(tmp_path: Path) -> None:
    with Ledger.created(tmp_path, header()) as store:
        assert ledger.read(tmp_path).attributes["status"] == "running"
        assert xr.open_zarr(tmp_path, group="trajectory").sizes["trajectory"] == 0
        toy = Toy(store)
        for _ in range(13):
            toy.step()
        toy.commit()
        assert xr.open_zarr(tmp_path, group="trajectory").sizes["trajectory"] == 13
        assert ledger.read(tmp_path).rows["trajectory"] == 13


def test_a_second_writer_is_told_of_the_first(tmp_path: Path) -> None:
    with (
        Ledger.created(tmp_path, header()),
        pytest.raises(StoreError, match=r"one writer, but process \d+ on"),
    ):
        Ledger.opened(tmp_path)
    with Ledger.opened(tmp_path) as store:
        store.finish({})
        with pytest.raises(StoreError, match=r"one writer, but process \d+ on"):
            Ledger.opened(tmp_path)
    assert not list(tmp_path.glob("*.new"))


DAMAGES: dict[str, Callable[[Path], object]] = {
    "a missing chunk": lambda s: (s / "trajectory/theta/c.1").unlink(),
    "a chunk cut": lambda s: cut(s / "trajectory/theta/c.1"),
    "chunks exchanged": lambda s: exchange(s / "trajectory/theta/c.1", s / "trajectory/time/c.1"),
    "a document": lambda s: (s / "trajectory/theta/zarr.json").write_text("{}"),
    "a record": lambda s: (s / LEDGER).write_bytes(
        (s / LEDGER).read_bytes().replace(b'"end":{"h":', b'"end":{"h":1')
    ),
    "the header": lambda s: (s / LEDGER).write_bytes(
        (s / LEDGER).read_bytes().replace(b"running", b"runnin9")
    ),
    "no ledger": lambda s: (s / LEDGER).write_bytes(b""),
    "a further array": lambda s: exchange(s / "trajectory/theta", s / "trajectory/more"),
}


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3])


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_found_when_a_store_is_opened(damage: str, finished: Path) -> None:
    DAMAGES[damage](finished)
    with pytest.raises(StoreError, match="must be a whole store, but is damaged"):
        ledger.read(finished)


def test_a_link_to_a_store_is_read(finished: Path) -> None:
    link = finished.with_name("link")
    link.symlink_to(finished)
    assert ledger.read(link).attributes["status"] == "finished"


@pytest.mark.parametrize(
    "torn", [b"\xab\xcd", b"\0" * 9, b'0123456789abcdef {"ro', b"\xe8", b"0123 {"]
)
def test_the_beginning_of_a_record_is_set_aside_before_the_next(
    torn: bytes, tmp_path: Path
) -> None:
    with Ledger.created(tmp_path, header()) as store:
        toy = Toy(store)
        toy.step()
        toy.commit()
    whole = ledger.records_of((tmp_path / LEDGER).read_bytes())
    (tmp_path / LEDGER).write_bytes((tmp_path / LEDGER).read_bytes() + torn)
    assert ledger.read(tmp_path).rows["trajectory"] == 1
    with Ledger.opened(tmp_path) as store:
        store.recover()
        assert store.state == ledger.Acknowledged.of(whole)
        assert (tmp_path / "torn.new").read_bytes() == torn
        store.commit(changed={"more": 1})
    assert ledger.read(tmp_path, chunks=False).attributes["more"] == 1


def test_a_changed_byte_within_a_chunk_is_found_by_its_writer(finished: Path) -> None:
    flip(finished / "trajectory/theta/c.1", 20)
    with Ledger.opened(finished) as store:
        assert store.unsound() == ["trajectory/1"]


def test_a_ledger_names_nothing_outside_its_store(tmp_path: Path) -> None:
    head = header()
    head["tables"]["trajectory"].append("../other")
    head["members"]["../other"] = head["members"]["trajectory/time"]
    _, lines = ledger.lines([head, {}])
    (tmp_path / LEDGER).write_bytes(lines)
    with pytest.raises(StoreError, match="names what cannot be in a store"):
        ledger.read(tmp_path)
