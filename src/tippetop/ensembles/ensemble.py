"""Many tops of one scenario, in memory: a Dataset with one row per top."""

import os
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.invariants import invariants, size
from ..engine.observables import values_of
from ..engine.status import Status
from ..errors import InputError
from ..mechanics.system import KINDS
from ..problem import Problem, Problems, variation_faults
from ..progress import reporting
from ..scenario import build
from . import observer
from .lanes import LANES, Lanes
from .outcomes import STATUSES, TIMES, Measured, _conclude, dataset


if TYPE_CHECKING:
    import xarray as xr


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


class _Worker(Lanes):
    """Lanes that write their lines into the common arrays."""

    def __init__(self, measured: Measured, starts: dict[str, np.ndarray], signs: tuple, lanes: int):
        super().__init__(measured.tops, lanes)
        self.measured, self.starts, self.signs = measured, starts, signs
        self.variables = len(measured.final)
        self.processor = 0.0

    def ready(self, top: int) -> tuple[np.ndarray, np.ndarray]:
        """Signs of the event functions of a top at its start."""
        return self.signs[0][top], self.signs[1][top]

    def look(self, states: np.ndarray, tops: np.ndarray) -> None:
        """Compares invariants with the start."""
        values = invariants(self.tops.base, values_of(self.tops, states[: self.variables], tops))
        for name, found in values.items():
            start = self.starts[name][tops]
            np.maximum.at(self.measured.drift[name], tops, np.abs(found - start) / size(start))

    def done(self, lane: int, status: Status) -> None:
        """Writes the line of a top that has ended."""
        measured, top, book = self.measured, self.top[lane], self.books[lane]
        measured.status[top] = STATUSES.index(status.value)
        measured.final[:, top] = self.final[lane, : self.variables]
        columns = measured.columns
        columns["t_end"][top] = self.end[lane] if status is Status.FINISHED else book["t"]
        columns["turnings"][top] = book["significant"]
        for name in (*TIMES, "equators", "theta_min", "theta_max", "steps"):
            columns[name][top] = book[name]
        columns["normal_force_min"][top] = book["force_min"]
        columns["normal_force_max"][top] = book["force_max"]
        measured.settled[top] = not book["positive"][KINDS.index("settled")]

    def finish_turning(self, lane: int) -> None:
        """The end may confirm the turning that waits."""
        x, y, z = self.final[lane, self.machine.rows[self.machine.sources.axis]]
        observer.confirm(self.books[lane], float(np.arctan2(np.sqrt(x * x + y * y), z)))


def measure(
    tops: Problems,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    lanes: int = LANES,
) -> Measured:
    """Integrates every valid top to its end; `progress(done, n)` is called now and then."""
    measured = Measured(tops)
    measured.status[~tops.valid] = STATUSES.index("invalid")
    everything = np.arange(tops.n)
    with np.errstate(all="ignore"):
        at_start = values_of(tops, tops.start, everything)
        starts = invariants(tops.base, at_start)
        functions = _event_functions(tops)
    signs = (functions > 0, np.abs(functions) < 1e-9)
    measured.drift = {name: np.where(tops.valid, 0.0, np.nan) for name in starts}
    waiting = tops.valid.copy()
    if tops.base.on_liftoff == "stop" and any(e.name == "liftoff" for e in tops.base.system.events):
        afloat = tops.valid & (functions[:, KINDS.index("liftoff")] < 0)
        measured.status[afloat] = STATUSES.index("liftoff")
        measured.columns["t_end"][afloat] = measured.columns["lifted_at"][afloat] = 0.0
        measured.final[:, afloat] = tops.start[:, afloat]
        waiting &= ~afloat
    numbers = np.flatnonzero(waiting)
    clock = time.perf_counter()
    if len(numbers):
        _run(measured, numbers, starts, signs, threads, progress, lanes)
    measured.seconds = time.perf_counter() - clock
    _conclude(measured)
    return measured


def _run(
    measured: Measured,
    numbers: np.ndarray,
    starts: dict[str, np.ndarray],
    signs: tuple,
    threads: int | None,
    progress: Callable[[int, int], None] | None,
    lanes: int,
) -> None:
    count = [0]
    lock = threading.Lock()
    queue = _Queue(numbers)
    workers = [
        _Worker(measured, starts, signs, lanes)
        for _ in range(max(1, min(threads or len(os.sched_getaffinity(0)), -(-len(numbers) // lanes))))
    ]

    def work(worker: _Worker) -> None:
        def done(lane: int, status: Status) -> None:
            worker.finish_turning(lane)
            worker.done(lane, status)
            if progress is not None:
                with lock:
                    count[0] += 1
                    progress(count[0], len(numbers))

        clock = time.thread_time()
        try:
            worker.run(queue, worker.ready, done)
            worker.processor = time.thread_time() - clock
        except BaseException:
            queue.stopped = True
            raise

    if len(workers) == 1:
        work(workers[0])
    else:
        with ThreadPoolExecutor(len(workers)) as pool:
            tasks = [pool.submit(work, worker) for worker in workers]
            try:
                for task in tasks:
                    task.result()
            except BaseException:  # Ctrl-C too: the others must not go on
                queue.stopped = True
                raise
    measured.processor = sum(worker.processor for worker in workers)
    measured.steps_made = sum(worker.tally.made for worker in workers)
    measured.steps_possible = sum(worker.tally.possible for worker in workers)


def _event_functions(tops: Problems) -> np.ndarray:
    """The event functions of every top at its start, (n, kinds), internal units; NaN where a system has none."""
    record, body = tops.record(tops.start), tops.internal_body
    scalars = tops.base.form.scalars(record, body)
    found = np.full((tops.n, len(KINDS)), np.nan)
    for event in tops.base.system.events:
        found[:, KINDS.index(event.name)] = event.formula(scalars, body)
    return found


def tops_of(source: str, variations: Mapping[str, Any], until: float | None) -> Problems:
    """The tops of a scenario and its variations. Raises InputError."""
    return varied(build.load(source, None, until), variations)


def varied(base: Problem, variations: Mapping[str, Any]) -> Problems:
    """The tops of a problem and its variations, for lanes. Raises InputError; `check` tells of single tops."""
    sentences = [*base_faults(base), *variation_faults(base, variations)]
    if sentences:
        raise InputError(sentences)
    return Problems.vary(base, variations)


def base_faults(base: Problem) -> list[str]:
    """Why a problem cannot run in lanes, in sentences; empty if it can."""
    sentences = []
    if not {"turning", "equator"} & {e.name for e in base.system.events} or "ux" not in base.form.units._fields:
        sentences.append('`form` must be "vector" in an ensemble, of a system that has it.')
    if base.precision != "double":
        sentences.append(f'`run.precision` must be "double" in an ensemble, but is "{base.precision}".')
    return sentences


def of_problem(
    base: Problem,
    variations: Mapping[str, Any],
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | bool = False,
) -> "xr.Dataset":
    """How each of many tops goes: a problem with other numbers, (n,) each, under dotted keys like `friction.mu`.

    `progress(done, of)` counts tops; True draws a bar. Invalid tops are marked `invalid`; what is wrong with the first
    of them stands in the attributes. Raises InputError if a key is wrong.
    """
    tops = varied(base, variations)
    with reporting(progress, "tops") as tell:
        return dataset(measure(tops, threads=threads, progress=tell), tops.check()[1])
