"""Keyframes and replay: a run that keeps no rows gives those of any part, with the bits that it
would have stored.
"""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from nightly import at_night
from stores import files, interrupted, turning
from typed import typed

import tippetop as tt
from tippetop.errors import StoreError
from tippetop.runs import recording, replay
from tippetop.runs.summary import lines
from tippetop.sampling import EvenTimes
from tippetop.store import root


KEYFRAMES = ["run.output_step=", "run.output=keyframes", "run.keyframe_steps=100"]


def stored(store: Path, until: float, *sets: str) -> Path:
    recording.record(turning(until, "run.output_step=0.1", *sets), store)
    return store


def listed(times: np.ndarray) -> str:
    return f"run.output_times={times.tolist()}"


def times_of(start: float, until: float, step: float) -> np.ndarray:
    times = start + np.arange(10_000) * step
    return np.append(times[times < until - 1e-9 * step], until)


def same_columns(mine: xr.Dataset, yours: xr.Dataset) -> None:
    assert sorted(mine.variables) == sorted(yours.variables)
    for name in yours.variables:
        assert (
            np.asarray(mine[name].values).tobytes() == np.asarray(yours[name].values).tobytes()
        ), name


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return stored(tmp_path_factory.mktemp("kept") / "run.zarr", 40.0, *KEYFRAMES)


def test_a_store_of_keyframes_holds_them_the_events_and_the_summary_of_the_same_run(
    kept: Path, tmp_path: Path
) -> None:
    rows = stored(tmp_path / "rows.zarr", 40.0)
    attrs, with_rows = root.attributes(kept), root.attributes(rows)
    assert attrs["report"] == with_rows["report"]
    assert attrs["final_state"] == with_rows["final_state"]
    for name, content in files(rows / "events").items():
        assert (kept / "events" / name).read_bytes() == content
    frames = root.open_group(kept, "keyframes")
    assert frames["step"].values.tolist() == list(range(100, attrs["report"]["steps"], 100))
    assert np.all(np.diff(frames["time"]) > 0)
    assert tt.open(kept).trajectory.sizes["time"] == 0
    assert sum(len(content) for content in files(kept / "keyframes").values()) < 200_000


@pytest.mark.parametrize(
    ("start", "until", "step"), [(0.0, 3.0, 0.01), (20.0, 21.0, 1e-3), (39.5, 40.0, 0.017)]
)
def test_a_replay_has_the_bits_of_the_rows_that_the_run_would_have_stored(
    start: float, until: float, step: float, kept: Path, tmp_path: Path
) -> None:
    times = times_of(start, until, step)
    rows = tt.open(stored(tmp_path / "rows.zarr", 40.0, "run.output_step=", listed(times)))
    same_columns(tt.open(kept).replay(start, until, step), rows.trajectory)


def test_a_replay_does_not_take_the_place_of_its_run(kept: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(kept)
    before = files(kept)
    for out in (kept, tmp_path / "link"):
        with pytest.raises(StoreError, match="must not be the store that is replayed"):
            replay.into_store(kept, EvenTimes(1e-3, 30.01, 30.0), out, overwrite=True)
    assert files(kept) == before


@pytest.mark.parametrize("precision", ["longdouble", at_night("quad")])
def test_a_replay_in_wider_numbers_has_the_same_bits(precision: str, tmp_path: Path) -> None:
    wide = [f"run.precision={precision}", "run.keyframe_steps=20"]
    store = stored(tmp_path / "kept.zarr", 1.0, *KEYFRAMES, *wide)
    assert root.open_group(store, "keyframes").sizes["keyframe"] > 1
    times = times_of(0.9, 1.0, 0.01)
    rows = stored(
        tmp_path / "rows.zarr", 1.0, "run.output_step=", listed(times), f"run.precision={precision}"
    )
    same_columns(tt.open(store).replay(0.9, 1.0, 0.01), tt.open(rows).trajectory)


def test_a_replay_reaches_the_liftoff_that_ended_the_run(tmp_path: Path) -> None:
    sets = ["initial.omega3=300.0", "initial.theta=0.1", "initial.phi_dot=0.0", "friction.mu=0.3"]
    store = stored(tmp_path / "kept.zarr", 10.0, *sets, *KEYFRAMES)
    attrs = root.attributes(store)
    assert attrs["status"] == "liftoff"
    end = attrs["report"]["t_end"]
    times = np.append(times_of(0.0, end, end / 64)[:-1], end)
    rows = tt.open(stored(tmp_path / "rows.zarr", 10.0, *sets, "run.output_step=", listed(times)))
    same_columns(tt.open(store).replay(0.0, end, end / 64), rows.trajectory)


def test_a_run_with_rows_is_replayed_from_its_start(tmp_path: Path) -> None:
    store = stored(tmp_path / "run.zarr", 4.0)
    same_columns(tt.open(store).replay(0.0, 4.0, 0.1), tt.open(store).trajectory)


def test_the_command_writes_a_store_with_rows_and_the_events_of_that_time(
    kept: Path, tmp_path: Path
) -> None:
    out = tmp_path / "rows.zarr"
    words = f"replay {kept} --from 20 --until 21 --step 0.001 --out {out}"
    assert typed(words) == 0
    run = tt.open(out)
    same_columns(run.trajectory, tt.open(kept).replay(20.0, 21.0, 0.001))
    log = tt.open(kept).events
    within = (log.time >= 20.0) & (log.time <= 21.0)
    assert int(within.sum()) > 0
    same_columns(run.events, log.isel(event=within.values))
    assert run.summary.replay.until == 21.0
    said = dict(lines(run.summary))["replay"]
    assert said.startswith("rows and events are of t = 20 to 21 s, every 0.001 s, of ../")
    assert (tmp_path / run.summary.replay.of).samefile(kept)
    assert typed(words) == 5
    assert typed(f"{words} --overwrite") == 0
    same_columns(run.replay(20.5, 20.6, 0.01), tt.open(kept).replay(20.5, 20.6, 0.01))


def test_a_run_that_is_not_finished_is_not_replayed(tmp_path: Path) -> None:
    store = interrupted(tmp_path / "run.zarr", turning(100.0, *KEYFRAMES))
    with pytest.raises(StoreError, match="must be finished to be replayed"):
        tt.open(store).replay(1.0, 2.0, 0.1)
