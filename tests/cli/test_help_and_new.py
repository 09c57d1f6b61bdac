"""tippetop help, new, completion."""

from pathlib import Path

import pytest

from tippetop.cli import outcome
from tippetop.cli.reference import EXIT_CODES, topics


@pytest.mark.parametrize("topic", topics())
def test_help_prints_a_topic(topic: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["help", topic]) == 0
    plain = capsys.readouterr().out
    assert outcome(["help", topic, "--markdown"]) == 0
    markdown = capsys.readouterr().out
    assert plain
    assert "| --- |" in markdown
    assert all(line.startswith("|") == line.endswith("|") for line in markdown.splitlines() if line)


def test_exit_codes_are_those_of_the_command_line() -> None:
    import tippetop.cli as cli

    codes = (
        cli.DONE,
        cli.BUG,
        cli.USAGE,
        cli.PHYSICS,
        cli.ACCURACY,
        cli.STORE,
        cli.CHUNKS,
        cli.INTERRUPTED,
    )
    assert list(EXIT_CODES) == [*codes, cli.TERMINATED]


def test_an_unknown_topic_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["help", "scenaro"]) == 2
    assert "Did you mean `scenario`?" in capsys.readouterr().err


def test_new_writes_a_scenario_that_checks_and_replaces_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "MY.toml"
    assert outcome(["new", "heavy-top", "--out", str(out)]) == 0
    assert outcome(["check", str(out), "--json"]) == 0
    assert outcome(["new", "heavy-top", "--out", str(out)]) == 5
    assert outcome(["new", "heavy-top", "--out", str(out), "--overwrite"]) == 0
    assert outcome(["new", "--out", str(tmp_path / "MY.txt")]) == 2


def test_completion_names_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["completion", "bash"]) == 0
    assert "playground" in capsys.readouterr().out


def test_what_is_not_installed_is_a_sentence_with_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:

    def absent(*_: object) -> None:
        raise ModuleNotFoundError("No module named 'h5netcdf.core'", name="h5netcdf.core")

    monkeypatch.setattr("tippetop.scenario.template.template", absent)
    assert outcome(["new"]) == 2
    assert "pip install 'tippetop[export]'" in capsys.readouterr().err
