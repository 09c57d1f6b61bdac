"""Test that growing columns make the same files in any pieces, and that damage is reported."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stores import assert_same

from tippetop.columns import Column
from tippetop.store import chunks, ledger, zarr3
from tippetop.store.ledger import Ledger
from tippetop.store.table import LATE, Table


CHUNK, ROWS = 8, 45  # five whole chunks and a part
GROUP = "trajectory"


def columns(rows: slice = slice(None)) -> dict[str, Column]:
    """Columns of one and of two dimensions, and of flags."""
    time = np.arange(ROWS) / 7
    values = {
        "time": time,
        "axis": np.stack([np.sin(time), np.cos(time), -time], axis=1),
        "flag": np.arange(ROWS) < 0,
    }
    dims = {"axis": ("time", "xyz")}
    return {
        name: Column(dims.get(name, ("time",)), v[rows], {"units": "1"})
        for name, v in values.items()
    }


def new(path: Path, of: dict[str, Column], chunk: int = CHUNK) -> list[Table]:
    """Empty tables in a new store; `flag` is a late column."""
    path.mkdir()
    tables: dict[str, dict[str, Any]] = {}
    for name, column in of.items():
        table = tables.setdefault(GROUP + LATE if name == "flag" else GROUP, {})
        table[f"{GROUP}/{name}"] = zarr3.array(column, {"time": (0, chunk)})
    store = Ledger.created(path, ledger.header({}, tables))
    return [Table(store, name) for name in tables]


def append(tables: list[Table], of: dict[str, Column]) -> None:
    for table in tables:
        table.append({name: column.values for name, column in of.items()})


def counts(tables: list[Table]) -> dict[str, int]:
    return {table.name: table.rows for table in tables}


def finish(tables: list[Table]) -> None:
    for table in tables:
        table.finish()
    tables[0].ledger.finish({"status": "finished"}, rows=counts(tables))
    tables[0].ledger.release()


def whole(path: Path, of: dict[str, Column] | None = None, chunk: int = CHUNK) -> Path:
    """All rows in one piece."""
    of = of or columns()
    tables = new(path, {name: c._replace(values=c.values[:0]) for name, c in of.items()}, chunk)
    append(tables, of)
    finish(tables)
    return path


def read(path: Path) -> dict[str, np.ndarray]:
    return next(chunks.pieces(path, GROUP, list(columns())))


@pytest.mark.parametrize(
    "pieces", [[45], [1] * 45, [8, 8, 8, 8, 8, 5], [7, 0, 38], [40, 5]], ids=len
)
def test_the_files_do_not_depend_on_the_pieces_nor_on_commits(
    pieces: list[int], tmp_path: Path
) -> None:
    tables, start = new(tmp_path / "a", columns(slice(0, 0))), 0
    store = tables[0].ledger
    for count in pieces:
        append(tables, columns(slice(start, start + count)))
        start += count
        data = b"".join(map(Table.tail, tables))
        store.commit(data, rows=counts(tables))
        store.derive(dict(file for table in tables for file in table.derived()))
        assert len(read(tmp_path / "a")["time"]) == tables[0].rows == start
        again = [Table(store, table.name) for table in tables]
        data += b"rest"
        for table, before in zip(again, tables, strict=True):
            data = table.restore(before.written, before.rows, data)
        assert data == b"rest"
        tables = again
    finish(tables)
    assert_same(tmp_path / "a", whole(tmp_path / "whole"))


def test_flags_are_set_in_any_row_until_the_end(tmp_path: Path) -> None:
    tables = new(tmp_path / "a", columns(slice(0, 0)))
    append(tables, columns())
    tables[1].mark("flag", [0, 9, 39, 40, 44])
    finish(tables)
    assert np.flatnonzero(read(tmp_path / "a")["flag"]).tolist() == [0, 9, 39, 40, 44]


# --- reading ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("count", "most"), [(1000, 2000), (1000, 100), (999, 10), (1001, 500)])
def test_a_thin_reading_keeps_the_extremes_of_every_bin(
    count: int, most: int, tmp_path: Path, rng: np.random.Generator
) -> None:
    """No value between two kept rows lies outside the kept values of its neighbourhood."""
    values = np.cumsum(rng.normal(size=count))
    values[count // 3] = np.nan
    of = {
        n: Column(("time",), v, {})
        for n, v in (("time", np.arange(float(count))), ("value", values))
    }
    whole(tmp_path / "a", of, 64)
    found = chunks.thin(tmp_path / "a", "trajectory", "value", most)
    rows = found["time"].values.astype(int)
    assert np.all(np.diff(rows) > 0)
    assert rows[-1] == count - 1
    np.testing.assert_array_equal(found["value"].values, values[rows])
    if most >= count:
        assert len(rows) == count
        return
    assert len(rows) <= most + 2
    size = -(-count // (most // 2))
    for start in range(0, count, size):
        inside = rows[(rows >= start) & (rows < start + size)]
        part = np.nan_to_num(values[start : start + size])
        assert np.nan_to_num(values[inside]).min() == part.min()
        assert np.nan_to_num(values[inside]).max() == part.max()
