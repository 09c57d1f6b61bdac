"""What storing costs: a run at 1 kHz with events, drift, store and checkpoints against heyoka alone, side by side.

usage: python bench/bench_record.py [--quick]       writes bench/results/record.json
"""

import json
import os
import platform
import statistics
import sys
import tempfile
import time
from pathlib import Path

import heyoka as hy

from tippetop import engine, record, scenario
from tippetop.solve import Course, Memory


CASES = {
    "rolling tippe top": ("rolling", 1000.0),
    "canonical inversion, mu = 0": ("inverting", 1000.0),
    "heavy top": ("heavy-top", 4000.0),
}


class Nothing(Memory):
    """A sink that keeps nothing: events, drift and dense output are still worked out."""

    def rows(self, times, states):
        """Drops rows."""

    def events(self, table, marks):
        """Drops events."""


def bare(problem) -> float:
    """Seconds of one propagate_until of the same equations, without events."""
    integrator = engine.integrator_of(problem)
    plain = hy.taylor_adaptive(
        list(integrator.sys), integrator.state.copy(), pars=list(integrator.pars), high_accuracy=True
    )
    clock = time.perf_counter()
    plain.propagate_until(problem.until / float(problem.scales.time))
    return time.perf_counter() - clock


def followed(problem) -> float:
    """Seconds of the run without rows."""
    course = Course(problem)
    clock = time.perf_counter()
    course.run(Nothing())
    return time.perf_counter() - clock


def stored(problem) -> float:
    """Seconds of the run into a store."""
    with tempfile.TemporaryDirectory() as folder:
        clock = time.perf_counter()
        record.record(problem, Path(folder) / "run.zarr")
        return time.perf_counter() - clock


def main() -> None:
    """Runs all cases, interleaved, and writes the medians and the ratios pair by pair."""
    quick = "--quick" in sys.argv
    found = {"machine": f"{platform.machine()}, {os.cpu_count()} processors", "load": os.getloadavg()[0], "cases": {}}
    for name, (preset, until) in CASES.items():
        sets = ["run.output_step=0.001"] + (["friction.mu=0.0"] if preset == "inverting" else [])
        problem = scenario.load(preset, sets, until / 10 if quick else until)
        for function in (bare, followed, stored):
            function(scenario.load(preset, sets, 1.0))  # compile
        rounds = [(bare(problem), followed(problem), stored(problem)) for _ in range(3 if quick else 5)]
        found["cases"][name] = {
            "seconds": dict(
                zip(("bare", "followed", "stored"), map(statistics.median, zip(*rounds, strict=True)), strict=True)
            ),
            "followed / bare": statistics.median(f / b for b, f, _ in rounds),
            "stored / bare": statistics.median(s / b for b, _, s in rounds),
            "rows": len(problem.times),
        }
        print(name, json.dumps(found["cases"][name]))
    place = Path(__file__).parent / "results" / "record.json"
    place.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
