"""The ledger: what was acknowledged is found again, and damage is named."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from stores import assert_same

from tippetop.columns import Column
from tippetop.errors import StoreError
from tippetop.store import ledger, zarr3
from tippetop.store.ledger import LEDGER, Ledger
from tippetop.store.table import Table


CHUNK, STEPS = 8, 45
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
        tail = b"".join(map(Table.tail, self.tables.values()))
        self.store.commit(tail, rows=self.rows())
        self.store.derive(dict(file for table in self.tables.values() for file in table.derived()))

    def rows(self) -> dict[str, int]:
        return {name: table.rows for name, table in self.tables.items()}

    def finish(self) -> None:
        for table in self.tables.values():
            table.finish()
        self.store.finish({"status": "finished"}, rows=self.rows(), end={"h": self.h})


def go(place: Path, seed: int = 5) -> None:
    """Make and finish a toy run that commits at random moments."""
    place.mkdir(exist_ok=True)
    chance = random.Random(seed)
    with Ledger.created(place, header()) as store:
        toy = Toy(store)
        while toy.i < STEPS:
            toy.step()
            if chance.random() < 0.15:
                toy.commit()
        toy.finish()


def test_a_finished_store_does_not_depend_on_its_commits_and_xarray_reads_it(
    tmp_path: Path,
) -> None:
    for seed in (1, 5):
        go(tmp_path / str(seed), seed)
    assert_same(tmp_path / "1", tmp_path / "5")
    table = xr.open_zarr(tmp_path / "5", group="trajectory").load()
    np.testing.assert_array_equal(table["time"], np.arange(1, STEPS + 1) / 1000)
    assert ledger.read(tmp_path / "5").attributes["status"] == "finished"


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
    Ledger.opened(tmp_path).release()


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


def exchange(one: Path, other: Path) -> None:
    one.rename(one.with_name("x"))
    if other.exists():
        other.rename(one)
    one.with_name("x").rename(other)


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_found_when_a_store_is_opened(damage: str, tmp_path: Path) -> None:
    go(tmp_path)
    DAMAGES[damage](tmp_path)
    with pytest.raises(StoreError, match="must be a whole store, but is damaged"):
        ledger.read(tmp_path)


def test_a_link_to_a_store_is_read(tmp_path: Path) -> None:
    go(tmp_path)
    link = tmp_path.with_name("link")
    link.symlink_to(tmp_path)
    assert ledger.read(link).attributes["status"] == "finished"


def test_a_changed_byte_within_a_chunk_is_found_by_its_writer(tmp_path: Path) -> None:
    go(tmp_path)
    chunk = tmp_path / "trajectory/theta/c.1"
    data = bytearray(chunk.read_bytes())
    data[20] ^= 1
    chunk.write_bytes(data)
    with Ledger.opened(tmp_path) as store:
        assert store.unsound() == ["trajectory/1"]


@pytest.mark.parametrize("torn", [b"\xe8", b"0123 {"])
def test_a_torn_line_does_not_spoil_what_is_appended(torn: bytes, tmp_path: Path) -> None:
    go(tmp_path)
    whole = (tmp_path / LEDGER).read_bytes()
    (tmp_path / LEDGER).write_bytes(whole + torn)
    with Ledger.opened(tmp_path) as store:
        assert (tmp_path / LEDGER).read_bytes() == whole
        store.commit(changed={"more": 1})
    assert ledger.read(tmp_path, chunks=False).attributes["more"] == 1
