"""The compiled loop is found, is that of the source, and reads the structures that Python makes."""

import ctypes
import shutil
from pathlib import Path

import numpy as np
import pytest
from typed import typed

import tippetop_kernels
from tippetop.engine import taylor
from tippetop.engine.integrator import compiled_from
from tippetop.engine.loop import Loop, Motion, _Loop, library, new_motion, structure
from tippetop.engine.status import Status
from tippetop.engine.stepper import Called
from tippetop.engine.tallies import Rules, event_rows, new_log, new_tallies


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the loop and its source, which this process takes for the installed one."""
    for name in ("loop.c", "loop.so"):
        shutil.copy(Path(tippetop_kernels.__file__).with_name(name), tmp_path)
    monkeypatch.setattr(tippetop_kernels, "__file__", str(tmp_path / "__init__.py"))
    return tmp_path


def test_only_a_loop_that_was_compiled_from_its_source_is_loaded(folder: Path) -> None:
    assert library.__wrapped__().loop_digest()
    (folder / "loop.c").write_text("/* edited */")
    with pytest.raises(ImportError, match=r"must be compiled from `loop.c` as it is"):
        library.__wrapped__()
    (folder / "loop.c").unlink()
    with pytest.raises(ImportError, match=r"No such file.*loop\.c.*: install tippetop again"):
        library.__wrapped__()


def test_a_loop_that_is_no_library_is_one_message_of_the_command_line(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "loop.so").write_text("text")
    monkeypatch.setattr("tippetop.engine.loop.library", library.__wrapped__)
    monkeypatch.setattr(taylor, "compiled_from", compiled_from.__wrapped__)
    assert typed("run heavy-top --until 0.0123") == 2
    assert capsys.readouterr().err.count("install tippetop again") == 1


def test_structures_have_the_size_that_they_have_in_c() -> None:
    assert library().loop_structure_size() == ctypes.sizeof(structure(_Loop))


class Broken(Called):
    """Steps that are interrupted."""

    def __init__(self) -> None:
        pass

    def step(self, motion: Motion) -> None:
        raise KeyboardInterrupt


def test_an_error_in_a_called_step_reaches_the_caller() -> None:
    """It cannot pass through C, which must end the run."""
    nothing, motion = event_rows([], [], []), new_motion(1, 0, 1, 1)
    motion.end[0] = 1.0
    tallies, rules = new_tallies(nothing, np.ones((0, 1))), Rules(np.inf, 1 << 62, 8, 0)
    loop = Loop(motion, nothing, tallies, new_log(0, 1), new_log(0, 0), rules, Broken())
    with pytest.raises(KeyboardInterrupt):
        loop.drive(100)
    assert tallies.lane["status"] == Status.NON_FINITE.code
