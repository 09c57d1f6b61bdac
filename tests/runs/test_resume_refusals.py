"""Of a store that was interrupted, what is there is compared with what must be there before a step is made."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from nightly import at_night
from stores import TURNING, files, short_slices

from tippetop import errors
from tippetop.cli import outcome
from tippetop.errors import StoreError
from tippetop.runs import recording, resuming
from tippetop.runs.integration import Integration
from tippetop.scenario import build
from tippetop.store import checkpoint, provenance, root
from tippetop.store.lock import LOCK


UNTIL = 30.0


@pytest.fixture(scope="module")
def half(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store that was interrupted after some chunks."""
    store = tmp_path_factory.mktemp("half") / "run.zarr"
    slices = iter(range(4))

    def stop(_: object) -> None:
        if next(slices) == 3:
            raise errors.Interrupted

    with pytest.MonkeyPatch.context() as patch:
        short_slices(patch)
        with pytest.raises(errors.Interrupted):
            recording.record(build.load("inverting", [*TURNING, "run.output_step=0.01"], UNTIL), store, progress=stop)
    return store


@pytest.fixture
def store(half: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, which is continued as it was begun."""
    short_slices(monkeypatch)
    return Path(shutil.copytree(half, tmp_path / "run.zarr"))


def test_a_damaged_chunk_is_said_on_resume(store: Path) -> None:
    chunk = store / "trajectory" / "theta" / "c.1"
    whole = chunk.read_bytes()
    for damage in (whole[: len(whole) // 2], whole[:100] + b"\x00" + whole[101:]):
        chunk.write_bytes(damage)
        with pytest.raises(StoreError, match=r"theta.* must be readable in rows 1000 to"):
            resuming.resume(store)
    chunk.unlink()
    with pytest.raises(StoreError, match="missing"):
        resuming.resume(store)


def test_a_damaged_checkpoint_or_other_equations_are_refused(store: Path) -> None:
    place = store / "checkpoint.json"
    kept = place.read_text()
    place.write_text(kept[: len(kept) // 2])
    with pytest.raises(StoreError, match="must have a whole checkpoint"):
        resuming.resume(store)
    place.write_text(kept)
    edited(store, lambda record: record["integration"].update(equations="0" * 16))
    with pytest.raises(StoreError, match="equations"):
        resuming.resume(store)


def edited(store: Path, edit: Callable[[dict], None]) -> None:
    """A checkpoint that was edited by somebody who computes its digest again."""
    record = json.loads((store / "checkpoint.json").read_text())
    edit(record)
    del record["digest"]
    (store / "checkpoint.json").write_text(json.dumps({**record, "digest": checkpoint.digest(record)}))


@pytest.mark.parametrize("key", ["rows", "filled"])
def test_numbers_of_a_checkpoint_that_were_changed_are_refused(key: str, store: Path) -> None:
    record = json.loads((store / "checkpoint.json").read_text())
    place = record if key in record else record["integration"]
    place[key] -= 1
    (store / "checkpoint.json").write_text(json.dumps(record))
    for read in (resuming.resume, root.attributes):
        with pytest.raises(StoreError, match="its digest is another"):
            read(store)


@pytest.mark.parametrize("table", ["parameters", "run", "versions"])
def test_a_scenario_that_was_changed_under_its_checkpoint_is_refused(table: str, store: Path) -> None:
    document = json.loads((store / "zarr.json").read_text())
    key, value = {"parameters": ("alpha", 0.31), "run": ("until", 99.0), "versions": ("heyoka", "0")}[table]
    document["attributes"][table][key] = value
    (store / "zarr.json").write_text(json.dumps(document))
    with pytest.raises(StoreError, match="its root attributes were changed"):
        resuming.resume(store)


@pytest.mark.parametrize("damage", ["removed", "metadata", "dtype", "units", "short", "extra"])
@pytest.mark.parametrize("group", ["trajectory", "events"])
def test_what_is_there_is_compared_with_what_must_be_there(
    group: str, damage: str, store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    column = store / group / "theta"
    document = json.loads((column / "zarr.json").read_text())
    if damage == "removed":
        shutil.rmtree(column)
    elif damage == "metadata":
        (column / "zarr.json").unlink()
    elif damage == "extra":
        shutil.copytree(column, store / group / "another")
    else:
        document["attributes"]["units"] = "deg" if damage == "units" else "rad"
        document["shape"] = [7] if damage == "short" else document["shape"]
        if damage == "dtype":
            document |= {"data_type": "int64", "fill_value": 0}
        (column / "zarr.json").write_text(json.dumps(document))
    before = files(store)
    monkeypatch.setattr(Integration, "run", never)
    with pytest.raises(StoreError, match=r"theta|another"):
        resuming.resume(store)
    assert {name: b for name, b in files(store).items() if name != LOCK} == {
        n: b for n, b in before.items() if n != LOCK
    }


def never(*_: object) -> None:
    raise AssertionError("a step was made")


@pytest.mark.parametrize("key", ["versions", at_night("cpu")])
def test_other_versions_resume_with_a_word_and_the_store_names_both(
    key: str, store: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    here = {"versions": provenance.versions(), "cpu": provenance.cpu()}
    other = {**here, key: {**here["versions"], "heyoka": "99"} if key == "versions" else "abacus"}
    with monkeypatch.context() as patched:
        patched.setattr(provenance, key, lambda: other[key])
        assert outcome(["resume", str(store)]) == 5
        assert "--accept-other-version" in capsys.readouterr().err
        assert outcome(["resume", str(store), "--accept-other-version"]) == 0
    attrs = root.attributes(store)
    assert attrs[key] == other[key]
    assert attrs["begun_with"] == [here]
    assert outcome(["info", str(store)]) == 0
    assert "begun with" in capsys.readouterr().out


def test_an_unfinished_store_can_be_looked_at(store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["info", str(store), "--json"]) == 0
    info = json.loads(capsys.readouterr().out)
    assert info["status"] == "running"
    assert 0 < info["t_end"] < UNTIL
    assert info["event_counts"]["turning"] > 100
    trajectory = xr.open_zarr(store, group="trajectory", consolidated=False)
    assert np.all(np.isfinite(trajectory["theta"]))
    assert outcome(["plot", str(store), "--out", str(tmp_path / "a.png")]) == 0
    with pytest.warns(UserWarning, match="is not finished: what is written is what there is of it so far"):
        assert outcome(["export", str(store), "--to", "csv", "--out", str(tmp_path / "a.csv")]) == 0


def test_acknowledged_rows_that_were_exchanged_are_refused(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chunks and checksums are sound, their places are not. Before, the run was finished with exit code 0."""
    one, other = (store / "trajectory" / name / "c.0" for name in ("theta", "phi"))
    mine, yours = one.read_bytes(), other.read_bytes()
    one.write_bytes(yours)
    other.write_bytes(mine)
    monkeypatch.setattr(Integration, "run", never)
    with pytest.raises(StoreError, match="acknowledged rows, but some of them are others"):
        resuming.resume(store)
    assert outcome(["export", str(store), "--to", "csv", "--out", str(tmp_path / "a.csv")]) == 5
