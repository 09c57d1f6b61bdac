"""The cost of storing a run at 1 kHz, with events and drift, against its equations alone.

Processor seconds of both threads: a second one writes the store.
"""

import statistics
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from tippetop.cli.host import prepare
from tippetop.problem import Problem
from tippetop.runs import recording, starting
from tippetop.runs.integration import Integration
from tippetop.runs.sinks import Sink

from .measure import interleaved, ratio, timed
from .ours import alone, end_of


RUNS = {
    "rolling tippe top": ("rolling", 1000.0),
    "canonical inversion, mu = 0": ("inverting", 1000.0),
    "heavy top": ("heavy-top", 4000.0),
}


THREE = ("theta", "phi_dot", "omega3")


def bare(problem: Problem) -> float:
    """Return seconds of one propagate_until of the same equations, without events."""
    plain = alone(problem)
    return timed(lambda: plain.propagate_until(end_of(problem)))


def followed(problem: Problem) -> float:
    """Return seconds of the run without rows."""
    integration = Integration(problem)
    return timed(lambda: integration.run(Sink()))


def stored(problem: Problem) -> float:
    """Return seconds of the run into a store."""
    with tempfile.TemporaryDirectory() as folder:
        return timed(lambda: recording.record(problem, Path(folder) / "run.zarr"))


def keyframes(problem: Problem) -> float:
    """Return seconds of the run into a store of keyframes and events, without rows."""
    return stored(replace(problem, output="keyframes"))


def three(problem: Problem) -> float:
    """Return seconds of the run into a store of three columns.

    What they do not need is not integrated.
    """
    return stored(replace(problem, columns=THREE, orientation=False))


WAYS = {
    "equations only": bare,
    "followed": followed,
    "with keyframes": keyframes,
    "three columns": three,
    "all columns": stored,
}


def compare(quick: bool) -> dict[str, Any]:
    """Return seconds of each run: alone, followed, stored with keyframes, three columns or all."""
    prepare()  # as `tippetop run` does
    rows: dict[str, dict[str, float]] = {}
    for name, (preset, until) in RUNS.items():
        sets = ["run.output_step=0.001"] + (["friction.mu=0.0"] if preset == "inverting" else [])
        problem = starting.load(preset, sets, until / 10 if quick else until)
        seconds = interleaved({way: partial(work, problem) for way, work in WAYS.items()}, 4)
        rows[name] = {"rows": len(problem.times)}
        rows[name] |= {f"{way} [s]": statistics.median(times) for way, times in seconds.items()}
        rows[name] |= {
            f"{way} / equations only": ratio(seconds[way], seconds["equations only"])
            for way in ("with keyframes", "three columns", "all columns")
        }
    return {"title": "Storing a run at 1 kHz", "rows": rows}
