"""Heavy libraries are imported when something needs them, and not before; an import and a run
change nothing else.
"""

import json
import subprocess
import sys

import pytest


STAGES = [
    (
        "import tippetop as tt",
        {"heyoka", "numpy", "xarray", "matplotlib", "numba", "zarr", "pydantic"},
    ),
    ("import tippetop.mechanics.systems", {"numba", "matplotlib", "zarr", "pydantic"}),
    ("import tippetop.landscape.surface, tippetop.figures, tippetop.cli", {"numba", "matplotlib"}),
    ("import tippetop.sweeps.sweep", {"numba", "matplotlib", "dask", "distributed"}),
    (
        "tt.run('inverting', until=0.1)",
        {"matplotlib", "dask", "numba", "tippetop.engine.derivatives.sensitivities"},
    ),
    ("tt.ensemble('inverting', {'omega3': [150.0, 155.0]}, until=0.1)", {"numba"}),
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
    """The modules that are loaded after each stage, and whether environment, signal handlers and
    log level are the same.
    """
    command = [sys.executable, "-c", CODE, json.dumps([code for code, _ in STAGES])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [(set(modules), same) for modules, same in map(json.loads, done.stdout.splitlines())]


@pytest.mark.parametrize("stage", range(len(STAGES)), ids=[code for code, _ in STAGES])
def test_what_is_heavy_sleeps_until_it_is_needed(
    stage: int, after: list[tuple[set[str], bool]]
) -> None:
    loaded, same = after[stage]
    assert not STAGES[stage][1] & loaded
    assert same


NUMBA = """
import sys, numba
loaded = lambda: {name.partition(".")[0] for name in sys.modules} & {"tippetop", "heyoka"}
assert numba.njit(lambda x: x + 1)(1) == 2
assert not loaded(), loaded()
from tippetop.mechanics.operand import sqrt
assert numba.njit(lambda x: sqrt(x))(4.0) == 2.0
"""


def test_a_program_of_numba_does_not_import_us_and_learns_formulas_when_it_does() -> None:
    done = subprocess.run([sys.executable, "-c", NUMBA], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
