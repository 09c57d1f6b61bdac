"""Limits of the command line: whatever the streams, the text, the numbers: a sentence and the
documented exit code.
"""

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from forked import Forked
from nightly import at_night
from refusals import refusal
from stores import ended, wait_until
from typed import typed

import tippetop as tt
from tippetop.runs import starting
from tippetop.scenario import reading


RUN = "run inverting --until 0.05"


def shell(words: str, redirected: str = "", **environment: str) -> subprocess.CompletedProcess[str]:
    command = f"set -o pipefail; {sys.executable} -m tippetop {words} {redirected}"
    return subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, env=os.environ | environment
    )


@pytest.mark.parametrize(
    ("words", "redirected", "code"),
    [
        ("presets", ">&-", 0),
        ("fly", "2>&-", 2),
        ("run nothing", "2>/dev/full", 2),
        at_night("systems", ">/dev/full", 5),
        ("--version", ">/dev/full", 5),
        ("--help", "| true", 0),
    ],
)
def test_streams_that_cannot_be_written_are_no_traceback(
    words: str, redirected: str, code: int
) -> None:
    done = shell(words, redirected)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    if code == 5:
        assert "standard output must be writable, but: No space left on device." in done.stderr


@pytest.mark.parametrize(
    ("error", "why"),
    [
        (RuntimeError("can't start new thread"), "can't start new thread"),
        (MemoryError(), "out of memory"),
        (OSError(errno.EMFILE, "Too many open files"), "Too many open files"),
    ],
)
def test_a_limit_of_the_process_is_named(
    error: Exception, why: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tippetop.cli.application.called", Mock(side_effect=error))
    assert typed("presets") == 5
    told = capsys.readouterr().err
    assert "a limit of this process (ulimit) must be higher, but:" in told
    assert told.endswith(f"{why}.\n")


def test_no_store_gets_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    done = shell(f"{RUN} --out {tmp_path}/a.zarr", "<&- >&- 2>&-")
    assert done.returncode == 0
    assert typed(f"info {tmp_path}/a.zarr") == 0


def test_a_terminal_without_our_characters_is_written_to_nevertheless() -> None:
    done = shell(RUN, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()
    assert "tippe top" in done.stdout


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 5000 + "]" * 5000,
        "a = " + "{a=" * 3000 + "1" + "}" * 3000,
        ".".join("a" * 3000) + " = 1",
        "[" + ".".join("a" * 3000) + "]",
    ],
)
def test_deep_nesting_is_refused(text: str, tmp_path: Path) -> None:
    file = tmp_path / "deep.toml"
    file.write_text(text)
    with refusal("nested too deeply"):
        reading.read(str(file))


def test_deep_arguments_are_refused() -> None:
    tables: dict[str, Any] = {}
    for _ in range(20_000):
        tables = {"a": tables}
    for call in (lambda: tt.run(tables), lambda: tt.run("inverting", parameters={"m": tables})):
        with refusal("nested too deeply"):
            call()


@pytest.mark.parametrize(
    ("key", "value", "code"),
    [
        ("parameters.m", "5e-324", 2),
        ("run.output_step", "5e-324", 2),
        ("run.until", "5e-324", 0),
        ("friction.mu", "1e308", 2),
        ("friction.mu", "1e100", 3),  # the first step is not finite
    ],
)
def test_numbers_at_the_ends_of_the_doubles(
    key: str, value: str, code: int, tmp_path: Path, said: Callable
) -> None:
    given = f"run inverting --set run.until=0.01 --set {key}={value}"
    for words in (given, f"{given} --out {tmp_path}/a.zarr"):
        assert (code == 0) == (not said(words, code)[1])


@pytest.mark.parametrize(
    ("precision", "tolerance"), [("double", 1e-22), ("longdouble", 1e-30), ("quad", 1e-300)]
)
def test_a_tolerance_far_below_the_rounding_unit_is_refused(
    precision: str, tolerance: float
) -> None:
    with refusal(r"must be 0 .the rounding unit. or at least"):
        starting.load("inverting", [f"run.precision={precision}", f"run.tolerance={tolerance}"])


MARKED = """
import os, sys
os.environ.update(HEYOKA_CACHE_DIR="cache", TIPPETOP_CACHE_DIR="", TIPPETOP_OPT_LEVEL="3")
from tippetop.awaiting import awaited as real
def marked(work, doing, stop=None):
    def between_marks():
        open("begun", "x").close()
        try:
            return work()
        finally:
            open("done", "x").close()
    return real(between_marks, doing, stop)
for module in list(sys.modules.values()):
    if vars(module).get("awaited") is real:
        module.awaited = marked
"""


@pytest.mark.parametrize(
    ("words", "number"),
    [
        (
            "run inverting --set run.precision=quad --set run.until=1e7 --out a.zarr",
            signal.SIGTERM,
        ),
        ("plot run.zarr band --out band.png", signal.SIGINT),
    ],
)
def test_a_signal_while_compiling_is_obeyed_at_once(
    words: str, number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At once: before the compilation, which takes seconds, is done."""
    monkeypatch.chdir(tmp_path)
    if words.startswith("plot"):
        assert typed("run inverting --until 0.5 --out run.zarr") == 0
    process = Forked(words.split(), MARKED)
    wait_until((tmp_path / "begun").exists, process)
    process.send_signal(number)
    _, errors = process.communicate()
    assert process.returncode == 128 + number, errors
    assert not (tmp_path / "done").exists()
    assert "Traceback" not in errors
    assert "terminated" in errors or "interrupted" in errors
    assert not list(tmp_path.glob("a.zarr"))
    assert not list(tmp_path.glob(".a.zarr*"))


def test_netcdf_on_a_full_disk_ends_with_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert typed("run inverting --until 1 --out a") == 0
    limit = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 16, 1 << 16));"
    # python would leave half of what it compiles: here, and where it exports
    limit += "sys.dont_write_bytecode = True"
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    code, err = ended(Forked(["export", "a", "--to", "netcdf", "--out", "a.nc"], limit))
    assert code == 5, err
    assert "`a.nc` must be writable, but" in err
    assert "Traceback" not in err
    assert {path.name for path in tmp_path.iterdir()} == {"a"}
