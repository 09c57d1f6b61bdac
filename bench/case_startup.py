"""Time `tippetop run inverting --out RUN.zarr` from the shell, cold and warm, and its parts.

Cold: empty home and caches, so nothing is compiled on disk. Warm: the second run with them.
Alone: a run that stores nothing.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from functools import partial
from pathlib import Path
from typing import Any


STAGES = """
import json, pathlib, sys, time
clock, stages = time.process_time(), {}
def done(name):
    global clock
    stages[name], clock = time.process_time() - clock, time.process_time()
import heyoka
done("import heyoka and numpy")
import xarray, zarr
done("import xarray and zarr")
import tippetop.cli
from tippetop.engine.taylor import driver_of
from tippetop.runs import recording
from tippetop.runs import starting
done("import tippetop and the rest")
problem = starting.load("inverting")
done("check the scenario, compile the columns")
driver_of(problem)
done("compile the integrator")
recording.record(problem, pathlib.Path(sys.argv[1]))
done("integrate and store")
print(json.dumps(stages))
"""


def compare(quick: bool) -> dict[str, Any]:
    """Return the seconds of the stages and of the command, cold and warm."""
    rounds = 2 if quick else 4
    rows: dict[str, dict[str, float]] = defaultdict(dict)
    with tempfile.TemporaryDirectory() as folder:
        homes = [Path(folder) / str(i) for i in range(2 * rounds)]
        for home in homes:
            home.mkdir()
        for column in ("cold [s]", "warm [s]"):
            commands = [command(home) for home in homes[:rounds]]
            stages = [staged(home) for home in homes[rounds:]]
            for stage in stages[0]:
                rows[stage][column] = statistics.median(each[stage] for each in stages)
            wall, processor = map(statistics.median, zip(*commands, strict=True))
            rows["**the command, wall clock**"][column] = wall
            rows["the command, processor"][column] = processor
        for name, work in (
            (
                "`tippetop run inverting`, wall clock",
                partial(command, homes[0], "run", "inverting"),
            ),
            ("`tippetop --help`, wall clock", partial(command, homes[0], "--help")),
            ("`python -c pass`, wall clock", partial(run, homes[0], ["-c", "pass"])),
        ):
            rows[name]["warm [s]"] = statistics.median(work()[0] for _ in range(3))
    return {"title": "Start-up of `tippetop run inverting`", "rows": rows}


def environment(home: Path) -> dict[str, str]:
    """An environment whose caches are the home's."""
    places = {
        "HOME": ".",
        "XDG_CACHE_HOME": "cache",
        "HEYOKA_CACHE_DIR": "heyoka",
        "TIPPETOP_CACHE_DIR": "kernels",
    }
    return {**os.environ, **{name: str(home / place) for name, place in places.items()}}


def run(home: Path, arguments: list[str]) -> tuple[float, float, str]:
    """Seconds by the wall and of the processor of a Python process, and what it printed."""
    before, clock = os.times(), time.perf_counter()
    made = subprocess.run(
        [sys.executable, *arguments], env=environment(home), capture_output=True, text=True
    )
    wall, after = time.perf_counter() - clock, os.times()
    if made.returncode:
        raise RuntimeError(made.stderr)
    processor = (
        after.children_user + after.children_system - before.children_user - before.children_system
    )
    return wall, processor, made.stdout


def command(home: Path, *arguments: str) -> tuple[float, float]:
    """Seconds by the wall and of the processor of the command."""
    with tempfile.TemporaryDirectory() as folder:
        what = arguments or ("run", "inverting", "--out", f"{folder}/run.zarr")
        return run(home, ["-c", "from tippetop.cli import main; main()", *what])[:2]


def staged(home: Path) -> dict[str, float]:
    """Processor seconds of the stages of the same work."""
    with tempfile.TemporaryDirectory() as folder:
        return json.loads(run(home, ["-c", STAGES, f"{folder}/run.zarr"])[2])
