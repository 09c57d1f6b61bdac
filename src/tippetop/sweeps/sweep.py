"""Run the tops of a plan into a store, chunk by chunk, on any number of workers."""

import contextlib
import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from ..arguments import instance, path_of, whole
from ..errors import InputError, Interrupted, StoreError, Unfinished
from ..mechanics.systems import known_to_others
from ..problem import Problem
from ..progress import Report, reporting
from ..runs import recording, resuming
from ..scenario import build
from ..store import files, provenance, root
from ..store.ledger import Ledger
from .chunk import Task
from .plan import Plan
from .store import GROUP, RUNS, opened
from .sweep_summary import open_sweep
from .workers import SchedulerLost, Workers, connect, in_process, on_workers, processes


if TYPE_CHECKING:
    import xarray as xr


# core seconds: processes must start and may compile, so less is done sooner by threads of this one
SMALL = 20.0
FINISHED = {"status": "finished", "reason": "every top was run"}
KEPT = "Stored chunks are kept: the same command without --overwrite continues it."


def sweep(
    plan: str | Path | Plan,
    out: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Report | bool = True,
    stop: threading.Event | None = None,
    overwrite: bool = False,
) -> "xr.Dataset":
    """Run every top of a plan into the store `out`, or continue it, and open it.

    It can be called in any thread.

    Parameters
    ----------
    plan
        A TOML file, or a checked plan.
    out
        The store to make or to continue.
    workers
        Processes on this machine that compute. One: this process itself; by default as many as
        usable cores, or threads of this process where little is to be done.
    scheduler
        Address of a dask scheduler whose workers compute instead.
    progress
        Called as progress(done, of), which count tops; True draws a bar in a terminal or a
        notebook.
    stop
        Set it in a signal handler or another thread: the sweep then stops after a chunk, or
        before the first. An exception such as KeyboardInterrupt ends it at once and costs the
        chunks that are being computed. Either way the same call without `overwrite`
        continues it.
    overwrite
        Replace a store that exists, finished or not.

    Returns
    -------
    xarray.Dataset
        The table of the sweep, dimension `top`, SI units, read when needed.

    Raises
    ------
    InputError
        The plan or an argument is wrong; every fault is listed.
    StoreError
        The store is that of another plan, or cannot be read or written.
    Unfinished
        Some chunks failed.
    Interrupted
        `stop` was set.
    """
    place = path_of("out", out)
    checked = plan if isinstance(plan, Plan) else Plan.from_toml(plan)
    workers = None if workers is None else whole("workers", workers)
    instance("stop", stop, threading.Event | None, "a threading.Event")
    unknown = _unknown_to_others(checked.base)
    if unknown and (scheduler is not None or (workers or 1) > 1):
        raise InputError(
            f"{unknown} must come from an installed package for workers to know it: take workers=1."
        )
    with (
        reporting(progress, "tops") as report,
        contextlib.nullcontext() if scheduler is None else connect(scheduler) as cluster,
        opened(place, checked, overwrite) as store,
    ):
        sentences = _fill(store, checked, 1 if unknown else workers, cluster, report, stop)
        if not sentences:
            for top in checked.runs:
                _run_alone(place, checked.problem(top), top, stop)
            if not store.state.seal:
                with files.writing(place, KEPT):
                    store.finish(store.state.changed | FINISHED)
    if sentences:
        raise Unfinished(sentences)
    return open_sweep(place)


def _unknown_to_others(base: Problem) -> str:
    """Return the part of a scenario that no other process can import, or an empty text."""
    if not known_to_others(base.system):
        return f"the system `{base.system.name}`"
    if not known_to_others(type(base.friction)):
        return f"the friction law `{base.law.key}`"
    return ""


def _fill(
    store: Ledger,
    plan: Plan,
    workers: int | None,
    cluster: Workers | None,
    progress: Report,
    stop: threading.Event | None,
) -> list[str]:
    """Compute and write the chunks that are todo; return a sentence for each that failed."""
    todo = [k for k in range(plan.chunks) if f"{GROUP}/{k}" not in store.state.chunks]
    done = plan.n - sum(len(plan.tops(chunk)) for chunk in todo)
    progress(done, plan.n)
    if not todo:
        return []
    if stop is not None and stop.is_set():
        raise Interrupted
    sentences = []
    tables, versions = build.resolved(plan.base), provenance.versions()
    tasks = (
        Task(chunk, tables, plan.columns(plan.tops(chunk)), plan.keep, versions) for chunk in todo
    )
    threads = workers or len(os.sched_getaffinity(0))
    small = workers is None and len(todo) * plan.chunk * plan.seconds_per_top < SMALL
    if cluster is None and (small or threads == 1):
        results = in_process(tasks, threads)
    else:
        results = on_workers(cluster or processes(threads), tasks)
    try:
        for task, result in results:
            tops, key = plan.tops(task.chunk), f"{GROUP}/{task.chunk}"
            failed = {key: result} if isinstance(result, str) else {}
            with files.writing(store.path, KEPT):
                if not isinstance(result, str):
                    store.put(key, {**plan.design.numbers(tops), **task.columns, **result})
                store.commit(failed=failed)
            if failed:
                sentences.append(
                    f"chunk {task.chunk} (tops {tops[0]} to {tops[-1]}) failed: {result}."
                )
            else:
                done += len(tops)
                progress(done, plan.n)
            if stop is not None and stop.is_set():
                raise Interrupted
    except SchedulerLost:
        sentences.append("the scheduler went away; the results that it returned are stored.")
    return sentences


def _run_alone(path: Path, problem: Problem, top: int, stop: threading.Event | None) -> None:
    """Run one top of a sweep into its store, or continue it; one that is damaged is run again."""
    place = files.own_folder(path / RUNS) / str(top)
    with contextlib.suppress(StoreError):
        attrs = root.root_of(place)
        if root.finite(build.resolved(problem)).items() <= attrs.items():
            if attrs["status"] == "running":
                resuming.resume(place, stop=stop)
            else:
                resuming.opened(place).release()
            return
    recording.record(problem, place, overwrite=place.exists(), stop=stop, in_sweep=True)
