"""Test that every command that writes a store may be killed at any moment."""

import contextlib
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from forked import Forked
from plans import PLAN
from stores import (
    PRELUDE,
    TURNING,
    assert_same,
    ended,
    interrupted,
    short_slices,
    state_of,
    turning,
)
from typed import typed

from tippetop.store.ledger import LEDGER


SETS = " ".join(f"--set {text}" for text in (*TURNING, "run.output_step=0.01"))
SURFACE = "surface inverting --D=-1e-4:1e-4:3000 --lambda 0:1e-5:3000"
RUN = f"run inverting --out S.zarr {SETS} --until"


def nothing() -> None:
    """Prepare nothing."""


def half() -> None:
    interrupted(Path("S.zarr"), turning(70.0), slices=3)


def finished() -> None:
    assert typed(f"{RUN} 20") == 0


def with_keyframes() -> None:
    words = RUN.replace("S.zarr", "K.zarr").replace("output_step=0.01", "output=keyframes")
    assert typed(f"{words} 70 --set run.keyframe_steps=100") == 0


def with_plan() -> None:
    Path("PLAN.toml").write_text(PLAN)


class Command(NamedTuple):
    """What is killed, what continues it (after it has written a ledger), and what was before."""

    words: str
    again: str
    before: Callable[[], None] = nothing


REPLAY = "replay K.zarr --from 20 --until 60 --step 0.002 --out S.zarr"
COMMANDS = {
    "run": Command(f"{RUN} 70", "resume S.zarr"),
    "resume": Command("resume S.zarr", "resume S.zarr", half),
    "extend": Command("resume S.zarr --until 70", "resume S.zarr --until 70", finished),
    "replay": Command(REPLAY, f"{REPLAY} --overwrite", with_keyframes),
    "sweep": Command(*["sweep PLAN.toml --out S.zarr --workers 1"] * 2, with_plan),
    "surface": Command(*[f"{SURFACE} --out S.zarr"] * 2),
    "potential": Command(*["potential inverting --D 0 --lambda 1e-6 --n 1000000 --out S.zarr"] * 2),
    "overwrite": Command(*[f"{RUN} 70 --overwrite"] * 2, half),
}


def killed(command: Command, kills: int, folder: Path, rng: np.random.Generator) -> None:
    """Kill a command at random moments of its time, and continue it undisturbed."""
    before, whole, place = folder / "before", folder / "whole", folder / "here"

    def start() -> Forked:
        return Forked(command.words.split(), PRELUDE)

    def extent() -> int:
        """Rows and chunks that the ledger acknowledges, until the store is finished."""
        with contextlib.suppress(FileNotFoundError):
            state = state_of(place / "S.zarr")
            return 0 if state.seal else sum(state.rows.values()) + len(state.chunks)
        return 0

    with contextlib.chdir(folder):
        before.mkdir()
    with contextlib.chdir(before):
        command.before()
    for done in (folder / "first", whole):  # the first one compiles
        shutil.copytree(before, done)
        with contextlib.chdir(done):
            began = time.monotonic()
            code, err = ended(start())
            takes = time.monotonic() - began
        assert code == 0, err
    for _ in range(kills):
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(before, place)
        with contextlib.chdir(place):
            process = start()
            until = time.monotonic() + rng.uniform(0.0, 1.05 * takes)
            while process.poll() is None and time.monotonic() < until:
                time.sleep(0.001)
            known = 0 if "--overwrite" in command.words else extent()
            process.kill()
            err = ended(process)[1]
            assert "Traceback" not in err
            assert extent() >= known or state_of(place / "S.zarr").seal
            begun = (place / "S.zarr" / LEDGER).exists()
            code = typed(command.again if begun else command.words)
            assert code in (0, 2, 5)  # it may have come to its end
        assert_same(place, whole)


@pytest.fixture
def small() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        short_slices(patch, commit_every=0.02)
        yield


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*a killed run")
@pytest.mark.parametrize("name", COMMANDS)
def test_killed_and_continued_every_command_makes_the_same_files(
    name: str, small: None, tmp_path: Path, rng: np.random.Generator
) -> None:
    killed(COMMANDS[name], 6, tmp_path, rng)
