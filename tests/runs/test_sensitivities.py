"""A run keeps derivatives of its columns and events by numbers that its scenario names, in memory
and in its store.
"""

import csv
import json
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from stores import assert_same
from typed import typed

import tippetop as tt
from tippetop.engine.derivatives import along_run
from tippetop.errors import InputError
from tippetop.runs import sensitivities


WRT = ["parameters.alpha", "initial.theta"]
SETS = ["run.output_step=0.01", f"run.sensitivities={json.dumps(WRT)}"]


def made(store: Path, until: float) -> Path:
    tt.run("rolling-cylinder", SETS, until=until, out=store)
    return store


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("runs") / "run.zarr", 1.0)


def test_they_are_the_derivatives_that_python_gives(store: Path) -> None:
    run, alone = (
        tt.open(store),
        tt.derivatives.sensitivities("rolling-cylinder", WRT, until=1.0, output_step=0.01),
    )
    assert set(run.sensitivities) == set(alone.trajectory)
    for name, values in alone.trajectory.items():
        np.testing.assert_array_equal(run.sensitivities[name], values)
    np.testing.assert_array_equal(run.event_sensitivities.time, alone.events.time)
    assert np.isfinite(run.event_sensitivities.time).all()
    assert run.event_sensitivities.time.shape == (len(run.events.time), 2)
    assert list(run.sensitivities.parameter.values) == WRT
    assert "derivatives of columns and events by parameters.alpha, initial.theta" in str(run)
    assert run.summary.to_dict()["run"]["sensitivities"] == WRT


def test_a_saved_run_is_the_recorded_one(store: Path, tmp_path: Path) -> None:
    run = tt.run("rolling-cylinder", SETS, until=1.0)
    run.save(tmp_path / "saved.zarr")
    assert_same(tmp_path / "saved.zarr", store)
    assert run.to_datatree()["sensitivities"].theta.sel(parameter="initial.theta")[
        0
    ] == pytest.approx(1.0)


def test_killed_while_they_are_made_and_continued_to_a_later_end_nothing_shows(
    store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    longer = tmp_path / "run.zarr"
    with monkeypatch.context() as patch:
        patch.setattr(along_run, "differentiate", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            made(longer, 0.7)
    assert tt.open(longer).attributes["status"] == "running"
    tt.resume(longer)
    assert_same(longer, made(tmp_path / "undisturbed.zarr", 0.7))
    tt.resume(longer, until=1.0)
    assert_same(longer, store)


def test_of_a_log_that_is_too_long_the_first_events_have_theirs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = tt.run("rolling-cylinder", SETS, until=1.0)
    monkeypatch.setattr(sensitivities, "MOST_DERIVATIVES", 2)
    some = tt.run("rolling-cylinder", SETS, until=1.0)
    np.testing.assert_array_equal(
        some.event_sensitivities.time[:1], whole.event_sensitivities.time[:1]
    )
    assert np.isnan(some.event_sensitivities.time[1:]).all()
    np.testing.assert_array_equal(some.event_sensitivities["kind"], whole.events["kind"])


def test_they_are_exported_by_what_stands_over_what(store: Path, tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    assert typed(f"export {store} --to csv --group sensitivities --out {file}") == 0
    with file.open() as rows:
        table = list(csv.DictReader(rows))
    values = [float(row["d_theta/d_initial.theta"]) for row in table]
    np.testing.assert_array_equal(
        values, tt.open(store).sensitivities.theta.sel(parameter="initial.theta")
    )


def test_rows_that_keep_few_columns_keep_their_derivatives() -> None:
    run = tt.run("rolling-cylinder", SETS, until=0.1, columns=["theta"])
    assert set(run.sensitivities.data_vars) == {"theta"}


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        (["run.precision=quad"], '`precision` must be "double" for derivatives'),
        (
            ["run.output=events", "run.output_step="],
            '`output` must be "times" where `sensitivities`',
        ),
        (["run.output_step=1e-7"], "at most 1,000,000 rows where `sensitivities` names 1"),
        (['run.sensitivities=["friction.nu"]'], r"`friction\.nu` must be one of"),
        (['run.sensitivities=["friction.mu", "friction.mu"]'], "is named twice"),
        (["contact.e_n=0.5"], "the contact must never change for derivatives"),
    ],
)
def test_what_cannot_be_is_a_sentence(sets: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        tt.run("inverting", ['run.sensitivities=["friction.mu"]', *sets], until=1.0)


def test_an_ensemble_keeps_no_rows_to_differentiate() -> None:
    with pytest.raises(InputError, match="must not be given in an ensemble"):
        tt.ensemble(
            "inverting", {"mu": [0.1, 0.2]}, ['run.sensitivities=["friction.mu"]'], until=0.01
        )
