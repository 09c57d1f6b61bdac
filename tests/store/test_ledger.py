"""Test what a ledger takes, keeps and refuses; `test_faults.py` has it under faults."""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from stores import exchange, flip

from tippetop.columns import Column
from tippetop.errors import StoreError
from tippetop.store import ledger, zarr3
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


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    """A finished store."""
    chance = random.Random(5)
    with Ledger.created(tmp_path, header()) as store:
        toy = Toy(store)
        while toy.i < STEPS:
            toy.step()
            if chance.random() < 0.15:
                toy.commit()
        toy.finish()
    return tmp_path


def test_xarray_reads_a_store(finished: Path) -> None:
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
    "a record": lambda s: (s / LEDGER).write_bytes(
        (s / LEDGER).read_bytes().replace(b'"end":{"h":', b'"end":{"h":1')
    ),
    "the header": lambda s: (s / LEDGER).write_bytes(
        (s / LEDGER).read_bytes().replace(b"running", b"runnin9")
    ),
    "a further array": lambda s: exchange(s / "trajectory/theta", s / "trajectory/more"),
}


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
