"""The progress bar: what it counts, how fast, and how long it still takes; nothing where nobody
looks.
"""

import io
import time

import pytest

from tippetop import progress


class Terminal(io.StringIO):
    """A terminal that remembers."""

    def isatty(self) -> bool:
        return True


def test_a_bar_tells_rate_and_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was done before does not count: 60 of 100 in 20 s leave 40 for another 20 s at 2 a
    second.
    """
    terminal, clock = Terminal(), iter([100.0, 120.0])
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    with progress.reporting(True, "tops") as tell:
        monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock, 120.0))
        tell(20, 100)
        tell(60, 100)
    assert "60/100" in terminal.getvalue()
    assert "2 tops/s, 0:00:20 left" in terminal.getvalue()


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


def test_a_bar_says_so_while_the_first_thing_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first chunk of a sweep may have to be compiled: nothing is done, and that is shown."""
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(progress, "SILENT", 0.01)
    with progress.reporting(True, "tops") as tell:
        tell(0, 72)
        for _ in range(500):
            if "starting (compiling)" in terminal.getvalue():
                break
            time.sleep(0.01)
    assert "0/72 tops" in terminal.getvalue()
    assert "starting (compiling)" in terminal.getvalue()
