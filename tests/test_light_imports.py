"""Heavy libraries are imported when something needs them, and not before; an import and a run change nothing else."""

import json
import subprocess
import sys

import pytest

from tippetop.runs.run import solve
from tippetop.scenario import build
from tippetop_kernels import disk


STAGES = [
    ("import tippetop as tt", {"heyoka", "numpy", "xarray", "matplotlib", "numba", "zarr", "pydantic"}),
    ("import tippetop.mechanics.systems", {"numba", "matplotlib", "zarr", "pydantic"}),
    ("import tippetop.landscape.surface, tippetop.figures, tippetop.cli", {"numba", "matplotlib"}),
    ("import tippetop.sweeps.sweep", {"numba", "matplotlib", "dask", "distributed"}),
    (
        "tt.run('inverting', until=0.1)",
        {"matplotlib", "dask", "tippetop.engine.derivatives.along_run"} | ({"numba"} if disk.folder() else set()),
    ),
]
"""What a process does, one after the other, and what it has not imported after that."""
CODE = """
import json, logging, os, signal, sys
def state():
    signals = [str(signal.getsignal(number)) for number in (signal.SIGINT, signal.SIGTERM)]
    return [dict(os.environ), signals, logging.root.level]
for stage in json.loads(sys.argv[1]):
    before = state()
    exec(stage)
    print(json.dumps([list(sys.modules), before == state()]))
"""


@pytest.fixture(scope="module")
def after() -> list[tuple[set[str], bool]]:
    """The modules that are loaded after each stage, and whether environment, signal handlers and log level are the
    same; the loop of a run is on disk before (where one is kept)."""
    solve(build.load("inverting", until=0.1))
    command = [sys.executable, "-c", CODE, json.dumps([code for code, _ in STAGES])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [(set(modules), same) for modules, same in map(json.loads, done.stdout.splitlines())]


@pytest.mark.parametrize("stage", range(len(STAGES)), ids=[code for code, _ in STAGES])
def test_what_is_heavy_sleeps_until_it_is_needed(stage: int, after: list[tuple[set[str], bool]]) -> None:
    """A process that finds the loop of a run on disk needs no compiler."""
    loaded, same = after[stage]
    assert not STAGES[stage][1] & loaded
    assert same
