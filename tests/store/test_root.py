"""What a store is: ours or not, of which format, finished or not; and how a new one comes to be."""

import json
from pathlib import Path

import numpy as np
import pytest
import zarr
from stores import edited
from typed import typed

import tippetop
from tippetop.columns import Column
from tippetop.errors import StoreError
from tippetop.store import ledger, provenance, root, zarr3
from tippetop.store.ledger import Ledger


def made(path: Path, **more: object) -> Path:
    """A small store of ours."""
    words = {"content": "potential", "title": "a top", "system": "tippe-top", "parameters": {}}
    column = Column(("time",), np.arange(3.0), {})
    tables = {"potential": {"potential/time": zarr3.array(column, {})}}
    head = ledger.header({**words, **provenance.provenance(), **more}, tables)
    with root.new_store(path) as scratch, Ledger.created(scratch, head) as store:
        store.put("potential/0", {"time": column.values})
        store.finish({"status": "finished"})
    return path


@pytest.mark.parametrize(
    "value",
    [
        np.float64("nan"),
        float("inf"),
        np.float32(-np.inf),
        {"a": [1.0, (float("nan"), np.int64(3))]},
        None,
        "text",
    ],
)
def test_attributes_are_plain_json(value: object) -> None:
    """Numbers that are not finite become null; no NaN, which JSON does not know."""
    text = json.dumps(root.finite({"value": value}), allow_nan=False)
    assert "NaN" not in text
    assert root.finite(json.loads(text)) == json.loads(text)


def test_a_store_says_what_made_it(tmp_path: Path) -> None:
    attrs = root.attributes(made(tmp_path / "a.zarr"))
    assert attrs["format"] == "tippetop"
    assert attrs["format_version"] == 2
    assert set(attrs["versions"]) >= {"python", "tippetop", "heyoka", "numpy", "zarr"}
    assert "unknown" not in attrs["versions"].values()
    assert attrs["cpu"]


def test_what_is_not_ours_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("x")
    zarr.open_group(store=str(tmp_path / "zarr"), mode="w", attributes={"format": "another"})
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "zarr.json").write_text("{")
    for name in ("folder", "file", "zarr", "broken", "nowhere"):
        must = {"file": "is a file, not a store", "nowhere": "does not exist"}.get(
            name, "must be a store of tippetop"
        )
        with pytest.raises(StoreError, match=f"{name}` {must}"):
            root.attributes(tmp_path / name)


def test_a_store_of_another_format_is_refused(tmp_path: Path) -> None:
    """A later one, and one from before there was a ledger; zarr reads the numbers of both."""
    path = made(tmp_path / "a.zarr")
    edited(path, lambda records: records[0].update(format=3))
    with pytest.raises(StoreError, match="its format is 3: use the release that wrote it"):
        root.attributes(path)
    (path / ledger.LEDGER).unlink()
    with pytest.raises(StoreError, match=r"is another zarr folder or of a preview \(format 1\)"):
        tippetop.open(path)
    assert typed(f"resume {path}") == 5
    with pytest.raises(StoreError, match="format 1"), root.new_store(path, overwrite=True):
        pass


def test_attributes_are_added_and_the_others_kept(tmp_path: Path) -> None:
    path = made(tmp_path / "a.zarr", old=1)
    root.annotate(path, {"new": float("nan"), "old": 2})
    found = root.attributes(path)
    assert (found["status"], found["old"], found["new"]) == ("finished", 2, None)


def test_a_group_is_a_dataset_with_the_attributes_of_the_store(tmp_path: Path) -> None:
    path = made(tmp_path / "a.zarr", title="a top")
    found = root.open_group(path, "potential")
    np.testing.assert_array_equal(found["time"], [0.0, 1.0, 2.0])
    assert found.attrs["title"] == "a top"
    with pytest.raises(StoreError, match="must hold a readable group `events`"):
        root.open_group(path, "events")


# --- how a new one comes to be ------------------------------------------------------------------


class Stop(Exception):
    """Something ends the writing."""


def stopped(target: Path, **options: bool) -> None:
    """Begins a store and stops."""
    before = sorted(target.parent.iterdir())
    with root.new_store(target, **options) as scratch:
        (scratch / "half").write_text("x")
        assert sorted(target.parent.iterdir()) == sorted([*before, scratch])
        raise Stop


def test_a_new_store_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "a.zarr"
    with pytest.raises(Stop):
        stopped(target)
    assert list(tmp_path.iterdir()) == []
    made(target)
    assert list(tmp_path.iterdir()) == [target]
