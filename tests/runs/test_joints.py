"""The events and impacts of the parts of a run are those of the whole, however it is cut."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import CANONICAL
from limits import assert_near
from nightly import at_night
from stores import assert_same
from typed import typed

import tippetop as tt
from tippetop.columns import flag_words


Rows = list[tuple[str, float]]
STRIKES = {
    "parameters": CANONICAL,
    "friction": {"law": "coulomb", "mu": 0.3},
    "contact": {"e_n": 0.5},
    "initial": {"theta": 0.5, "omega3": 100.0, "nu_z": -0.3},
    "run": {"output_step": 0.01},
    "system": "tippe-top",
}
"""A top that strikes the plane at t = 0."""


def events(run: Any, after: float = 0.0) -> Rows:
    """Kinds and times [s] of events, and times of impacts, of a run that begins `after`."""
    rows = flag_words(run.events.kind).tolist(), run.events.time.values
    hits = run.datasets()["impacts"].time.values if "impacts" in run.datasets() else []
    pairs = [*zip(*rows, strict=True), *(("row of impacts", t) for t in hits)]
    return [(kind, after + float(t)) for kind, t in pairs]


def assert_joined(found: Rows, expected: Rows, atol: float = 1e-11) -> None:
    """Compare kinds, and times of events of each kind."""
    assert [kind for kind, _ in sorted(found)] == [kind for kind, _ in sorted(expected)]
    times = [[t for _, t in sorted(rows)] for rows in (found, expected)]
    assert_near(*times, atol)


def cuts(run: Any, count: int) -> list[float]:
    """Times of events of a run, at random, before its bounces follow each other in 10 us."""
    times = np.unique(run.events.time.values)
    times = times[times > 0]
    crowded = np.flatnonzero(np.diff(times) < 1e-5)
    times = times[: crowded[0]] if len(crowded) else times
    return np.random.default_rng(47).permutation(times)[:count].tolist()


@pytest.mark.parametrize(
    ("source", "until", "count"),
    [
        ("inverting", 2.0, 2),
        ("flying", 0.2, 2),
        ("leine-glocker", 0.2, 2),
        (STRIKES, 0.055, 2),
        at_night(STRIKES, 0.055, 20),
        at_night("inverting", 6.0, 60),
        at_night("heavy-top", 5.0, 40),
        at_night("flying", 0.5, 60),
        at_night("leine-glocker", 0.4, 40),
        at_night("leine-glocker-drilling", 0.4, 40),
        at_night("leine-glocker-stem", 0.4, 40),
        at_night("cohen-coulomb", 1.0, 40),
        at_night("gliding-cylinder", 4.0, 40),
    ],
)
def test_the_events_of_the_parts_are_those_of_the_whole(
    source: Any, until: float, count: int, tmp_path: Path
) -> None:
    """Cut at the time of an event, where rounding decides in which part it is."""
    whole = tt.run(source, until=until, output_step=0.01)
    name = source if isinstance(source, str) else {**source, "initial": {}}
    for k, cut in enumerate(cuts(whole, count)):
        first = tt.run(source, until=cut, output_step=0.01, out=tmp_path / f"{k}.zarr")
        rest = tt.run(name, start=first.path, until=until - cut, output_step=0.01)
        assert_joined(events(first) + events(rest, cut), events(whole))
        assert_joined(events(tt.resume(first.path, until=until)), events(whole))


def test_a_run_that_strikes_at_its_start_is_extended_with_all_its_tables(tmp_path: Path) -> None:
    whole = tt.run(STRIKES, until=0.05, out=tmp_path / "whole.zarr")
    tt.run(STRIKES, until=0.02, out=tmp_path / "a.zarr")
    tt.resume(tmp_path / "a.zarr", until=0.05)
    assert_same(tmp_path / "a.zarr", whole.path)
    hits = whole.datasets()["impacts"].time.values
    assert hits[0] == 0
    np.testing.assert_array_equal([t for kind, t in events(whole) if kind == "impact"], hits)


def test_an_event_is_in_one_of_two_replays_that_follow_each_other(tmp_path: Path) -> None:
    whole = tt.run(STRIKES, until=0.05, out=tmp_path / "whole.zarr")
    cut = float(whole.events.time.values[3])
    found: Rows = []
    for start, until in ((0.0, cut), (cut, 0.05)):
        part = tmp_path / f"{start}.zarr"
        words = f"--from {start!r} --until {until!r} --step 0.01 --out {part}"
        assert typed(f"replay {whole.path} {words}") == 0
        found += events(tt.open(part))
    assert_joined(found, events(whole), 0.0)


def test_a_joint_with_another_law_loses_no_turning(tmp_path: Path) -> None:
    whole = tt.run("inverting", until=2.0)
    for k, cut in enumerate(cuts(whole, 5)):
        first = tt.run("inverting", until=cut, out=tmp_path / f"{k}.zarr")
        rest = tt.run("inverting", {"mu": 0.29}, start=first.path, until=0.02)
        found = events(first) + events(rest, cut)
        assert sum(abs(t - cut) < 1e-9 for _, t in found) == 1
