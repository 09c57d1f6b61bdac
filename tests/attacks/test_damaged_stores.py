"""A damaged store is refused in a sentence, or gives what the undamaged store gives.

A copy of a store is damaged once; then one command reads or continues it.
It is not seen: damage in two places that fit each other, forged checksums, damage during a read.
"""

import contextlib
import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import pytest
from damage import changed, garbled
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from kinds import CONTINUED, make
from stores import files
from typed import answered

import tippetop as tt
from tippetop.errors import InputError, StoreError


pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]
EDITS = ["bytes", "document", "swap", "copy", "parent", "foreign"]
REPLACES = ["gone", "folder", "pipe", "link", "moved"]
FOREIGN = ["0", "99", "x", "zarr.json", "ledger.jsonl", ".x.part-1", "c.0.new", "c.7"]


def contents(store: Path) -> Any:
    """Return every value and attribute that `open` gives; None if a value cannot be read."""
    found = tt.open(store)
    tables = [found.trajectory, found.events] if isinstance(found, tt.StoredRun) else [found]
    attributes = repr([table.attrs for table in tables])
    with contextlib.suppress(Exception):  # values are read by zarr
        values = [
            column.values.tobytes() for table in tables for column in table.variables.values()
        ]
        return attributes, values


def answer(question: str, store: Path, whole: Path) -> Any:
    """Return the answer to a question; None if the store is refused."""
    if question in ("open", "continue"):
        with contextlib.suppress(InputError, StoreError):
            if question == "open":
                return contents(store)
            make(whole.stem, store)
            return [(store / name).read_bytes() for name in files(whole)]
        return None
    out = store.with_name("made" + {"plot": ".png", "export": ".csv"}.get(question, ""))
    more = ["--json"] if question == "info" else ["--out", out]
    code, printed, _ = answered(question, store, *more, codes=(0, 2, 5))
    if code:
        return None
    return json.loads(printed) | {"store": ""} if question == "info" else out.read_bytes()


def damage(data: st.DataObject, store: Path, elsewhere: Path) -> None:
    """Damage a store once."""
    inside = sorted(path for path in store.rglob("*") if path.is_file())
    documents = [path for path in inside if path.suffix == ".json"]
    place = data.draw(st.sampled_from(data.draw(st.sampled_from([inside, documents]))))
    way = data.draw(st.sampled_from(EDITS + REPLACES))
    content = place.read_bytes()
    if way == "document" and place in documents:
        place.write_text(json.dumps(data.draw(changed(json.loads(content)))))
    elif way in ("bytes", "document"):
        place.write_bytes(data.draw(garbled(content)))
    elif way in ("swap", "copy"):
        other = data.draw(st.sampled_from(inside))
        place.write_bytes(other.read_bytes())
        if way == "swap":
            other.write_bytes(content)
    elif way == "parent":
        shutil.rmtree(place.parent)
    elif way == "foreign":
        with contextlib.suppress(IsADirectoryError):
            place.with_name(data.draw(st.sampled_from(FOREIGN))).write_bytes(b"foreign")
    elif way == "moved":
        shutil.move(place, elsewhere / "moved")
        place.symlink_to(elsewhere / "moved")
    else:
        place.unlink()
        if way == "folder":
            place.mkdir()
        elif way == "pipe":
            os.mkfifo(place)
        elif way == "link":
            targets = [elsewhere / "precious", elsewhere, "/dev/zero", "nowhere", place.name]
            place.symlink_to(data.draw(st.sampled_from(targets)))


@settings(max_examples=100, deadline=None, suppress_health_check=[*HealthCheck])
@given(data=st.data())
def test_a_damaged_store_is_refused_or_gives_the_same(stores: Path, data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(["run", "sweep", "surface"]))
    half = kind in CONTINUED and data.draw(st.booleans())
    more = ["export", "continue"] if kind in CONTINUED else []
    asked = data.draw(st.sampled_from(["open", "info", "plot", *more]))
    question = "continue" if half else asked
    whole = stores / f"{kind}.zarr"
    with tempfile.TemporaryDirectory() as name:
        store, elsewhere = Path(name) / "S.zarr", Path(name) / "elsewhere"
        shutil.copytree(stores / f"half-{kind}.zarr" if half else whole, store)
        elsewhere.mkdir()
        (elsewhere / "precious").write_text("not ours")
        expected = answer(question, Path(shutil.copytree(store, Path(name) / "T.zarr")), whole)
        (Path(name) / "made.png").unlink(missing_ok=True)
        (Path(name) / "made.csv").unlink(missing_ok=True)
        damage(data, store, elsewhere)
        before = files(elsewhere)
        assert answer(question, store, whole) in (None, expected)
        assert files(elsewhere) == before
