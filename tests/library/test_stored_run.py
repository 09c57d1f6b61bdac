"""A run in a store is read when it is asked for, and says what the run in memory says."""

import shutil
from pathlib import Path
from typing import Any

import pytest
from refusals import refusal
from stores import edited

import tippetop as tt
from tippetop.library import finished_run as library
from tippetop.runs.results import Record
from tippetop.runs.run import solve


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run("inverting", until=0.2)


@pytest.fixture(scope="module")
def place(run: tt.Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run.save(tmp_path_factory.mktemp("stores") / "run.zarr")


@pytest.fixture
def stored(place: Path) -> tt.StoredRun:
    found = tt.open(place)
    assert isinstance(found, tt.StoredRun)
    return found


def test_nothing_but_the_attributes_is_read_before_it_is_asked_for(
    stored: tt.StoredRun, run: tt.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Text, summary and drift do without the tables; the two tables are opened once, together."""
    opened: list[Any] = []
    inner = library.root.open_group

    def open_group(path: Path, name: str) -> Any:
        opened.append(name)
        return inner(path, name)

    monkeypatch.setattr(library.root, "open_group", open_group)
    assert str(stored).splitlines()[0] == str(run).splitlines()[0]
    assert stored.drift.to_dict() == run.drift.to_dict()
    assert stored.summary.to_dict() == run.summary.to_dict()
    assert opened == []
    for _ in range(2):
        assert stored.trajectory.sizes["time"] == run.trajectory.sizes["time"]
        assert stored.events.sizes["event"] == run.events.sizes["event"]
    assert sorted(opened) == ["events", "trajectory"]


def test_the_text_of_both_is_the_same_but_for_the_time_it_took(
    stored: tt.StoredRun, run: tt.Run
) -> None:
    mine, other = str(stored).splitlines(), str(run).splitlines()
    assert mine[2:] == other[2:]
    assert other[1].startswith(mine[1] + ", integrated in ")


def test_what_a_store_does_not_keep_is_said(stored: tt.StoredRun) -> None:
    with refusal(r"is in the store .* already: copy that"):
        stored.save("elsewhere.zarr")


def test_its_problem_gives_the_same_run_again(stored: tt.StoredRun, run: tt.Run) -> None:
    again = tt.Run(solve(stored.problem))
    assert again.trajectory.identical(run.trajectory)


def test_a_store_of_a_system_that_is_not_here_opens(place: Path, tmp_path: Path) -> None:
    """Its tables and text are there; only its problem is not, and that is said in a sentence."""
    copy = tmp_path / "copy.zarr"
    shutil.copytree(place, copy)
    edited(copy, lambda records: records[0]["attributes"].update(system="of-another-package"))
    stored = tt.open(copy)
    assert stored.trajectory.sizes["time"] > 0
    assert "drift" in str(stored)
    assert stored.summary.system == "of-another-package"
    with refusal("`system` must be one of"):
        _ = stored.problem


def test_html_is_escaped_and_has_a_row_for_each_line(stored: tt.StoredRun) -> None:
    text, _, page = stored._repr_html_().partition("<details>")
    assert page.endswith("</details>")
    assert text.count("<tr>") == text.count("</tr>") == len(str(stored).splitlines()) - 1
    stored.attributes["reason"] = "<script>"
    stored.__dict__.pop("summary")
    assert "<script>" not in stored._repr_html_()
    assert "&lt;script&gt;" in stored._repr_html_().partition("<details>")[0]


def test_a_certificate_joins_the_summary(place: Path) -> None:
    run = tt.run("inverting", until=0.05)
    assert "certificate" not in run.summary
    found = run.certify(0.02)
    assert run.summary.certificate.to_dict() == found.to_dict()
    assert f"{found}".startswith("<Certificate against longdouble over 0.02 s: theta differs by at")
    assert f"{found}".endswith("same_end, columns, theta, turnings, thresholds>")
    assert "against longdouble over 0.02 s" in str(run)


def test_a_record_is_read_only_and_says_what_it_knows() -> None:
    values = {"a": 1, "b": {"c": [1, 2]}}
    record = Record(values)
    assert record.b.c == record["b"]["c"] == [1, 2]
    assert record.to_dict() == values
    assert dict(record) == {"a": 1, "b": record.b}
    assert {"a", "b"} <= set(dir(record))
    with pytest.raises(AttributeError, match="there is no `d`: known are a, b"):
        _ = record.d
    with pytest.raises(AttributeError, match="`c` cannot be set"):
        record.b.c = 2
    assert repr(record) == "Record(a=1, b=b(c=[1, 2]))"
