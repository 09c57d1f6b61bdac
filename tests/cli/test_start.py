"""What a start imports: only what the words on the command line need."""

import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typed import typed

from tippetop.cli.application import COMMANDS


SHOW = """
import sys
from tippetop.cli import outcome
code = outcome(sys.argv[1:])
print()
print(*sys.modules)
sys.exit(code)
"""


@functools.cache
def imported(words: str) -> set[str]:
    """The modules and packages that a process has imported when it has done what the words say."""
    done = subprocess.run(
        [sys.executable, "-c", SHOW, *words.split()], capture_output=True, text=True, check=True
    )
    modules = done.stdout.splitlines()[-1].split()
    return {*modules, *(module.partition(".")[0] for module in modules)}


@pytest.mark.parametrize("words", ["", "--help", "--version"])
def test_the_overview_needs_no_heavy_library(words: str) -> None:
    heavy = "heyoka matplotlib numba numpy pandas pydantic xarray zarr"
    assert not imported(words) & {*heavy.split()}


def test_a_stored_run_imports_what_it_needs(tmp_path: Path) -> None:
    """Once its kernels are compiled: no numba, and nothing that draws, labels, sweeps or shows."""
    words = f"run inverting --until 0.1 --out {tmp_path}"
    if "numba" in (modules := imported(f"{words}/a.zarr")):
        modules = imported(f"{words}/b.zarr")
    heavy = "dask h5py matplotlib numba pandas pint rich scipy xarray"
    assert not modules & {*heavy.split()}
    rooms = "ensembles exchange figures library sweeps views"
    assert not modules & {f"tippetop.{room}" for room in rooms.split()}
    assert "tippetop.engine.hybrid" not in modules
    assert "zarr" not in imported("run inverting --until 0.1")


def test_the_overview_has_a_line_for_each_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert typed("--help") == 0
    text = capsys.readouterr().out
    assert all(re.search(rf"│ {name} +[A-Z]", text) for name in COMMANDS)
    assert typed("") == 0
    assert capsys.readouterr().out == text
