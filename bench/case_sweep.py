"""What dask and the store cost a sweep: one worker through both against `ensembles.measure`, on the
same tops.
"""

import contextlib
import logging
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from tippetop.ensembles import ensemble
from tippetop.sweeps import sweep
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.workers import of_client


def plain(document: dict[str, Any]) -> tuple[float, float]:
    """Seconds by the wall clock and of the processor, of the tops of a plan in one call, one
    thread.
    """
    made, clock, processor = Plan.from_tables(document), time.perf_counter(), time.process_time()
    tops = ensemble.vary(made.base, made.columns(np.arange(made.n)))
    ensemble.measure(tops, threads=1)
    return time.perf_counter() - clock, time.process_time() - processor


def swept(made: Plan, client: Any) -> tuple[float, float]:
    """The same into a new store, by the workers of a client, which are warm; processor: workers and
    writer.
    """
    its_own = mock.patch.object(
        sweep, "connect", return_value=contextlib.nullcontext(of_client(client))
    )  # only it has the keys
    with tempfile.TemporaryDirectory() as folder, its_own:
        before, clock = used(client), time.perf_counter()
        sweep.sweep(made, Path(folder) / "S.zarr", scheduler="local")
        return time.perf_counter() - clock, used(client) - before


@contextlib.contextmanager
def local_cluster(count: int) -> Iterator[Any]:
    """A client of processes of dask on this machine, one thread each."""
    from distributed import Client, LocalCluster

    settings: dict[str, Any] = {
        "threads_per_worker": 1,
        "dashboard_address": ":0",
        "memory_limit": 0,
    }
    with (
        LocalCluster(count, **settings) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def used(client: Any) -> float:
    """Processor seconds of this process and of the workers."""
    return time.process_time() + sum(client.run(time.process_time).values())


def tops(n: int) -> Plan:
    """Canonical tops of 10 s with other spins, in chunks of some four seconds, as a large sweep has
    them.
    """
    axis = {"of": "initial.omega3", "linspace": [100.0, 160.0], "n": n}
    return Plan.from_tables({"scenario": "inverting", "axis": [axis], "chunk": min(n, 4096)})


def compare(quick: bool) -> dict[str, Any]:
    """Runs all, interleaved: the medians, and those of the ratios pair by pair; and what a second
    worker brings.
    """
    logging.getLogger("distributed").setLevel(logging.ERROR)  # it tells of every connection
    made, rounds = tops(4096 if quick else 8192), 3 if quick else 5
    with local_cluster(1) as client:
        swept(shared(1024, 256), client)
        # both in the same process: from one to the next, equal work differs by up to a tenth
        rows = [
            (client.submit(plain, made.document, pure=False).result(), swept(made, client))
            for _ in range(rounds)
        ]
        many = shared(2 * made.n, 1024 if quick else 2048)
        with local_cluster(2) as both:
            swept(shared(1024, 256), both)
            pairs = [(swept(many, client), swept(many, both)) for _ in range(3)]
    ways = ("plain, in the worker", "into a store, by the worker")
    return {
        "title": "Canonical tops of 10 s, 4096 to a chunk",
        "tops": made.n,
        "ways": {
            way: {
                "seconds": statistics.median(one[i][0] for one in rows),
                "wall": statistics.median(one[i][0] / one[0][0] for one in rows),
                "processor": statistics.median(one[i][1] / one[0][1] for one in rows),
            }
            for i, way in enumerate(ways)
        },
        "seconds_by_1_and_2_workers": [
            statistics.median(pair[i][0] for pair in pairs) for i in range(2)
        ],
        "processor_of_1_and_2_workers": [
            statistics.median(pair[i][1] for pair in pairs) for i in range(2)
        ],
        "efficiency_of_2_workers": statistics.median(one[0] / two[0] for one, two in pairs) / 2,
    }


def shared(n: int, chunk: int) -> Plan:
    """So many, in chunks that two workers can share evenly."""
    return Plan.from_tables({**tops(n).document, "chunk": chunk})
