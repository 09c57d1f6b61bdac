"""The cost of the store and of worker processes in a sweep: the same tops alone, by one, by two.

Each worker has one thread. Where others use the machine, the wall clock measures them too: a second
efficiency is that of processor time, in which the busier of two workers determines the end.
"""

import contextlib
import multiprocessing
import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

from tippetop.ensembles import ensemble
from tippetop.sweeps import sweep, workers
from tippetop.sweeps.plan import Plan


class Pool(NamedTuple):
    """Worker processes, and what computes in them."""

    processes: list[Any]
    executor: Any


class Cost(NamedTuple):
    """Seconds by the wall clock, of all processors, and of the processor of the busiest worker."""

    wall: float
    processor: float
    busiest: float


def plain(document: dict[str, Any]) -> tuple[float, float]:
    """Return seconds by the wall clock and of the processor for the tops of a plan in one call."""
    made, clock, processor = Plan.from_tables(document), time.perf_counter(), time.process_time()
    tops = ensemble.vary(made.base, made.columns(np.arange(made.n)))
    ensemble.measure(tops, threads=1)
    return time.perf_counter() - clock, time.process_time() - processor


def swept(made: Plan, pool: Pool) -> Cost:
    """Return the cost of a plan into a new store, by the workers of a pool, which are warm."""
    given = workers.Workers(
        lambda again: contextlib.nullcontext(pool.executor), lambda: len(pool.processes) + 1
    )
    connected = mock.patch.object(sweep, "connect", return_value=contextlib.nullcontext(given))
    with tempfile.TemporaryDirectory() as folder, connected:
        before, mine, clock = used(pool), time.process_time(), time.perf_counter()
        sweep.sweep(made, Path(folder) / "S.zarr", scheduler="local")
        wall, mine = time.perf_counter() - clock, time.process_time() - mine
    each = np.subtract(used(pool), before)
    return Cost(wall, each.sum() + mine, each.max())


@contextlib.contextmanager
def warm_pool(count: int) -> Iterator[Pool]:
    """Provide processes of this machine, one thread each, that have compiled all they need."""
    others = {child.pid for child in multiprocessing.active_children()}
    with workers.processes(count).start(False) as executor:
        futures = [executor.submit(plain, shared(256, 64).document) for _ in range(4 * count)]
        for future in futures:
            future.result()
        children = multiprocessing.active_children()
        yield Pool([child for child in children if child.pid not in others], executor)


def used(pool: Pool) -> list[float]:
    """Return the processor seconds of each worker."""
    ticks = []
    for process in pool.processes:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        ticks.append(sum(map(int, fields[11:13])))
    return [count / os.sysconf("SC_CLK_TCK") for count in ticks]


def tops(n: int) -> Plan:
    """Return canonical tops of 10 s with other spins, in chunks of some four seconds."""
    axis = {"of": "initial.omega3", "linspace": [100.0, 160.0], "n": n}
    return Plan.from_tables({"scenario": "inverting", "axis": [axis], "chunk": min(n, 4096)})


def shared(n: int, chunk: int) -> Plan:
    """Return such tops in chunks that two workers can share evenly."""
    return Plan.from_tables({**tops(n).document, "chunk": chunk})


def compare(quick: bool) -> dict[str, Any]:
    """Return medians of all, interleaved, and the efficiency of a second worker."""
    made, rounds = tops(4096 if quick else 8192), 3 if quick else 5
    many = shared(2 * made.n, 512)
    with warm_pool(1) as one, warm_pool(2) as two:
        # both in the same process: from one to the next, equal work differs by up to a tenth
        costs = [
            (one.executor.submit(plain, made.document).result(), swept(made, one))
            for _ in range(rounds)
        ]
        pairs = [(swept(many, one), swept(many, two)) for _ in range(rounds)]
    rows: dict[str, dict[str, float]] = {
        way: {
            "seconds": statistics.median(row[i][0] for row in costs),
            "wall time / plain": statistics.median(row[i][0] / row[0][0] for row in costs),
            "processor time / plain": statistics.median(row[i][1] / row[0][1] for row in costs),
        }
        for i, way in enumerate(("plain, in the worker", "into a store, by the worker"))
    }
    for i, count in enumerate(("one worker", "two workers")):
        seconds = statistics.median(pair[i].wall for pair in pairs)
        rows[f"chunks of 512 tops, {count}"] = {"seconds": seconds}
    busy = [a.busiest / max(b.busiest, b.processor / 2) for a, b in pairs]
    rows["chunks of 512 tops, two workers"] |= {
        "efficiency by wall time": statistics.median(a.wall / b.wall for a, b in pairs) / 2,
        "by processor time": statistics.median(busy) / 2,
    }
    return {"title": f"{made.n} canonical tops of 10 s, 4096 to a chunk", "rows": rows}
