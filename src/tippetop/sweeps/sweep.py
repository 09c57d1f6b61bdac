"""Run the tops of a plan into a store, chunk by chunk, on any number of workers.

A `Plan` and a path go in; chunks go to workers as `chunk.Task`, and their columns to the store.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..arguments import instance, positive_integer
from ..errors import InputError, Interrupted, StoreError, Unfinished, warn
from ..mechanics.systems import find, known_to_others
from ..problem import Problem
from ..progress import Report, reporting
from ..runs import recording, resuming
from ..runs.certificate import broken_by_tops
from ..scenario import build
from ..scenario.identity import user_records
from ..store import files, provenance, root
from ..store.ledger import Ledger
from .chunk import Task
from .plan import Plan
from .store import GROUP, RUNS, opened, put_events
from .sweep_summary import open_sweep
from .workers import SchedulerLost, Workers, connect, in_process, on_workers, processes


if TYPE_CHECKING:
    import xarray as xr


# core seconds: processes must start and may compile, so less is done sooner by threads of this one
SMALL = 20.0
FINISHED = {"status": "finished", "reason": "every top was run"}
KEPT = "Stored chunks are kept: the same command without --overwrite continues it."


def sweep(
    plan: Plan,
    place: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | bool = True,
    stop: threading.Event | None = None,
    overwrite: bool = False,
) -> xr.Dataset:
    """Run every top of a plan into a store, or continue it; see `tippetop.sweep`."""
    workers = None if workers is None else positive_integer("workers", workers)
    instance("stop", stop, threading.Event | None, "a threading.Event")
    unknown = _unknown_to_others(plan.base)
    if unknown and (scheduler is not None or (workers or 1) > 1):
        raise InputError(f"{unknown}: take workers=1.")
    warn(plan.doubts, 4)
    with (
        reporting(progress, "tops") as report,
        contextlib.nullcontext() if scheduler is None else connect(scheduler) as cluster,
        opened(place, plan, overwrite) as store,
    ):
        sentences = _fill(store, plan, workers, cluster, report, stop, here=bool(unknown))
        if not sentences:
            for top in plan.runs:
                _run_alone(place, plan, top, stop)
            if not store.state.seal:
                with files.writing(place, KEPT):
                    store.finish(store.state.changed | FINISHED)
    if sentences:
        raise Unfinished(sentences)
    table = open_sweep(place)
    warn(broken_by_tops(table, plan.base.tolerance), 4)
    return table


def _unknown_to_others(base: Problem) -> str:
    """Return why worker processes cannot make the problem `base`, a clause, or an empty text.

    Formulas are pickled by name, and systems and laws are looked up in registries. `sweep` adds the
    remedy to the clause.
    """
    try:
        is_named = b"__main__" not in pickle.dumps(user_records(base.system))
    except Exception:  # a formula may be any object
        is_named = False
    if not is_named:
        return (
            "formulas of `events` and `columns` must be named functions (`def`, not `lambda`) of a "
            "module that workers can import"
        )
    package = "must come from an installed package for workers to know it"
    if not known_to_others(find(base.system.name)):
        return f"the system `{base.system.name}` {package}"
    if not known_to_others(type(base.friction)):
        return f"the friction law `{base.law.key}` {package}"
    return ""


def _fill(
    store: Ledger,
    plan: Plan,
    workers: int | None,
    cluster: Workers | None,
    progress: Report,
    stop: threading.Event | None,
    *,
    here: bool,
) -> list[str]:
    """Compute and write the chunks that the store lacks; return a sentence for each that failed.

    Each chunk is acknowledged as soon as it is computed, so that it survives an interruption.

    Parameters
    ----------
    store, plan
        The open store, and its plan.
    workers
        How many threads or processes; None: as many as there are cores.
    cluster
        Workers of a scheduler, which compute instead.
    progress
        Called with the numbers of finished tops and of all.
    stop
        Raise Interrupted after a chunk if it is set.
    here
        Whether the default is threads of this process, however long they take.
    """
    todo = [k for k in range(plan.chunks) if f"{GROUP}/{k}" not in store.state.chunks]
    done = plan.n - sum(len(plan.tops(chunk)) for chunk in todo)
    progress(done, plan.n)
    if not todo:
        return []
    if stop is not None and stop.is_set():
        raise Interrupted
    sentences = []
    # the last fields of `Task`, in their order
    given = plan.keep, provenance.versions(), plan.own
    tables = build.resolved(plan.base)
    tasks = (Task(chunk, tables, plan.columns(plan.tops(chunk)), *given) for chunk in todo)
    threads = workers or len(os.sched_getaffinity(0))
    small = here or len(todo) * plan.chunk * plan.seconds_per_top < SMALL
    if cluster is None and (threads == 1 or (workers is None and small)):
        results = in_process(tasks, threads)
    else:
        results = on_workers(cluster or processes(threads), tasks)
    try:
        for task, result in results:
            tops = plan.tops(task.chunk)
            key = f"{GROUP}/{task.chunk}"
            failed = {key: result} if isinstance(result, str) else {}
            with files.writing(store.path, KEPT):
                rows = {}
                if not isinstance(result, str):
                    store.put(key, {**plan.design.numbers(tops), **task.columns, **result})
                    # acknowledged with their tops, by one commit
                    rows = put_events(store, task.chunk, int(tops[0]), result)
                store.commit(failed=failed, rows=rows)
                if rows:  # readers must know the shape
                    store.derive({})
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


def _run_alone(path: Path, plan: Plan, top: int, stop: threading.Event | None) -> None:
    """Run one top of a sweep into its store, continue it, or leave it if it is finished.

    A StoreError of a missing or damaged store is ignored: the top is run again from its start. So
    is one whose store has another scenario; the old store is replaced. Raises StoreError if another
    process writes it, and Interrupted.

    Parameters
    ----------
    path
        The store of the sweep, in whose group `RUNS` the store is named after the top.
    plan
        The plan of the sweep.
    top
        The number of the top.
    stop
        Interrupts the run if it is set.
    """
    problem = plan.problem(top)
    known = problem.system if any(plan.own) else None
    place = files.own_folder(path / RUNS) / str(top)
    with contextlib.suppress(StoreError):
        attrs = root.root_of(place)
        if root.finite(build.resolved(problem)).items() <= attrs.items():
            if attrs["status"] == "running":
                resuming.resume(place, stop=stop, known=known)
            else:  # finished: only checked and tidied
                resuming.opened(place).release()
            return
    recording.record(problem, place, overwrite=place.exists(), stop=stop, in_sweep=True)
