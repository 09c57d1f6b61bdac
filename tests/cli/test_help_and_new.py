"""tippetop help, new, completion."""

import subprocess
import sys
from pathlib import Path

import pytest
from typed import typed

from tippetop import cli
from tippetop.cli.help_command import EXIT_CODES, topics


@pytest.mark.parametrize("topic", topics())
def test_help_prints_a_topic(topic: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert typed(f"help {topic}") == 0
    plain = capsys.readouterr().out
    assert typed(f"help {topic} --markdown") == 0
    markdown = capsys.readouterr().out
    assert plain
    assert "| --- |" in markdown
    assert all(line.startswith("|") == line.endswith("|") for line in markdown.splitlines() if line)


def test_exit_codes_are_those_that_are_documented() -> None:
    assert list(EXIT_CODES) == [*range(7), cli.INTERRUPTED, cli.TERMINATED]


def test_new_writes_a_scenario_that_checks_and_replaces_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "MY.toml"
    assert typed(f"new heavy-top --out {out}") == 0
    assert typed(f"check {out} --json") == 0
    assert typed(f"new heavy-top --out {out}") == 5
    assert typed(f"new heavy-top --out {out} --overwrite") == 0
    assert typed(f"new --out {tmp_path}/MY.txt") == 2


@pytest.mark.parametrize(
    ("words", "completed"),
    [("run invert", "inverting"), ("plot R.zarr sphe", "sphere"), ("plot R.zarr lyap", "lyapunov")],
)
def test_bash_completes_presets_and_kinds_of_figures(words: str, completed: str) -> None:
    """Bash sources the script, as a user does."""
    tippetop = f"{sys.executable} -m tippetop"
    script = (
        f"source <({tippetop} completion bash); COMP_WORDS=(tippetop {words}); "
        "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _tippetop; echo ${COMPREPLY[@]}"
    )
    found = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert found.stdout.split() == [completed]
