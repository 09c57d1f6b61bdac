"""The events of the tops of an ensemble and of a sweep are those of their runs, whatever computes
and interrupts them; records of the user travel to workers.
"""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from limits import assert_near
from refusals import refusal
from sections import RECORDS, SECTION
from stores import assert_same, flip
from typed import typed

import tippetop as tt
from tippetop.errors import StoreError
from tippetop.extending import Event
from tippetop.mechanics.operand import formula


SPINS = np.linspace(100.0, 200.0, 10)


def plan(source: str = "inverting", until: float = 1.0, **more: Any) -> dict[str, Any]:
    """A plan in chunks of three tops, the last of one."""
    axis = {"of": "initial.omega3", "values": SPINS}
    keep = ["status", "events", "sections", "spin_energy_end"]
    options = {"set": {"run": {"until": until}}, "chunk": 3, "keep": keep}
    return {"scenario": source, "axis": [axis], **options, **more}


def of_top(events: xr.Dataset, top: int) -> xr.Dataset:
    return events.isel(event=events.top.values == top)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A sweep with several files in a part."""
    store = tmp_path_factory.mktemp("whole") / "S.zarr"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tippetop.sweeps.store.PER_FILE", 50)
        tt.sweep(plan(), store, workers=1, **RECORDS)
        yield store


@pytest.mark.parametrize(("source", "until"), [("inverting", 4.0), ("plastic-toy", 0.5)])
def test_the_events_of_a_top_are_those_of_its_run(source: str, until: float) -> None:
    """In lanes, and one after the other where the contact changes."""
    tops, events = tt.ensemble(source, {"omega3": SPINS}, until=until, event_table=True, **RECORDS)
    assert (np.diff(events.top) >= 0).all()
    for top in (0, 4, 9):
        run = tt.run(source, start={"omega3": SPINS[top]}, until=until, **RECORDS)
        expected, found = run.events, of_top(events, top)
        assert found.sizes["event"] == expected.sizes["event"] > 10
        for name in ("kind", "significant", "theta_dot_sign"):
            np.testing.assert_array_equal(found[name], expected[name], err_msg=name)
        for name in ("time", "theta", "axis", "spin_energy"):
            np.testing.assert_allclose(found[name], expected[name], rtol=1e-11, atol=1e-11)
        end = float(run.trajectory.spin_energy[-1])
        assert float(tops.spin_energy_end[top]) == pytest.approx(end, rel=1e-12)


def test_the_table_is_what_the_columns_count() -> None:
    tops, events = tt.ensemble("inverting", {"omega3": SPINS}, until=4.0, event_table=True)
    plain = tt.ensemble("inverting", {"omega3": SPINS}, until=4.0)
    for name in plain.variables:
        assert tops[name].values.tobytes() == plain[name].values.tobytes(), name
    found = tt.dataframe(events)
    for kind, column in (("turning", "turnings"), ("equator", "equators")):
        some = found[(found.kind == kind) & found.significant]
        counts = np.bincount(some.top, minlength=len(SPINS))
        np.testing.assert_array_equal(counts, tops[column])


def test_invalid_tops_and_tops_without_events_have_no_rows() -> None:
    numbers = {"omega3": [np.nan, 155.0, 155.0], "until": [1.0, 1e-4, 1.0]}
    events = tt.ensemble("inverting", numbers, event_table=True)[1]
    assert set(events.top.values) == {2}
    none = tt.ensemble("inverting", {"omega3": [np.nan]}, until=1.0, event_table=True, **RECORDS)[1]
    assert none.sizes["event"] == 0
    quiet = tt.ensemble("inverting", {"omega3": SPINS}, until=1e-4, event_table=True)[1]
    assert quiet.sizes["event"] == 0
    assert "spin_energy" in none


def test_a_sweep_keeps_the_events_of_the_ensemble(whole: Path) -> None:
    """In other chunks, so that no bit depends on the neighbours of a top."""
    _, expected = tt.ensemble(
        "inverting", {"omega3": SPINS}, until=1.0, event_table=True, **RECORDS
    )
    found = tt.open(whole, group="events")
    assert set(found.variables) == set(expected.variables)
    for name in expected.variables:
        assert found[name].values.tobytes() == expected[name].values.tobytes(), name
        assert found[name].attrs == expected[name].attrs, name
    table = tt.open(whole)
    assert list(table) == ["status", "sections", "spin_energy_end"]
    kinds = tt.dataframe(found)
    counts = np.bincount(kinds[kinds.kind == "section"].top, minlength=len(SPINS))
    np.testing.assert_array_equal(counts, table.sections)


def test_workers_and_interruptions_change_no_byte(whole: Path, tmp_path: Path) -> None:
    def stop(done: int, of: int) -> None:
        if done == 6:
            raise KeyError

    tt.sweep(plan(), tmp_path / "workers.zarr", workers=2, **RECORDS)
    assert_same(tmp_path / "workers.zarr", whole)
    store = tmp_path / "S.zarr"
    with pytest.raises(KeyError):
        tt.sweep(plan(), store, workers=1, progress=stop, **RECORDS)
    some = tt.open(store, group="events")
    assert set(some.top.values) == {0, 1, 2, 3, 4, 5}
    tt.sweep(plan(), store, workers=1, **RECORDS)
    assert_same(store, whole)


def test_damaged_events_are_computed_again_with_their_tops(whole: Path, tmp_path: Path) -> None:
    store = shutil.copytree(whole, tmp_path / "S.zarr")
    flip(store / "events" / "time" / "c.1.0", 99)
    (store / "events" / "kind" / "c.0.2").unlink()
    with pytest.raises(StoreError, match="events"):
        tt.open(store, group="events")
    tt.sweep(plan(), store, workers=1, **RECORDS)
    assert_same(store, whole)


def test_a_sweep_is_continued_with_its_own_records_only(whole: Path) -> None:
    @formula
    def other(s, b):
        return s.ux

    changed = Event("section", SECTION.long_name, other, direction=1, kept=SECTION.kept)
    records = {**RECORDS, "events": ["turning", changed]}
    with pytest.raises(StoreError, match="the same events and columns of the user"):
        tt.sweep(plan(), whole, workers=1, **records)
    with refusal("`keep` must be of"):
        tt.sweep(plan(), whole, workers=1)
    with refusal("of a module that workers can import"):
        tt.sweep(plan(), whole, workers=2, **records)
    tt.sweep(plan(), whole, workers=1, **RECORDS)


def test_a_sweep_with_records_is_read_drawn_and_run_alone_without_them(tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    made = plan(until=0.2, runs=[4], keep=["class", "theta_end", "events"])
    tt.sweep(made, store, workers=1, **RECORDS)
    run = tt.open(store / "runs" / "4")
    assert "spin_energy" in run.trajectory
    expected, found = run.events, of_top(tt.open(store, group="events"), 4)
    assert_near(found.time, expected.time, 1e-12)
    assert tt.open(store, gridded=True)["class"].dims == ("initial.omega3",)
    for command in (f"info {store}", f"plot {store} class --out {tmp_path}/a.png"):
        assert typed(command) == 0
    for group in ("sweep", "events"):
        file = tmp_path / f"{group}.csv"
        assert typed(f"export {store} --to csv --group {group} --out {file}") == 0
    assert file.read_text().startswith("top,time [s],")
