"""Integrate many tops of one scenario in memory, on several threads.

`Problems` go in, `Outcomes` come out; each thread has its pools, all share a queue of tops.
"""

import itertools
import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from typing import Any

import numpy as np

from ..engine.observables import event_functions
from ..engine.pools import HybridPools, Pools, bodies_of, new_tops
from ..engine.status import Status
from ..errors import InputError
from ..problem import Problem, Problems
from ..progress import Report
from ..runs.growth import growth
from .hybrid_tops import checked_tops, problem_of, run_each
from .lanes import MOST_STEPS, PoolOfOne, run_tops
from .outcomes import LYAPUNOV, QUIET, Outcomes, _conclude
from .top_events import log_events


@QUIET
def measure(
    tops: Problems,
    *,
    threads: int | None = None,
    progress: Report | None = None,
    wanted: Collection[str] | None = None,
    lyapunov: bool = False,
    events: bool = False,
    times: np.ndarray | None = None,
    most: int = MOST_STEPS,
) -> Outcomes:
    """Integrate every valid top to its end.

    Parameters
    ----------
    tops
        The tops, made by `vary`.
    threads
        Number of threads; by default one per usable core.
    progress
        Called as progress(done, of), which count valid tops, from any thread.
    wanted
        Names of the columns that are read; None: all. The others may be empty; these have the
        same bits. (), as `rows_at_times` passes it: only `rows` are, and columns stay internal.
    lyapunov
        Whether finite-time Lyapunov exponents are computed: one top after the other, each at the
        cost of several runs. The exponent of a top that is invalid, or ends at its start, is NaN.
    events
        Whether the events of each top are logged.
    times
        Internal times of rows, ascending (n, k); before the start (negative) rows stay NaN.
    most
        Steps of one top in smooth motion at most.

    Returns
    -------
    Outcomes
        A row per top; invalid ones have the status `invalid`.
    """
    clock = time.perf_counter()
    processor = time.process_time()
    measured = Outcomes(tops, lyapunov, times)
    lock = threading.Lock()
    counted = itertools.count(1)
    total = int(tops.valid.sum())

    def ended() -> None:
        """Report that one more top has ended; threads call it."""
        if progress is not None:
            with lock:
                progress(next(counted), total)

    turns = getattr(tops.base.form.orientation, "psi", None)  # not in a plane, with a signed theta
    is_hybrid = tops.base.system.is_hybrid
    begun = tops
    if is_hybrid:
        mu = np.broadcast_to(tops.given("friction").get("mu", 1.0), (tops.n,))
        # run alone: tops without friction among others, as they have other phases; those in a
        # plane; user-defined systems with phases; all whose events are logged
        alone = (mu == 0) & (mu != 0).any()
        alone |= not turns or tops.base.contact is None or events
        begun, faults = checked_tops(tops)
        for top, sentence in faults:
            measured.refuse(top, sentence)
            ended()
        # not known before the jump to the first phase, see `new_tops`
        functions = np.full((tops.n, 1), np.nan)
    else:
        functions = event_functions(tops)
        alone = _ends_at_start(tops, functions)
    valid = measured.status != Status.INVALID.code
    numbers = np.flatnonzero(valid & ~alone)
    if len(numbers):
        bodies = bodies_of(begun) if is_hybrid else tops.pars
        n = min(threads or len(os.sched_getaffinity(0)), -(-len(numbers) // Pools.lanes))
        room = -(-len(numbers) // n)  # an equal share, so that no thread takes all tops
        stop = threading.Event()
        first = problem_of(tops, int(numbers[0]))
        groups = [
            HybridPools(first, stop)
            if is_hybrid
            else PoolOfOne(tops, wanted, events=events, most=most)
            for _ in range(n)
        ]
        every = new_tops(groups[0], n, begun, functions, bodies, measured.times)
        for thread, group in enumerate(groups):
            group.join(every, thread)
        workers = [partial(run_tops, measured, group, ended, room, stop) for group in groups]
        _run_all(workers, iter(numbers.tolist()), stop)
        possible = sum(group.possible for group in groups)
        measured.occupancy = int(measured.columns["steps"].sum()) / max(1, possible)
    if measured.passages:
        log_events(measured)
    run_each(measured, np.flatnonzero(valid & alone).tolist(), ended, events=events)
    measured.faults.sort()
    # rows at the end itself, where a top ended before its row was written; times are internal still
    ends = measured.columns["t_end"][:, None]
    made = np.isfinite(measured.rows[:, :, 0])
    # a time below 0 is before the start: its row stays NaN
    which, row = np.nonzero(~made & (measured.times >= 0) & (measured.times <= ends))
    measured.rows[which, row] = measured.final[:, which].T
    if lyapunov or wanted != ():
        _conclude(measured)
    if lyapunov:
        ends = measured.columns["t_end"]  # SI since `_conclude`, as `growth` takes times
        for top in np.flatnonzero(ends > 0).tolist():
            times = np.array([0.0, ends[top]])
            exponents = growth(problem_of(tops, top), times).exponents
            measured.columns[LYAPUNOV][top] = exponents[-1]
    measured.seconds = time.perf_counter() - clock
    measured.processor = time.process_time() - processor
    return measured


def _run_all(workers: Sequence[Callable], queue: Iterator[int], stop: threading.Event) -> None:
    """Integrate the tops of a queue by all workers, on a thread each if there are several.

    If one fails, or on Ctrl-C, `stop` is set, which ends the others, and the exception is raised.
    """
    if len(workers) == 1:
        workers[0](queue)
        return
    with ThreadPoolExecutor(len(workers)) as pool:
        # inside the block, whose end waits for all workers: `stop` must be set before
        try:
            for done in as_completed([pool.submit(worker, queue) for worker in workers]):
                done.result()
        finally:
            stop.set()


def _ends_at_start(tops: Problems, functions: np.ndarray) -> np.ndarray:
    """Return which tops end before their first step, (n,).

    Those are the tops with an event function that is below zero, where it must not fall. Lanes
    find zeros on the way only; a run of its own ends such a top at t = 0.
    """
    ends = tops.base.on_liftoff == "stop"
    # events with extremes, such as a force, must not fall below zero, as in `of_start` of loop.c
    stops = [bool(ends and event.ends and event.extremes) for event in tops.base.system.events]
    return np.any(functions[:, stops] < 0, axis=1)


@QUIET
def vary(base: Problem, variations: Mapping[str, Any], *, orientation: bool = False) -> Problems:
    """Return the tops of a problem and its variations, for lanes.

    It is `Problems.vary` after the checks of `lanes_faults`.

    Parameters
    ----------
    base
        The problem that is varied.
    variations
        Arrays (n,) in SI units, under dotted keys like `friction.mu`.
    orientation
        Whether the orientation of the bodies is integrated too.

    Returns
    -------
    Problems
        Its `check` returns the invalid tops, and why they are invalid.

    Raises
    ------
    InputError
        If the problem cannot run in lanes, or a key or a shape is wrong.
    """
    sentences = lanes_faults(base)
    if orientation and base.form.orientation is None:
        sentences.append("`orientation` must be false: the form does not integrate it.")
    if sentences:
        raise InputError(sentences)
    return Problems.vary(base, variations, orientation)


def lanes_faults(base: Problem) -> list[str]:
    """Return why a problem cannot run in lanes, in sentences; empty if it can.

    Parameters
    ----------
    base
        The base of the tops.

    Returns
    -------
    list of str
        Sentences. Lanes require an event, a form that integrates the axis, and doubles.
    """
    sentences = []
    if not base.system.events:
        sentences.append(
            f"the system of an ensemble must have an event, but `{base.system.name}` has none."
        )
    forms = base.system.forms.items()
    able = [name for name, form in forms if {"ux", "uy", "uz"} <= set(form.units._fields)]
    if base.form.name not in able:
        others = " or ".join(f'"{name}"' for name in able) or "which no form of this system does"
        sentences.append(
            "`form` must integrate the axis (ux, uy, uz) in an ensemble: "
            f'{others}, but is "{base.form.name}".'
        )
    if base.precision != "double":
        sentences.append(
            f'`run.precision` must be "double" in an ensemble, but is "{base.precision}".'
        )
    return sentences
