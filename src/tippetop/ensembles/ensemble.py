"""Many tops of one scenario, in memory: a Dataset with one row per top."""

import itertools
import os
import threading
import time
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.invariants import invariants, sizes
from ..engine.observables import values_of
from ..engine.observer import take_turning
from ..engine.slices import event_functions, signs_of
from ..engine.status import Status
from ..engine.tallies import LEAST, MOST, SIGN
from ..errors import InputError
from ..problem import Problem, Problems, variation_faults
from ..progress import reporting
from ..scenario import build
from .lanes import LANES, Lanes
from .outcomes import Outcomes, _conclude, dataset
from .singly import Alone, one_by_one


if TYPE_CHECKING:
    import xarray as xr


Starts = dict[str, tuple[np.ndarray, np.ndarray]]  # of invariants by name: at the start, what drifts are relative to


class _Queue:
    """Numbers of tops, each given to one thread."""

    def __init__(self, numbers: np.ndarray):
        self._numbers, self._lock, self.stopped = iter(numbers.tolist()), threading.Lock(), False

    def __iter__(self) -> "_Queue":
        return self

    def __next__(self) -> int:
        with self._lock:
            if self.stopped:
                raise StopIteration
            return next(self._numbers)


class _Worker:
    """A thread's lanes, and the observer that writes the rows of their tops into the common arrays."""

    def __init__(
        self,
        outcomes: Outcomes,
        starts: Starts,
        functions: np.ndarray,
        size: int,
        ended: Callable[[], None],
        wanted: Collection[str] | None,
    ):
        self.outcomes, self.starts, self.ended = outcomes, starts, ended
        self.signs, self.on_zero = signs_of(functions)
        self.lanes = lanes = Lanes(outcomes.tops, size, wanted)
        self.variables, self.processor, self.axis = len(outcomes.final), 0.0, lanes.rows.axis.tolist()
        columns, events = outcomes.columns, outcomes.tops.base.system.events
        self.lasting = [(e, event.direction) for e, event in enumerate(events) if event.lasting]
        kept = [
            (e if event.lasting and k.what != "count" else -1, k) for e, event in enumerate(events) for k in event.kept
        ]
        self.kept = [(columns[k.name], m, e) for m, (e, k) in enumerate(kept)]
        self.extremes = [
            (columns[f"{event.extremes}_{end}"], what, e, float(lanes.rows.events["scale"][e]))
            for e, event in enumerate(events)
            for end, what in (("min", LEAST), ("max", MOST))
            if event.extremes
        ]

    def ready(self, top: int) -> tuple[np.ndarray, np.ndarray]:
        """Signs of the event functions of a top at its start, and which of them are on their zero."""
        return self.signs[top], self.on_zero[top]

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Compares invariants with the start."""
        every = self.outcomes.tops
        values = invariants(every.base, values_of(every, states[: self.variables], tops))
        for name, value in values.items():
            start, size = self.starts[name]
            with np.errstate(all="ignore"):  # a top that is not finite has a drift that is none
                np.maximum.at(self.outcomes.drift[name], tops, np.abs(value - start[tops]) / size[tops])

    def done(self, lane: int, status: Status) -> None:
        """Writes the row of a top that has ended. The end may confirm the turning that waits."""
        lanes, outcomes, columns = self.lanes, self.outcomes, self.outcomes.columns
        top, record, final = lanes.top[lane], lanes.tallies.lane, lanes.final[lane].tolist()
        functions, kept = lanes.tallies.functions[:, :, lane].tolist(), lanes.tallies.kept[:, lane].tolist()
        tally = SimpleNamespace(**dict(zip(record.dtype.names, record[lane].item(), strict=True)))
        x, y, z = (final[i] for i in self.axis)
        take_turning.py_func(tally, 0, float(np.arctan2(np.sqrt(x * x + y * y), z)))
        outcomes.status[top] = status.code
        outcomes.final[:, top] = final[: self.variables]
        columns["t_end"][top] = lanes.motion.end[lane] if status is Status.FINISHED else tally.t
        for name in ("turnings", "theta_min", "theta_max", "steps"):
            columns[name][top] = getattr(tally, name)
        passed = {e for e, direction in self.lasting if not direction * functions[SIGN][e] > 0}
        for column, m, lasting in self.kept:  # a time of what did not last to the end is none
            column[top] = np.nan if lasting in passed else kept[m]
        for column, what, e, scale in self.extremes:
            column[top] = functions[what][e] / scale
        outcomes.settled[top] = not passed
        self.ended()

    def work(self, queue: "_Queue") -> None:
        """Runs tops from the queue until there is none left."""
        clock = time.thread_time()
        try:
            self.lanes.run(queue, self)
            self.processor = time.thread_time() - clock
        except BaseException:
            queue.stopped = True
            raise


def measure(
    tops: Problems,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    lanes: int = LANES,
    wanted: Collection[str] | None = None,
    alone: Alone | None = None,
) -> Outcomes:
    """Integrates every valid top to its end; `progress(done, n)` is called now and then.

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
        Names of the columns that somebody reads, None: all. The others may be empty; these have the same bits.
    alone
        What runs one top whose contact may change its phase: lanes cannot.

    Returns
    -------
    Outcomes
        A row per top; invalid ones have the status `invalid`.
    """
    measured = Outcomes(tops)
    measured.status[~tops.valid] = Status.INVALID.code
    everything = np.arange(tops.n)
    with np.errstate(all="ignore"):
        at_start = values_of(tops, tops.start, everything)
        relative_to = sizes(tops.base, at_start)
        starts = {name: (value, relative_to[name]) for name, value in invariants(tops.base, at_start).items()}
        functions = event_functions(tops)
    measured.drift = {name: np.where(tops.valid, 0.0, np.nan) for name in starts}
    numbers = np.flatnonzero(tops.valid & ~_ended_at_start(measured, functions))
    clock = time.perf_counter()
    if len(numbers) and tops.base.contact is not None:
        if alone is None:
            raise ValueError("a contact that may change its phase is followed by a driver of its own")
        one_by_one(measured, numbers, alone, progress)
    elif len(numbers):
        _run(measured, numbers, starts, functions, threads, progress, lanes, wanted)
    measured.seconds = time.perf_counter() - clock
    _conclude(measured)
    return measured


def _ended_at_start(measured: Outcomes, functions: np.ndarray) -> np.ndarray:
    """Which tops end before their first step, (n,): an event function that must not fall below zero has done so."""
    tops, ended = measured.tops, np.zeros(measured.tops.n, bool)
    for e, event in enumerate(tops.base.system.events):
        if tops.base.on_liftoff == "stop" and event.ends and event.extremes:
            below = tops.valid & ~ended & (functions[:, e] < 0)
            measured.status[below] = Status.of_event(event.ends).code
            for name in ("t_end", *(kept.name for kept in event.kept if kept.what != "count")):
                measured.columns[name][below] = 0.0
            measured.final[:, below] = tops.start[:, below]
            ended |= below
    return ended


def _run(
    measured: Outcomes,
    numbers: np.ndarray,
    starts: Starts,
    functions: np.ndarray,
    threads: int | None,
    progress: Callable[[int, int], None] | None,
    lanes: int,
    wanted: Collection[str] | None,
) -> None:
    queue, lock, counted = _Queue(numbers), threading.Lock(), itertools.count(1)

    def ended() -> None:
        if progress is not None:
            with lock:
                progress(next(counted), len(numbers))

    workers = [
        _Worker(measured, starts, functions, lanes, ended, wanted)
        for _ in range(max(1, min(threads or len(os.sched_getaffinity(0)), -(-len(numbers) // lanes))))
    ]
    if len(workers) == 1:
        workers[0].work(queue)
    else:
        with ThreadPoolExecutor(len(workers)) as pool:
            tasks = [pool.submit(worker.work, queue) for worker in workers]
            try:
                for task in tasks:
                    task.result()
            except BaseException:  # Ctrl-C too: the others must stop
                queue.stopped = True
                raise
    if any(worker.lanes.machine is None for worker in workers):
        measured.steps_by = "heyoka"
    measured.processor = sum(worker.processor for worker in workers)
    measured.steps_made = sum(worker.lanes.steps_made for worker in workers)
    measured.steps_possible = sum(worker.lanes.steps_possible for worker in workers)


def tops_of(source: str, variations: Mapping[str, Any], until: float | None) -> Problems:
    """The tops of a scenario and its variations. Raises InputError."""
    return vary(build.load(source, None, until), variations)


def vary(base: Problem, variations: Mapping[str, Any], *, orientation: bool = False) -> Problems:
    """The tops of a problem and its variations, for lanes.

    Parameters
    ----------
    base
        What they have in common.
    variations
        Arrays (n,) in SI units, under dotted keys like `friction.mu`.
    orientation
        Whether the orientation of the bodies is integrated too.

    Returns
    -------
    Problems
        Its `check` says which tops are invalid, and why.

    Raises
    ------
    InputError
        If the problem cannot run in lanes, or a key or a shape is wrong.
    """
    sentences = [*base_faults(base), *variation_faults(base, variations)]
    if orientation and base.form.orientation is None:
        sentences.append("`orientation` must be false, of a form that does not know it.")
    if sentences:
        raise InputError(sentences)
    return Problems.vary(base, variations, orientation)


def base_faults(base: Problem) -> list[str]:
    """Why a problem cannot run in lanes, in sentences; empty if it can.

    Parameters
    ----------
    base
        What the tops have in common.

    Returns
    -------
    list of str
        Sentences; lanes need the vector form and doubles.
    """
    sentences = []
    if not base.system.events or "ux" not in base.form.units._fields:
        sentences.append('`form` must be "vector" or "contact" in an ensemble, of a system that has it.')
    if base.precision != "double":
        sentences.append(f'`run.precision` must be "double" in an ensemble, but is "{base.precision}".')
    return sentences


def of_problem(
    base: Problem,
    variations: Mapping[str, Any],
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | bool = False,
    orientation: bool = False,
    alone: Alone | None = None,
) -> "xr.Dataset":
    """How each of many tops goes: a problem with other numbers, (n,) each, under dotted keys like `friction.mu`.

    Parameters
    ----------
    base
        What the tops have in common.
    variations
        Arrays (n,) in SI units, under dotted keys.
    threads
        How many; by default one per usable core.
    progress
        Called as progress(done, of); True draws a bar.
    orientation
        Whether the orientation at the end is wanted.
    alone
        What runs one top whose contact may change its phase.

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
    `progress(done, of)` counts tops; True draws a bar. Invalid tops are marked `invalid`; what is wrong with the first
    of them stands in the attributes. Raises InputError if a key is wrong.
    """
    tops = vary(base, variations, orientation=orientation)
    with reporting(progress, "tops") as tell:
        measured = measure(tops, threads=threads, progress=tell, alone=alone)
        return dataset(measured, [*tops.check()[1], *measured.faults])
