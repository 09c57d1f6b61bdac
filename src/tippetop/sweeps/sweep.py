"""A plan becomes a store of many tops: chunk by chunk, on any number of workers, resumable, always the same bits."""

import contextlib
import os
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, Unfinished
from ..progress import shown
from ..runs import recording
from ..scenario import build
from ..store import provenance, root
from .chunk import Task
from .plan import Plan, read
from .store import RUNS, SweepStore, opened
from .summary import open_sweep
from .workers import Outcome, SchedulerLost, connected, here, on, own


if TYPE_CHECKING:
    import xarray as xr


SMALL = 20.0  # core seconds: a process needs 6 s to compile, so less is done sooner by threads of this one


def sweep(
    plan: str | Path | Plan,
    out: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | bool = False,
) -> "xr.Dataset":
    """Runs every top of a plan into the store `out`, or goes on with it, and opens it: a line per top.

    `workers` processes on this machine compute (one: this process itself; by default as many as usable cores, or
    threads of this process where little is to be done), or the workers of a dask scheduler at an address.
    `progress(done, of)` counts tops; True draws a bar. Raises ScenarioError, StoreError, Unfinished.
    """
    made = plan if isinstance(plan, Plan) else read(plan)
    if workers is not None and workers < 1:
        raise InputError([f"--workers must be at least 1, but is {workers}."])
    if scheduler is not None and not find_spec("distributed"):
        raise InputError(["--scheduler must find dask, but it is not installed: install tippetop[sweep]."])
    with (
        shown(progress, "tops") as tell,
        contextlib.nullcontext() if scheduler is None else connected(scheduler) as client,
        opened(out, made) as store,
    ):
        sentences = _fill(store, workers, client, tell)
        if not sentences:
            _run_alone(store)
            store.finish()
    if sentences:
        raise Unfinished(sentences)
    return open_sweep(out)


def _fill(store: SweepStore, workers: int | None, client: Any, progress: Callable[[int, int], None]) -> list[str]:
    """Computes and writes what is not done; gives a sentence for each chunk that failed."""
    plan, todo = store.plan, store.todo()
    done = plan.n - sum(len(plan.tops(chunk)) for chunk in todo)
    progress(done, plan.n)
    sentences = []
    tables, versions = build.resolved(plan.base), provenance.versions()
    tasks = (Task(chunk, tables, plan.columns(plan.tops(chunk)), plan.keep, versions) for chunk in todo)
    small = workers is None and len(todo) * plan.chunk * plan.seconds_per_top < SMALL
    try:
        for task, found in _computed(tasks, workers, client, small) if todo else ():
            tops = plan.tops(task.chunk)
            if isinstance(found, str):
                sentences.append(f"chunk {task.chunk} (tops {tops[0]} to {tops[-1]}) failed: {found}.")
                store.fail(task.chunk, found)
                continue
            store.write(task.chunk, found)
            done += len(tops)
            progress(done, plan.n)
    except SchedulerLost:
        sentences.append("the scheduler went away; what it gave back is stored.")
    return sentences


def _computed(tasks: Iterator[Task], workers: int | None, client: Any, small: bool) -> Iterator[Outcome]:
    """The chunks as they are computed: by the workers of a client, here, or by processes of our own."""
    threads = workers or len(os.sched_getaffinity(0))
    if client is not None:
        yield from on(client, tasks)
    elif small or threads == 1 or not find_spec("distributed"):
        yield from here(tasks, threads)
    else:
        with own(threads) as mine:
            yield from on(mine, tasks)


def _run_alone(store: SweepStore) -> None:
    """Runs the tops that the plan wants whole, each into a store of its own."""
    for top in store.plan.runs:
        place = store.folder / RUNS / str(top)
        if not place.exists():
            recording.record(store.plan.problem(top), place)
        elif root.attributes(place)["status"] == "running":
            recording.resume(place)
