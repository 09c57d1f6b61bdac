"""The progress bar counts on a terminal only."""

import io

import pytest

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
