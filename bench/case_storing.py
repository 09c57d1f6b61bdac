"""What storing costs: a run at 1 kHz with events, drift, store and checkpoints against the equations alone.

Wall clock: the store is written by a second thread.
"""

import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from tippetop.cli.memory import keep_memory
from tippetop.problem import Problem
from tippetop.runs import recording
from tippetop.runs.integration import Integration
from tippetop.runs.sinks import Nowhere
from tippetop.scenario import build

from .measure import elapsed, interleaved, ratio
from .ours import alone, end_of


RUNS = {
    "rolling tippe top": ("rolling", 1000.0),
    "canonical inversion, mu = 0": ("inverting", 1000.0),
    "heavy top": ("heavy-top", 4000.0),
}


def bare(problem: Problem) -> float:
    """Seconds of one propagate_until of the same equations, without events."""
    plain = alone(problem)
    return elapsed(lambda: plain.propagate_until(end_of(problem)))


def followed(problem: Problem) -> float:
    """Seconds of the run without rows."""
    integration = Integration(problem)
    return elapsed(lambda: integration.run(Nowhere()))


def stored(problem: Problem) -> float:
    """Seconds of the run into a store."""
    with tempfile.TemporaryDirectory() as folder:
        return elapsed(lambda: recording.record(problem, Path(folder) / "run.zarr"))


def keyframes(problem: Problem) -> float:
    """Seconds of the run into a store that keeps keyframes and events, and no rows."""
    return stored(replace(problem, output="keyframes"))


def compare(quick: bool) -> dict[str, Any]:
    """Seconds of each run, bare, followed, and stored with keyframes or rows."""
    keep_memory()  # as `tippetop run` does
    found: dict[str, Any] = {"title": "Storing a run at 1 kHz", "runs": {}}
    for name, (preset, until) in RUNS.items():
        sets = ["run.output_step=0.001"] + (["friction.mu=0.0"] if preset == "inverting" else [])
        problem = build.load(preset, sets, until / 10 if quick else until)
        works = {f.__name__: lambda f=f, p=problem: f(p) for f in (bare, followed, keyframes, stored)}
        seconds = interleaved(works, 3)
        found["runs"][name] = {
            "rows": len(problem.times),
            "seconds": {name: statistics.median(times) for name, times in seconds.items()},
            **{f"{way} / bare": ratio(seconds[way], seconds["bare"]) for way in ("followed", "keyframes", "stored")},
        }
    return found
