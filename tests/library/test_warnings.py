"""Warnings of runs from Python: once per run, at the caller's line, and in the printed run."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from examples import CANONICAL
from typed import typed

import tippetop as tt
from tippetop.errors import TippetopWarning
from tippetop.runs import certificate


TOP, LAW = tt.TippeTop(**CANONICAL), tt.friction.Viscous(mu=0.3)
START = {"theta": 0.1, "omega3": 155.0}


def warned(call: Callable[[], tt.Run]) -> tuple[tt.Run, list[str]]:
    """Return a run and its warnings."""
    with pytest.warns(TippetopWarning) as caught:
        run = call()
    assert {warning.filename for warning in caught} == {__file__}
    return run, [str(warning.message) for warning in caught]


def test_a_doubtful_scenario_is_one_warning_for_each_doubt(tmp_path: Path) -> None:
    heavy = tt.TippeTop(**CANONICAL | {"I1": 14.9, "I3": 15.6})
    for out in (None, tmp_path / "run.zarr"):
        run, sentences = warned(lambda: tt.run(heavy, LAW, until=0.1, out=out))  # noqa: B023
        assert sentences == run.warnings
        for words in ("does not spin", "stays there", "`parameters.I1`", "`parameters.I3`"):
            assert [words in sentence for sentence in sentences].count(True) == 1
        assert all(str(run).count(sentence) == 1 for sentence in sentences)


def test_a_broken_promise_is_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(certificate.MAX_DRIFT, "jellett", 1e-18)
    monkeypatch.setattr(certificate, "MAX_THETA_ERROR", 1e-18)
    place = tmp_path / "run.zarr"
    for call in (
        lambda: tt.run(TOP, LAW, start=START, until=0.5),
        lambda: tt.run(TOP, LAW, start=START, until=0.5, out=place),
        lambda: tt.resume(place, until=1.0),
    ):
        run, (sentence,) = warned(call)
        assert sentence.startswith("the accuracy contract is broken: the drift of jellett")
        assert run.warnings == [sentence]
    with pytest.warns(TippetopWarning, match="theta must be within") as caught:
        run.certify(0.1)
    assert len(caught) == 1
    assert len(run.warnings) == 2


def test_a_run_that_keeps_its_promises_has_no_warning() -> None:
    run = tt.run(TOP, LAW, start=START, until=0.1)
    assert run.warnings == []
    assert "warning" not in str(run)


def test_the_command_line_prints_a_doubt_once(capsys: pytest.CaptureFixture[str]) -> None:
    typed("run inverting --until 0.1 --set initial.theta=")
    printed = capsys.readouterr()
    assert (printed.out + printed.err).count("stays there") == 1


HEAVY = CANONICAL | {"I1": 14.9}
AXIS = {"of": "initial.omega3", "values": [150.0, 155.0, 160.0]}


def many(heavy: bool, place: Path, **numbers: object) -> list[Callable[[], object]]:
    """Return an ensemble and a sweep of three spins, and the sweep once more."""
    body = tt.TippeTop(**(HEAVY if heavy else CANONICAL))
    plan = {
        "scenario": {
            "system": "tippe-top",
            "parameters": HEAVY if heavy else CANONICAL,
            "friction": {"law": "viscous", "mu": 0.3},
            "initial": {"theta": 0.1},
            "run": {"until": 0.5, **numbers},
        },
        "axis": [AXIS],
    }
    start = {"theta": 0.1}
    return [
        lambda: tt.ensemble(
            body, {"omega3": AXIS["values"]}, LAW, start=start, until=0.5, **numbers
        ),
        lambda: tt.sweep(plan, place),
        lambda: tt.sweep(plan, place),
    ]


def test_doubts_about_many_tops_are_warnings_once(tmp_path: Path) -> None:
    """The varied spin is given, and the inertia is wrong."""
    for call in many(True, tmp_path / "sweep.zarr"):
        with pytest.warns(TippetopWarning) as caught:
            call()
        (warning,) = caught
        assert warning.filename == __file__
        assert "`parameters.I1` is 14.9 kg m2" in str(warning.message)


def test_the_number_of_tops_that_break_the_contract_is_one_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = many(False, tmp_path / "sweep.zarr")
    drift = calls[0]().drift_jellett.values
    bound = np.sort(drift)[1]
    assert drift.min() < bound < drift.max()
    monkeypatch.setitem(certificate.MAX_DRIFT, "jellett", bound)
    for call in calls:
        with pytest.warns(TippetopWarning, match="broken by 1 of 3 tops: ") as caught:
            call()
        (warning,) = caught
        assert warning.filename == __file__
    many(False, tmp_path / "loose.zarr", tolerance=1e-10)[0]()  # promises nothing
