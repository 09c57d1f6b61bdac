"""Many tops of one scenario, in memory: a Dataset with one row per top."""

import itertools
import os
import threading
import time
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from ..engine.derivatives.growth import growth
from ..engine.loop import rows_of_tops
from ..engine.observables import event_functions
from ..engine.settling import slides
from ..engine.tallies import EventRows, Tallies, new_tallies
from ..errors import InputError
from ..problem import Problem, Problems
from ..progress import Report
from .hybrid_lanes import HybridLanes
from .hybrid_tops import problem_of, run_each
from .lanes import LANES, Lanes
from .outcomes import LYAPUNOV, QUIET, SWINGS, Outcomes, _conclude
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
) -> Outcomes:
    """Integrate every valid top to its end; `progress(done, n)` is called now and then.

    Parameters
    ----------
    tops
        As `vary` gives them.
    threads
        How many; by default one per usable core.
    progress
        Called as progress(done, of), which count valid tops, from any thread.
    wanted
        Names of the columns that are read, None: all. The others may be empty; these have the
        same bits.
    lyapunov
        Whether the finite-time Lyapunov exponents are wanted: one top after the other, several
        runs' cost each. That of a top that is invalid, or ends at its start, is NaN.
    events
        Whether the events of each top are logged.
    times
        Internal times of rows, ascending (n, k).

    Returns
    -------
    Outcomes
        A row per top; invalid ones have the status `invalid`.
    """
    clock = time.perf_counter()
    processor = time.process_time()
    measured = Outcomes(tops, lyapunov, times)
    functions = event_functions(tops)
    lock = threading.Lock()
    counted = itertools.count(1)
    total = int(tops.valid.sum())

    def ended() -> None:
        if progress is not None:
            with lock:
                progress(next(counted), total)

    hybrid = tops.base.system.is_hybrid
    alone = _ends_at_start(tops, functions) | hybrid
    separate = np.flatnonzero(tops.valid & alone).tolist()
    most = threads or len(os.sched_getaffinity(0))
    turns = getattr(tops.base.form.orientation, "psi", None)  # not in a plane, with a signed theta
    if hybrid and turns and tops.base.contact is not None and not events:
        queue = iter(separate)
        n = min(most, -(-len(separate) // LANES))
        pooled = [HybridLanes(measured, ended) for _ in range(n)]
        _run_all([partial(worker.run, queue) for worker in pooled], [w.stop for w in pooled])
        separate = sorted(chain(*(worker.alone for worker in pooled)))
        possible = sum(worker.possible for worker in pooled)
        measured.occupancy = sum(worker.steps for worker in pooled) / max(1, possible)
    run_each(measured, separate, ended, events=events)
    measured.faults.sort()
    if len(numbers := np.flatnonzero(tops.valid & ~alone)):
        queue = iter(numbers.tolist())
        n = min(most, -(-len(numbers) // LANES))
        workers = [Lanes(tops, LANES, wanted, events=events) for _ in range(n)]
        tallies = new_tallies(workers[0].rows, functions.T)
        rows = rows_of_tops(measured.times, len(workers[0].motion.state))
        for worker in workers:
            worker.loop.fill(rows)
        _run_all(
            [partial(worker.run, measured, tallies, queue, ended) for worker in workers],
            [worker.stop for worker in workers],
        )
        _write(measured, numbers, tallies, workers[0].rows)
        measured.rows[numbers] = rows.states[numbers, :, : len(tops.start)]
        if measured.passages:
            log_events(measured, measured.passages, tallies.lane["lasts_since"])
    ends = measured.columns["t_end"][:, None]
    made = np.isfinite(measured.rows[:, :, 0])
    top, row = np.nonzero(~made & (measured.times >= 0) & (measured.times <= ends))
    measured.rows[top, row] = measured.final[:, top].T
    _conclude(measured)
    if lyapunov:
        ends = measured.columns["t_end"]
        for top in np.flatnonzero(ends > 0).tolist():
            times = np.array([0.0, ends[top]])
            exponents = growth(problem_of(tops, top), times).exponents
            measured.columns[LYAPUNOV][top] = exponents[-1]
    measured.seconds = time.perf_counter() - clock
    measured.processor = time.process_time() - processor
    return measured


def _run_all(runs: list[Callable[[], None]], stops: list[threading.Event]) -> None:
    """Call functions on a thread each; set their `stops` if one has failed, or on Ctrl-C."""
    if not runs:
        return
    with ThreadPoolExecutor(len(runs)) as pool:
        try:
            running = [pool.submit(run) for run in runs]
            wait(running, return_when=FIRST_EXCEPTION)
        finally:
            for stop in stops:
                stop.set()
    for done in running:
        done.result()


def _ends_at_start(tops: Problems, functions: np.ndarray) -> np.ndarray:
    """Return which tops end before their first step, (n,).

    Those are the tops with an event function that is below zero, where it must not fall.
    """
    ends = tops.base.on_liftoff == "stop"
    stops = [bool(ends and event.ends and event.extremes) for event in tops.base.system.events]
    return np.any(functions[:, stops] < 0, axis=1)


def _write(measured: Outcomes, numbers: np.ndarray, tallies: Tallies, rows: EventRows) -> None:
    """Write the rows of tops that ran in lanes."""
    columns = measured.columns
    lane = tallies.lane[numbers]
    kept = iter(tallies.kept[:, numbers])
    measured.status[numbers] = lane["status"]
    columns["t_end"][numbers] = lane["t"]
    for name in ("steps", *SWINGS):
        columns[name][numbers] = lane[name]
    settled = ~slides(measured.tops, measured.final[:, numbers], numbers)
    events = measured.tops.base.system.events
    each = zip(events, tallies.functions[:, numbers], rows.events["scale"], strict=True)
    for event, function, scale in each:
        if event.lasting:
            settled &= event.direction * function["sign"] > 0
        for number in event.kept:
            values = next(kept)
            if event.lasting and number.what != "count":  # it did not last to the end
                values[~settled] = np.nan
            columns[number.name][numbers] = values
        if event.extremes:
            for end, values in zip(("min", "max"), function["extremes"].T, strict=True):
                columns[f"{event.extremes}_{end}"][numbers] = values / scale
    measured.settled[numbers] = settled


@QUIET
def vary(base: Problem, variations: Mapping[str, Any], *, orientation: bool = False) -> Problems:
    """Return the tops of a problem and its variations, for lanes.

    Parameters
    ----------
    base
        Their base.
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
    sentences = base_faults(base)
    if orientation and base.form.orientation is None:
        sentences.append("`orientation` must be false: the form does not integrate it.")
    if sentences:
        raise InputError(sentences)
    return Problems.vary(base, variations, orientation)


def base_faults(base: Problem) -> list[str]:
    """Return why a problem cannot run in lanes, in sentences; empty if it can.

    Parameters
    ----------
    base
        The base of the tops.

    Returns
    -------
    list of str
        Sentences; lanes need the vector form and doubles.
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
