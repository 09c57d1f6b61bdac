"""A store knows the events and columns of one's own again: with others it is not continued,
replayed or certified.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from refusals import refusal

import tippetop as tt
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import ONE


@formula
def leaves(s, b):
    """theta exceeds 0.1 rad."""
    return s.z - 0.99501


@formula
def leaves_later(s, b):
    """theta exceeds a little more."""
    return s.z - 0.9951


@formula
def height(s, b):
    """cos(theta)."""
    return s.z


@formula
def seven(s, b):
    """7 cos(theta)."""
    return 7 * s.z


GONE = tt.extending.Event(
    "gone",
    "it has gone",
    leaves,
    ends="gone",
    kept=(tt.extending.Kept("left", "first", "when it went"),),
)
HEIGHT = tt.extending.Quantity("height", "h", ONE, "the height", height)
MINE = {"events": [GONE], "columns": [HEIGHT]}
OTHERS = [
    {**MINE, "columns": [dataclasses.replace(HEIGHT, formula=seven)]},
    {**MINE, "events": [dataclasses.replace(GONE, formula=leaves_later)]},
    {**MINE, "events": [dataclasses.replace(GONE, kept=())]},
    {**MINE, "events": [GONE, dataclasses.replace(GONE, name="more", kept=())]},
]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that an event of one's own has ended."""
    place = tmp_path_factory.mktemp("own") / "run.zarr"
    tt.run("inverting", until=0.1, out=place, **MINE)
    return place


@pytest.mark.parametrize("others", OTHERS)
def test_other_records_under_the_same_names_are_refused(store: Path, others: dict) -> None:
    """Continued with them, one column was of two formulas, and a certificate was of another run."""
    with refusal(r"must be one that the run was made with"):
        tt.open(store, **others).certify()
    with refusal(r"must be one that the run was made with"):
        tt.open(store, **others).replay(0.0, 1e-3, 1e-3)


def test_the_window_of_a_certificate_ends_where_the_run_does(store: Path) -> None:
    run = tt.open(store, **MINE)
    assert 0 < run.summary.t_end < 0.01
    result = run.certify()
    assert result.window == [0.0, run.summary.t_end]
    assert result.same_end


@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_a_run_and_an_ensemble_keep_the_same_of_the_passages_that_an_event_detects(
    direction: int,
) -> None:
    """A number of rising passages, of an event that detects falling ones, is of none."""
    ways = {-1: "falling", 0: "all", 1: "rising"}
    kept = [
        tt.extending.Kept(f"{what}_{ways[way]}", what, "x", way)
        for what in ("count", "first", "last")
        for way in ways
    ]
    event = tt.extending.Event("cross", "x", leaves, direction=direction, kept=tuple(kept))
    run = tt.run("inverting", until=1.0, events=[event])
    many = tt.ensemble("inverting", {"omega3": [155.0]}, until=1.0, events=[event])
    for name, value in run.summary.kept.items():
        if value is None:
            assert np.isnan(float(many[name][0])), name
        else:
            assert float(many[name][0]) == pytest.approx(value, rel=1e-9), name
    own = run.summary.kept
    if direction:
        assert (own[f"count_{ways[-direction]}"], own[f"first_{ways[-direction]}"]) == (0, None)
        assert own[f"count_{ways[direction]}"] == own.count_all > 0
    assert f"count_all = {own.count_all}, " in str(run)
    assert f"first_all = {own.first_all:.9g} s" in str(run)
