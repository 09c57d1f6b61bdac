"""Many tops of one scenario, in memory: a Dataset with one row per top."""

import itertools
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.derivatives.growth import growth
from ..engine.invariants import invariants, sizes
from ..engine.observables import event_functions, values_of
from ..engine.settling import slides
from ..engine.status import Status
from ..engine.tallies import EventRows, Tallies, new_tallies
from ..errors import InputError
from ..problem import Problem, Problems, derivative_faults
from ..progress import Report, reporting
from .hybrid_tops import problem_of, run_each
from .lanes import LANES, SWINGS, Lanes
from .outcomes import Outcomes, _conclude, dataset


if TYPE_CHECKING:
    import xarray as xr


QUIET = np.errstate(all="ignore")
"""The numbers of invalid tops are computed with, and not used."""


@QUIET
def measure(
    tops: Problems,
    *,
    threads: int | None = None,
    progress: Report | None = None,
    lanes: int = LANES,
    wanted: Collection[str] | None = None,
    lyapunov: bool = False,
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
    lanes
        Tops that one integrator advances at a time. It changes no bit.
    wanted
        Names of the columns that are read, None: all. The others may be empty; these have the
        same bits.
    lyapunov
        Whether the finite-time Lyapunov exponents are wanted: one top after the other, several
        runs' cost each.

    Returns
    -------
    Outcomes
        A row per top; invalid ones have the status `invalid`.
    """
    measured = Outcomes(tops)
    measured.status[~tops.valid] = Status.INVALID.code
    at_start = values_of(tops, tops.start, np.arange(tops.n))
    start, size = invariants(tops.base, at_start), sizes(tops.base, at_start)
    functions = event_functions(tops)
    measured.drift = {name: np.where(tops.valid, 0.0, np.nan) for name in start}

    def look(states: np.ndarray, some: np.ndarray) -> None:
        """Compare invariants with the start."""
        values = values_of(tops, states[: len(tops.start)], some)
        for name, value in invariants(tops.base, values).items():
            with np.errstate(all="ignore"):  # in every thread
                off = np.abs(value - start[name][some]) / size[name][some]
                np.maximum.at(measured.drift[name], some, off)

    numbers = np.flatnonzero(tops.valid & ~_ended_at_start(measured, functions))
    clock = time.perf_counter()
    if len(numbers) and tops.base.system.is_hybrid:
        run_each(measured, numbers, progress)
    elif len(numbers):
        _run(measured, numbers, look, functions, threads, progress, lanes, wanted)
    _conclude(measured)
    if lyapunov:
        measured.lyapunov = _exponents(tops, measured.columns["t_end"])
    measured.seconds = time.perf_counter() - clock
    return measured


def _ended_at_start(measured: Outcomes, functions: np.ndarray) -> np.ndarray:
    """Return which tops end before their first step, (n,).

    Those are the tops with an event function that is below zero, where it must not fall.
    """
    tops, ended = measured.tops, np.zeros(measured.tops.n, bool)
    for e, event in enumerate(tops.base.system.events):
        if tops.base.on_liftoff == "stop" and event.ends and event.extremes:
            below = tops.valid & ~ended & (functions[:, e] < 0)
            measured.status[below] = Status.of_event(event.ends).code
            for name in ("t_end", *(kept.name for kept in event.kept if kept.what != "count")):
                measured.columns[name][below] = 0.0
            for end in ("min", "max"):
                measured.columns[f"{event.extremes}_{end}"][below] = functions[below, e]
            measured.final[:, below] = tops.start[:, below]
            ended |= below
    return ended


def _exponents(tops: Problems, ends: np.ndarray) -> np.ndarray:
    """Return the finite-time Lyapunov exponent of each top up to its end [1/s], (n,).

    That of a top that is invalid, or ends at its start, is NaN.
    """
    rates = np.full(tops.n, np.nan)
    for top in np.flatnonzero(tops.valid & (ends > 0)).tolist():
        times = np.array([0.0, ends[top]])
        rates[top] = growth(problem_of(tops, top), times).exponents[-1]
    return rates


def _run(
    measured: Outcomes,
    numbers: np.ndarray,
    look: Callable[[np.ndarray, np.ndarray], None],
    functions: np.ndarray,
    threads: int | None,
    progress: Report | None,
    lanes: int,
    wanted: Collection[str] | None,
) -> None:
    """Run tops in lanes, on threads that take them from one queue."""
    lock, counted, queue = threading.Lock(), itertools.count(1), iter(numbers.tolist())
    n = max(1, min(threads or len(os.sched_getaffinity(0)), -(-len(numbers) // lanes)))

    def ended() -> None:
        if progress is not None:
            with lock:
                progress(next(counted), len(numbers))

    def work(worker: Lanes) -> float:
        """Run tops from the queue until none is left. Return the processor time."""
        clock = time.thread_time()
        try:
            worker.run(tallies, measured.final, queue, look, ended)
        except BaseException:
            deque(queue, 0)  # the others must stop
            raise
        return time.thread_time() - clock

    workers = [Lanes(measured.tops, lanes, wanted) for _ in range(n)]
    first = workers[0]
    tallies = new_tallies(first.rows, functions.T)
    if n == 1:  # Ctrl-C ends the work immediately
        measured.processor = work(first)
    else:
        with ThreadPoolExecutor(n) as pool:
            try:
                measured.processor = sum(pool.map(work, workers))
            except BaseException:  # Ctrl-C too
                deque(queue, 0)
                raise
    measured.steps_made = int(tallies.lane["steps"].sum())
    measured.steps_possible = sum(worker.steps_possible for worker in workers)
    _write(measured, numbers, tallies, first.rows)


def _write(measured: Outcomes, numbers: np.ndarray, tallies: Tallies, rows: EventRows) -> None:
    """Write the rows of tops that ran in lanes."""
    columns, lane, kept = measured.columns, tallies.lane[numbers], iter(tallies.kept[:, numbers])
    functions = tallies.functions[:, numbers]
    measured.status[numbers] = lane["status"]
    for name in ("t_end", "steps", *SWINGS):
        columns[name][numbers] = lane["t" if name == "t_end" else name]
    measured.settled[numbers] = ~slides(measured.tops, measured.final[:, numbers], numbers)
    for e, event in enumerate(measured.tops.base.system.events):
        lasts = np.ones(len(numbers), bool)
        if event.lasting:
            lasts = measured.settled[numbers] = measured.settled[numbers] & (
                event.direction * functions["sign"][e] > 0
            )
        for number in event.kept:  # NaN for the time of an event that did not last to the end
            values = next(kept)
            columns[number.name][numbers] = (
                values if number.what == "count" else np.where(lasts, values, np.nan)
            )
        if event.extremes:
            for end, values in zip(("min", "max"), functions["extremes"][e].T, strict=True):
                columns[f"{event.extremes}_{end}"][numbers] = values / rows.events["scale"][e]


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


@QUIET
def of_problem(
    base: Problem,
    variations: Mapping[str, Any],
    *,
    threads: int | None = None,
    progress: Report | bool = False,
    orientation: bool = False,
    lyapunov: bool = False,
) -> "xr.Dataset":
    """Return a Dataset with one row per top.

    The tops are a problem with other numbers, (n,) each, under dotted keys like `friction.mu`.

    Parameters
    ----------
    base
        The base of the tops.
    variations
        Arrays (n,) in SI units, under dotted keys.
    threads
        How many; by default one per usable core.
    progress
        Called as progress(done, of); True draws a bar.
    orientation
        Whether the orientation at the end is wanted.
    lyapunov
        Whether the finite-time Lyapunov exponents are wanted.

    Returns
    -------
    xarray.Dataset
        Dimension `top`, SI units.

    Raises
    ------
    InputError
        If the problem cannot run in lanes, or a key or a shape is wrong.

    Notes
    -----
    `progress(done, of)` counts tops; True draws a bar. Invalid tops are marked `invalid`; the
    attributes contain the faults of the first of them.
    """
    if lyapunov and (sentences := derivative_faults(base)):
        raise InputError(sentences)
    tops = vary(base, variations, orientation=orientation)
    with reporting(progress, "tops") as tell:
        measured = measure(tops, threads=threads, progress=tell, lyapunov=lyapunov)
        return dataset(measured)
