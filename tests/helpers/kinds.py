"""Small stores of every kind, finished and interrupted, in many slices and chunks."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from stores import tiny_chunks
from typed import typed

import tippetop as tt
from tippetop.landscape import surface_recording as surfaces
from tippetop.runs import recording, starting


PLAN = """
scenario = "inverting"
set.run.until = 0.05
chunk = 1
keep = ["class", "theta_max"]
runs = [1]
[[axis]]
of = "initial.omega3"
linspace = [100.0, 160.0]
n = 5
"""
KINDS = ("run", "sweep", "surface", "potential")
CONTINUED = KINDS[:2]


def make(kind: str, store: Path, progress: Any = None) -> None:
    """Make a store, or continue it."""
    if kind == "run" and store.exists():
        tt.resume(store)
    elif kind == "run":
        problem = starting.load("inverting", ["run.output_step=0.002"], 0.6)
        recording.record(problem, store, progress=progress)
    elif kind == "sweep":
        plan = store.with_name("PLAN.toml")
        plan.write_text(PLAN)
        tt.sweep(plan, store, workers=1, progress=progress or False)
    elif kind == "surface":
        body = starting.load("inverting").parameters
        axes = np.linspace(-1e-4, 1e-4, 12), np.linspace(0.0, 1e-5, 8)
        surfaces.write(store, body, *axes, chunk=4)
    else:
        typed(f"potential inverting --D=3e-4 --lambda=4e-6 --n=50 --out {store}")


@contextlib.contextmanager
def every_kind(folder: Path) -> Iterator[Path]:
    """Make finished stores in a folder, and interrupted ones named `half-`; in the block they are
    continued as they were begun.
    """
    with pytest.MonkeyPatch.context() as patch:
        tiny_chunks(patch)
        for kind in KINDS:
            make(kind, folder / f"{kind}.zarr")
        for kind in CONTINUED:
            stop = Mock(side_effect=[None, None, None, None, KeyboardInterrupt])
            with pytest.raises(KeyboardInterrupt):
                make(kind, folder / f"half-{kind}.zarr", stop)
        yield folder
