"""Printed text: control characters, width, units, and input with very many faults."""

import shutil
from pathlib import Path
from typing import Any

import pytest
from stores import edited
from typed import refused, typed

from tippetop.store import root
from tippetop.store.ledger import LEDGER, Acknowledged


SEQUENCE = "\x1b]0;title\x07\x1b[2J\x9b31m\u202e"


def texts(attrs: dict[str, Any], path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Return the paths of all texts in nested attributes."""
    found = []
    for name, value in attrs.items():
        if isinstance(value, dict):
            found += texts(value, (*path, name))
        elif isinstance(value, str):
            found.append((*path, name))
    return found


def test_info_prints_no_control_characters_of_a_store(
    short_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every text of the attributes in turn is replaced by terminal sequences."""
    store = shutil.copytree(short_run, tmp_path / "RUN.zarr")
    good, codes = (store / LEDGER).read_bytes(), set()
    for path in texts(root.root_of(store)):

        def change(records: list[dict[str, Any]], path: Any = path) -> None:
            table = records[-1]["changed"] = Acknowledged.of(records).attributes
            for name in path[:-1]:
                table = table[name]
            table[path[-1]] = SEQUENCE

        (store / LEDGER).write_bytes(good)
        edited(store, change)
        codes.add(typed(f"info {store}"))
        printed = capsys.readouterr()
        assert (printed.out + printed.err).replace("\n", "").isprintable(), path
    assert 0 in codes


def test_messages_have_no_control_characters_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "top.toml"
    file.write_text('system = "tippe-top"\n[run]\n"\\u001b[2J" = 1\n')
    assert r"`run.\x1b[2J`" in refused(f"check {file}")


def test_a_million_unknown_keys_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "many.toml"
    file.write_text("\n".join(['system = "tippe-top"', *(f"k{i} = 1" for i in range(30_000))]))
    assert typed(f"check {file}") == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 21
    assert lines[-1] == "tippetop: 29983 more faults were found."  # three tables are missing
