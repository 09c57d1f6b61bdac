"""The cost of storing a run at 1 kHz, with events and drift, against its equations alone.

Processor seconds of both threads (a second one writes the store), and wall time. Two bounds: the
same columns written by zarr alone, from memory, and a run so long that the making of a store no
longer counts.
"""

import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import zarr

from tippetop.cli.host import prepare
from tippetop.problem import Problem
from tippetop.runs import recording, starting
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve
from tippetop.runs.sinks import Sink
from tippetop.sampling import EvenTimes

from .measure import Seconds, interleaved, ratio, spent
from .ours import alone, end_of


RUNS = {
    "rolling tippe top": ("rolling", 1000.0),
    "canonical inversion, mu = 0": ("inverting", 1000.0),
    "heavy top": ("heavy-top", 4000.0),
}


THREE = ("theta", "phi_dot", "omega3")


def bare(problem: Problem) -> Seconds:
    """Return seconds of one propagate_until of the same equations, without events."""
    plain = alone(problem)
    return spent(lambda: plain.propagate_until(end_of(problem)))


def followed(problem: Problem) -> Seconds:
    """Return seconds of the run without rows."""
    integration = Integration(problem)
    return spent(lambda: integration.run(Sink()))


def stored(problem: Problem) -> Seconds:
    """Return seconds of the run into a store."""
    with tempfile.TemporaryDirectory() as folder:
        return spent(lambda: recording.record(problem, Path(folder) / "run.zarr"))


def keyframes(problem: Problem) -> Seconds:
    """Return seconds of the run into a store of keyframes and events, without rows."""
    return stored(replace(problem, output="keyframes"))


def three(problem: Problem) -> Seconds:
    """Return seconds of the run into a store of three columns.

    What they do not need is not integrated.
    """
    return stored(replace(problem, columns=THREE, orientation=False))


CODECS: list[Any] = [
    zarr.codecs.BloscCodec(cname="lz4", clevel=1, shuffle="shuffle"),
    zarr.codecs.Crc32cCodec(),
]


def zarr_alone(problem: Problem) -> dict[str, float]:
    """Return processor seconds of zarr for all columns, and for three, from memory.

    In our chunks and codecs, inferred from one chunk of each column, written twice.
    """
    rows = recording.ROWS_PER_CHUNK
    columns = solve(
        replace(problem, times=EvenTimes(0.001, (rows - 1) * 0.001), until=(rows - 1) * 0.001)
    ).columns()
    seconds = {}
    with tempfile.TemporaryDirectory() as folder:
        group = zarr.open_group(folder, mode="w")
        for name, column in columns.items():
            values = column.values
            array = group.create_array(
                name,
                shape=values.shape,
                chunks=values.shape,
                dtype=values.dtype,
                compressors=CODECS,
            )
            array[:] = values
            seconds[name] = spent(
                lambda array=array, values=values: array.__setitem__(slice(None), values)
            )
    share = len(problem.times) / rows
    return {
        "three": share * sum(seconds[name] for name in ("time", *THREE)),
        "stored": share * sum(seconds.values()),
    }


def compare(quick: bool) -> dict[str, Any]:
    """Return seconds of each run: bare, followed, stored with keyframes, three columns or all."""
    prepare()  # as `tippetop run` does
    found: dict[str, Any] = {"title": "Storing a run at 1 kHz", "runs": {}}
    for name, (preset, until) in RUNS.items():
        sets = ["run.output_step=0.001"] + (["friction.mu=0.0"] if preset == "inverting" else [])
        problem = starting.load(preset, sets, until / 10 if quick else until)
        works = {
            f.__name__: lambda f=f, p=problem: f(p)
            for f in (bare, followed, keyframes, three, stored)
        }
        seconds: dict[Any, list[Any]] = interleaved(works, 4)
        found["runs"][name] = {
            "rows": len(problem.times),
            "seconds": {name: statistics.median(times) for name, times in seconds.items()},
            "wall": {
                name: statistics.median(each.wall for each in times)
                for name, times in seconds.items()
            },
            "zarr alone": zarr_alone(problem),
            **{
                f"{way} / bare": ratio(seconds[way], seconds["bare"])
                for way in seconds
                if way != "bare"
            },
        }
    found["long"] = {name: long(preset, until * 5, quick) for name, (preset, until) in RUNS.items()}
    return found


def long(preset: str, until: float, quick: bool) -> dict[str, float]:
    """Return ratios of keyframes over a span in which making the store takes no share."""
    sets = ["run.output=keyframes"] + (["friction.mu=0.0"] if preset == "inverting" else [])
    problem = starting.load(preset, sets, until / 10 if quick else until)
    works = {f.__name__: lambda f=f: f(problem) for f in (bare, followed, keyframes)}
    seconds: dict[Any, list[Any]] = interleaved(works, 2)
    ways = {
        f"{way} / bare": ratio(seconds[way], seconds["bare"]) for way in ("followed", "keyframes")
    }
    return {"until": problem.until, **ways}
