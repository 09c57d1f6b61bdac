"""What a start imports: only what the words on the command line need."""

import functools
import subprocess
import sys
from pathlib import Path

import pytest

from tippetop.cli import outcome
from tippetop.cli.application import command
from tippetop.cli.overview import COMMANDS, summary


SHOW = """
import sys
from tippetop.cli import outcome
code = outcome(sys.argv[1:])
print()
print(*sys.modules)
sys.exit(code)
"""


@functools.cache
def imported(*words: str) -> set[str]:
    """The modules and packages that a process has imported when it has done what the words say."""
    done = subprocess.run(
        [sys.executable, "-c", SHOW, *words], capture_output=True, text=True, check=True
    )
    modules = done.stdout.splitlines()[-1].split()
    return {*modules, *(module.partition(".")[0] for module in modules)}


@pytest.mark.parametrize("words", [[], ["--help"], ["--version"]], ids=str)
def test_the_overview_needs_the_standard_library_alone(words: list[str]) -> None:
    assert {m for m in imported(*words) if m.startswith("tippetop")} == {
        *(
            "tippetop",
            "tippetop.awaiting",
            "tippetop.cli",
            "tippetop.cli.overview",
            "tippetop.cli.streams",
        ),
        "tippetop.errors",
    }
    assert not imported(*words) & {
        "attr",
        "cyclopts",
        "heyoka",
        "json",
        "logging",
        "numpy",
        "pydantic",
        "rich",
        "zarr",
    }


def test_a_stored_run_imports_what_it_needs(tmp_path: Path) -> None:
    """Once its kernels are compiled: no numba, and nothing that draws, labels, sweeps or shows."""
    words = ("run", "inverting", "--until", "0.1", "--overwrite", "--out", str(tmp_path / "a.zarr"))
    if "numba" in (modules := imported(*words)):
        modules = imported(*words)
    assert not modules & {
        "dask",
        "h5py",
        "matplotlib",
        "numba",
        "pandas",
        "pint",
        "rich",
        "scipy",
        "xarray",
    }
    assert not modules & {
        f"tippetop.{room}"
        for room in ("ensembles", "exchange", "figures", "library", "sweeps", "views")
    }
    assert "tippetop.engine.hybrid" not in modules
    assert "zarr" not in imported("run", "inverting", "--until", "0.1")


def test_a_command_imports_its_own_module_only() -> None:
    assert {m for m in imported("presets") if m.startswith("tippetop.cli.")} == {
        f"tippetop.cli.{name}"
        for name in (
            "application",
            "host",
            "overview",
            "show",
            "streams",
            "text",
            "usage",
            "values",
        )
    }


@pytest.mark.parametrize("name", COMMANDS)
def test_the_overview_has_the_summary_of_each_command(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert summary(name) == command(name).__doc__.split("\n\n")[0]
    assert outcome([name, "--help"]) == 0
    assert summary(name) in " ".join(capsys.readouterr().out.split())


def test_every_command_has_a_line_of_the_overview(capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["--help"]) == 0
    text = capsys.readouterr().out
    lines = text.splitlines()
    assert all(any(line.startswith(f"  {name} ") for line in lines) for name in COMMANDS)
    assert max(map(len, lines)) <= 120
    assert outcome([]) == 0
    assert capsys.readouterr().out == text
