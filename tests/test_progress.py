"""The progress bar counts on a terminal only."""

import inspect
import io
import sys
from unittest import mock

import pytest

import tippetop
from tippetop import progress


class Terminal(io.StringIO):
    """A terminal that remembers."""

    def isatty(self) -> bool:
        return True


def test_a_bar_shows_how_much_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(progress, "FIRST_AFTER", 0.0)
    with progress.Bar("tops") as bar:
        bar.update(60, 100)
    assert "60/100 tops" in terminal.getvalue()


def test_no_bar_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.reporting(True, "tops") as tell:
        tell(1, 2)
    assert capsys.readouterr() == ("", "")


def test_any_callback_is_passed_on() -> None:
    seen: list[tuple[int, int]] = []
    with progress.reporting(lambda *at: seen.append(at), "tops") as tell:
        tell(1, 2)
    with progress.reporting(False, "tops") as tell:
        tell(2, 2)
    assert seen == [(1, 2)]


def test_a_notebook_shows_one_line_which_vanishes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ipython = mock.Mock()
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setattr(progress, "FIRST_AFTER", 0.0)
    monkeypatch.setattr(progress, "AGAIN_AFTER", 0.0)
    with progress.reporting(True, "tops") as tell:
        tell(10, 40)
        tell(20, 40)
    shown = ipython.display.display.mock_calls
    lines = [call.args[0]["text/plain"] for call in shown]
    assert lines == ["10/40 tops (25%)", "20/40 tops (50%)", ""]
    assert capsys.readouterr() == ("", "")


def test_calls_show_their_progress_by_default() -> None:
    """A long run shows a sign of life, unless it is told not to."""
    functions = (tippetop.run, tippetop.resume, tippetop.ensemble, tippetop.sweep, tippetop.fit)
    for function in functions:
        assert inspect.signature(function).parameters["progress"].default is True
