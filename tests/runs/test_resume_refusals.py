"""Of a store that was interrupted, what is there is compared with what must be there before a step
is made.
"""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from nightly import at_night
from stores import edited, exchange, interrupted, short_slices, state_of, turning
from typed import answered, refused, reported, typed

from tippetop.errors import StoreError
from tippetop.runs import resuming
from tippetop.runs.integration import Integration
from tippetop.store import provenance, root
from tippetop.store.ledger import LEDGER, digest


UNTIL = 30.0


@pytest.fixture(scope="module")
def half(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store that was interrupted after some chunks."""
    store = tmp_path_factory.mktemp("half") / "run.zarr"
    with pytest.MonkeyPatch.context() as patch:
        short_slices(patch)
        return interrupted(store, turning(UNTIL), slices=4)


@pytest.fixture
def store(half: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, which is continued as it was begun."""
    short_slices(monkeypatch)
    return shutil.copytree(half, tmp_path / "run.zarr")


def test_a_damaged_ledger_or_tail_or_other_equations_are_refused(store: Path) -> None:
    place, tail = store / LEDGER, store / state_of(store).tail
    kept, rows = place.read_bytes(), tail.read_bytes()
    for damaged, rest, sentence in (
        (kept.replace(b'"t_end":', b'"t_end":1', 1), rows, "line 1 of `ledger.jsonl` is damaged"),
        (kept[:100], rows, "is cut or has a line too many"),
        (kept, rows[:-1] + bytes([rows[-1] ^ 1]), "is another"),
    ):
        place.write_bytes(damaged)
        tail.write_bytes(rest)
        with pytest.raises(StoreError, match=sentence):
            resuming.resume(store)
    state = json.loads(rows.partition(b"\n")[0])
    state["integration"]["equations"] = "0" * 16
    rows = json.dumps(state).encode() + b"\n" + rows.partition(b"\n")[2]
    tail = store / f"tail-{digest(rows)}"
    tail.write_bytes(rows)
    place.write_bytes(kept)
    edited(store, lambda records: records[-1].update(tail=tail.name))
    with pytest.raises(StoreError, match="equations"):
        resuming.resume(store)


@pytest.mark.parametrize("damage", ["dtype", "units", "extra", "removed"])
@pytest.mark.parametrize("group", ["trajectory", "events"])
def test_what_is_there_is_compared_with_what_must_be_there(
    group: str, damage: str, store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A store whose ledger is sound, but not that of its scenario."""

    def change(records: list[dict]) -> None:
        members, tables = records[0]["members"], records[0]["tables"]
        theta = members[f"{group}/theta"]
        if damage == "extra":
            members[f"{group}/another"] = theta
        elif damage == "removed":
            tables[group].remove(f"{group}/theta")
            del members[f"{group}/theta"]
        elif damage == "units":
            theta["attributes"]["units"] = "deg"
        else:
            theta.update(data_type="int64", fill_value=0)

    monkeypatch.setattr(Integration, "run", never)
    (store / group / "another").mkdir()
    edited(store, change)
    with pytest.raises(StoreError, match=r"theta|another|damaged"):
        resuming.resume(store)


def never(*_: object) -> None:
    raise AssertionError("a step was made")


@pytest.mark.parametrize("key", ["versions", at_night("cpu")])
def test_other_versions_resume_with_a_word_and_the_store_names_both(
    key: str, store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = {"versions": provenance.versions(), "cpu": provenance.cpu()}
    other = {**here, key: {**here["versions"], "heyoka": "99"} if key == "versions" else "abacus"}
    with monkeypatch.context() as patched:
        patched.setattr(provenance, key, lambda: other[key])
        assert "--accept-other-version" in refused(f"resume {store}", 5)
        assert typed(f"resume {store} --accept-other-version") == 0
    attrs = root.attributes(store)
    assert attrs[key] == other[key]
    assert attrs["begun_with"] == [here]
    assert "begun with" in answered("info", store)[1]


def test_an_unfinished_store_can_be_looked_at(store: Path, tmp_path: Path) -> None:
    info = reported(f"info {store}")
    assert info["status"] == "running"
    assert 0 < info["t_end"] < UNTIL
    assert info["event_counts"]["turning"] > 100
    trajectory = xr.open_zarr(store, group="trajectory", consolidated=False)
    assert np.all(np.isfinite(trajectory["theta"]))
    assert typed(f"plot {store} --out {tmp_path}/a.png") == 0
    with pytest.warns(
        UserWarning, match="is not finished: only the rows up to its last commit are written"
    ):
        assert typed(f"export {store} --to csv --out {tmp_path}/a.csv") == 0


def test_acknowledged_rows_that_were_exchanged_are_refused(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chunks and checksums are sound, their places are not.

    Before, the run was finished with exit code 0.
    """
    exchange(store / "trajectory/theta/c.0", store / "trajectory/phi/c.0")
    monkeypatch.setattr(Integration, "run", never)
    with pytest.raises(StoreError, match="is damaged: a chunk of"):
        resuming.resume(store)
    assert typed(f"export {store} --to csv --out {tmp_path}/a.csv") == 5
