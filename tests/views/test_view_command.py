"""`tippetop view`: one file without links, or one sentence and an exit code."""

import re
from pathlib import Path

import pytest
from stores import interrupted, turning
from typed import refused, typed

import tippetop as tt
from tippetop.views import pages


def test_a_store_becomes_one_file(
    short_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    assert typed(f"view {short_run}") == 0
    assert capsys.readouterr().out.startswith("RUN.html: 0.1 MB")
    text = Path("RUN.html").read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["RUN.html"]
    assert not re.search(
        r"https?://|<link|<img|\bsrc=|\bfetch\(|^import |^export |\{\{", text, re.MULTILINE
    )
    assert text.count("<script") == 2
    data = re.search(r'id="data">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    assert len(text) - len(data[1]) < 100_000, "the page without its data is tens of kilobytes"


def test_a_run_in_memory_and_its_store_have_the_same_page(short_run: Path) -> None:
    stored = tt.open(short_run)
    assert isinstance(stored, tt.StoredRun)
    assert stored.view().text == tt.run("inverting", until=0.2).view().text
    assert "srcdoc" in stored.view()._repr_html_()


def test_an_unfinished_run_is_refused(tmp_path: Path) -> None:
    part = interrupted(tmp_path / "part.zarr", turning(100.0))
    assert "must be finished to be viewed" in refused(f"view {part} --out {tmp_path}/x.html", 5)
    assert not (tmp_path / "x.html").exists()


def test_data_cannot_end_the_script_that_holds_it() -> None:
    text = pages.page(
        "</title><b>",
        "page_run.js",
        {"title": "</script><b>"},
        {"formulas.js": "export const potential = null;\n"},
    )
    assert "</script><b>" not in text
    assert "</title><b>" not in text
