"""A damaged ledger costs nothing that was acknowledged, whoever continues the store.

A bit is flipped, the end is cut off, or lines are exchanged. Then the store is continued by the
versions that wrote it and by others: it becomes that of an undisturbed run, or it is refused and
stays as it is.
"""

import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from kinds import CONTINUED, KINDS, make
from nightly import at_night
from stores import files, state_of
from typed import typed

from tippetop.errors import StoreError
from tippetop.store import ledger, provenance
from tippetop.store.ledger import LEDGER, Ledger


def lines_of(raw: bytes) -> list[bytes]:
    return raw.splitlines(keepends=True)


def flipped(raw: bytes, first: int, last: int, chance: random.Random) -> bytes:
    place = chance.randrange(first, last)
    bit = 1 << chance.randrange(8)
    return raw[:place] + bytes([raw[place] ^ bit]) + raw[place + 1 :]


def cut_off(raw: bytes, first: int, last: int, chance: random.Random) -> bytes:
    return raw[: chance.randrange(first, last)]


def exchanged(raw: bytes, first: int, last: int, chance: random.Random) -> bytes:
    """A line takes the place of this one, which takes its place or is lost."""
    lines = lines_of(raw)
    here = len(lines_of(raw[:first]))
    other = chance.choice([k for k in range(len(lines)) if k != here])
    mine, lines[here] = lines[here], lines[other]
    if chance.random() < 0.5:
        lines[other] = mine
    return b"".join(lines)


DAMAGES: tuple[Callable[..., bytes], ...] = (flipped, cut_off, exchanged)


def damaged(raw: bytes, way: int, chance: random.Random) -> bytes:
    """A ledger that is damaged in its last line, or in another one."""
    lines = lines_of(raw)
    which = len(lines) - 1 if way % 2 else chance.randrange(len(lines))
    first = sum(map(len, lines[:which]))
    return DAMAGES[way // 2 % len(DAMAGES)](raw, first, first + len(lines[which]), chance)


def refused(kind: str, store: Path) -> bool:
    """Whether a store that is continued is refused."""
    try:
        make(kind, store)
    except StoreError:
        return True
    return False


@pytest.mark.filterwarnings("ignore:`.*a killed run left it")
@pytest.mark.parametrize("count", [6, at_night(110)])
@pytest.mark.parametrize("name", [*CONTINUED, *(f"half-{kind}" for kind in CONTINUED)])
def test_a_damaged_ledger_costs_nothing_acknowledged(
    name: str, count: int, stores: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kind, half = name.rpartition("-")[2], name.startswith("half")
    whole, store = files(stores / f"{kind}.zarr"), tmp_path / "S.zarr"
    raw = (stores / f"{name}.zarr" / LEDGER).read_bytes()
    here, chance = provenance.versions(), random.Random(count)
    for way in range(count):
        bad = damaged(raw, way, chance)
        for versions in (here | {"heyoka": "0.0.0"}, here):
            shutil.rmtree(store, ignore_errors=True)
            shutil.copytree(stores / f"{name}.zarr", store)
            (store / LEDGER).write_bytes(bad)
            before = files(store)
            monkeypatch.setattr(provenance, "versions", lambda told=versions: told)
            is_whole = typed(f"info {store}") == 0
            assert half or not is_whole, "a damaged finished store is reported"
            if refused(kind, store):
                assert files(store) == before, "a store that is refused stays as it is"
                assert versions != here or not is_whole, "what `info` accepts can be continued"
            else:
                assert versions == here
                assert files(store) == whole, "the store of an undisturbed run"


def test_no_file_of_a_dropped_line_is_removed_before_the_end(stores: Path, tmp_path: Path) -> None:
    """Of an append that was cut off the line, the tail and the chunks are set aside."""
    store = shutil.copytree(stores / "half-sweep.zarr", tmp_path / "S.zarr")
    raw = (store / LEDGER).read_bytes()
    (store / LEDGER).write_bytes(raw[:-9])
    before = files(store)
    with Ledger.opened(store) as opened:
        assert files(store) == before | {"writer.new": files(store)["writer.new"]}
        opened.recover()
    kept = set(files(store).values())
    assert {data for name, data in before.items() if "/c." in name} <= kept
    assert lines_of(raw)[-1][:-9] in kept
    assert len(state_of(store).chunks) == len(ledger.records_of(raw)) - 3
    make("sweep", store)
    assert files(store) == files(stores / "sweep.zarr")


def test_the_only_line_of_a_ledger_and_one_after_its_seal_are_damage(
    stores: Path, tmp_path: Path
) -> None:
    for kind in KINDS:
        store = shutil.copytree(stores / f"{kind}.zarr", tmp_path / kind)
        raw = (store / LEDGER).read_bytes()
        for bad in (raw + b"\0", raw[:-1], lines_of(raw)[0], raw[: len(raw) // 2], b""):
            (store / LEDGER).write_bytes(bad)
            assert typed(f"info {store}") == 5
