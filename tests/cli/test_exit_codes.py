"""Every exit code of the contract, each by a command that earns it, with words on the stream that
is meant.
"""

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typed import typed

import tippetop
from tippetop import cli
from tippetop.cli import main
from tippetop.cli.help_command import EXIT_CODES
from tippetop.engine.driver import Driver
from tippetop.runs import certificate, integration
from tippetop.sweeps import chunk


Patch = pytest.MonkeyPatch
RUN = "run inverting --until 0.2 --json"
STIFF = "--set friction.mu=1e12 --set initial.theta=0.0 --set initial.nu_y=0.1"


def nothing(patch: Patch) -> None:
    """Nothing goes wrong."""


def a_bug(patch: Patch) -> None:
    patch.setattr("tippetop.runs.attributes.report", lambda progress: 1 / 0)


def no_promise_can_be_kept(patch: Patch) -> None:
    patch.setitem(certificate.MAX_DRIFT, "jellett", -1.0)


def a_chunk_fails(patch: Patch) -> None:
    def fail(task: Any, threads: int = 1) -> dict:
        raise ArithmeticError("it will not do")

    patch.setattr(chunk, "compute_chunk", fail)


def asked(number: int) -> Callable[[Patch], None]:
    """A signal arrives before the first slice."""

    def patch_driver(patch: Patch) -> None:
        patch.setattr(integration, "STEPS_PER_SLICE", 8)
        inner, asked = Driver.advance, []

        def advance(driver: Driver, *arguments: Any) -> Any:
            if not asked:
                asked.append(signal.raise_signal(number))
            return inner(driver, *arguments)

        patch.setattr(Driver, "advance", advance)

    return patch_driver


@pytest.fixture
def code_of(tmp_path: Path, monkeypatch: Patch, file: Path) -> Iterator[Callable]:
    """What a process would exit with; afterwards handlers and warnings are as they were."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setattr(cli.warnings, "showwarning", cli.warnings.showwarning)
    places = {
        "STORE": str(tmp_path / "run.zarr"),
        "SWEEP": str(tmp_path / "S.zarr"),
        "PLAN": str(file),
    }

    def code(arguments: str, spoil: Callable[[Patch], None]) -> Any:
        spoil(monkeypatch)
        with pytest.raises(SystemExit) as ended:
            main([places.get(word, word) for word in arguments.split()])
        return ended.value.code

    yield code
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("code", "arguments", "spoil", "words"),
    [
        (0, "presets --json", nothing, ""),
        (0, RUN, nothing, ""),
        (2, "fly", nothing, 'Unknown command "fly"'),
        (2, f"{RUN} --set friction.mu=-1", nothing, "`friction.mu` must be at least 0.0"),
        (3, f"{RUN} {STIFF}", nothing, "too stiff"),
        (4, RUN, no_promise_can_be_kept, "the accuracy contract is broken: the drift of jellett"),
        (5, "info STORE", nothing, "does not exist"),
        (6, "sweep PLAN --out SWEEP --workers 1", a_chunk_fails, "it will not do"),
        (130, RUN, asked(signal.SIGINT), "interrupted; nothing more was stored."),
        (130, f"{RUN} --out STORE", asked(signal.SIGINT), "Continue with: tippetop resume"),
        (143, RUN, asked(signal.SIGTERM), ""),
        (143, f"{RUN} --out STORE", asked(signal.SIGTERM), "Continue with: tippetop resume"),
    ],
    ids=lambda value: str(value) if isinstance(value, int) else None,
)
def test_every_end_has_its_code(
    code: int,
    arguments: str,
    spoil: Callable[[Patch], None],
    words: str,
    code_of: Callable,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert code_of(arguments, spoil) == code, f"{code} means: {EXIT_CODES[code]}"
    out, err = capsys.readouterr()
    assert words in err
    assert "Traceback" not in err
    assert all(line.startswith("tippetop: ") for line in err.splitlines())
    if code in (0, 3, 4):  # what was computed is given, whatever else is said
        assert isinstance(json.loads(out), dict)
    elif code != 6:
        assert out == ""


def test_a_bug_is_not_hidden(monkeypatch: Patch) -> None:
    """It leaves `outcome` as it is: Python prints the traceback, and exits with 1."""
    a_bug(monkeypatch)
    with pytest.raises(ZeroDivisionError):
        typed(RUN)


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tippetop", "--version"], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout.strip()) == (0, tippetop.__version__)
