"""Many tops of one scenario, in memory: a Dataset with a line per top on how it went."""

import os
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from . import ledger, scenario
from .bar import shown
from .batch import LANES, Lanes
from .engine import Status
from .events import KINDS
from .monitor import invariants, size
from .problem import Problem
from .scenario import ScenarioError
from .system import NEWTON, ONE, RADIAN, SECOND, Unit
from .tops import Tops, known
from .trajectory import Column


if TYPE_CHECKING:
    import xarray as xr

STATUSES = ("todo", "finished", "liftoff", "fallen", "settled", "non-finite", "stalled", "invalid")
CLASSES = ("none", "upright", "tumbling", "inverted", "lifted-off", "under-way")
NEAR = 0.1  # rad from a pole: upright or inverted

TIMES = {
    "first_equator": "first passage of theta = pi/2; NaN: none",
    "last_equator": "last passage of theta = pi/2; NaN: none",
    "inverted_at": "theta first rises through pi - 0.1; NaN: never",
    "lifted_at": "the normal force first falls to zero; NaN: never",
    "settled_at": "sliding last died out; NaN: never",
}
COLUMNS: dict[str, tuple[Any, Unit, str]] = {
    "t_end": (np.float64, SECOND, "end of the run"),
    "theta_end": (np.float64, RADIAN, "inclination at the end"),
    **{name: (np.float64, SECOND, text) for name, text in TIMES.items()},
    "equators": (np.int32, ONE, "passages of theta = pi/2"),
    "turnings": (np.int32, ONE, "turning angles that are more than rounding"),
    "theta_min": (np.float64, RADIAN, "lowest turning angle"),
    "theta_max": (np.float64, RADIAN, "highest turning angle"),
    "normal_force_min": (np.float64, NEWTON, "least normal force"),
    "normal_force_max": (np.float64, NEWTON, "greatest normal force"),
    "steps": (np.int32, ONE, "steps of the integrator"),
}


class Measured:
    """A line per top, as arrays; and what the making took."""

    def __init__(self, tops: Tops):
        self.tops, n = tops, tops.n
        self.status = np.zeros(n, np.int8)
        self.kind = np.zeros(n, np.int8)
        self.columns = {
            name: np.full(n, np.nan) if dtype is np.float64 else np.zeros(n, dtype)
            for name, (dtype, _, _) in COLUMNS.items()
        }
        self.final = np.full((len(tops.start), n), np.nan)
        self.settled = np.zeros(n, bool)
        self.drift: dict[str, np.ndarray] = {}
        self.steps_made = self.steps_possible = 0
        self.seconds = self.processor = 0.0  # by the wall clock, and by the clocks of the threads

    @property
    def occupancy(self) -> float:
        """Steps that tops made, over the steps that the lanes could have made."""
        return self.steps_made / max(1, self.steps_possible)


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
        values = invariants(self.tops.base, self.tops.values(states[: self.variables], tops))
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
        ledger.confirm(self.books[lane], float(np.arctan2(np.sqrt(x * x + y * y), z)))


def measure(
    tops: Tops, *, threads: int | None = None, progress: Callable[[int, int], None] | None = None, lanes: int = LANES
) -> Measured:
    """Integrates every valid top to its end; `progress(done, n)` is called now and then."""
    measured = Measured(tops)
    measured.status[~tops.valid] = STATUSES.index("invalid")
    everything = np.arange(tops.n)
    with np.errstate(all="ignore"):
        at_start = tops.values(tops.start, everything)
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


def _event_functions(tops: Tops) -> np.ndarray:
    """The event functions of every top at its start, (n, kinds), internal units; NaN where a system has none."""
    record, body = tops.record(tops.start), tops.internal_body
    scalars = tops.base.form.scalars(record, body)
    found = np.full((tops.n, len(KINDS)), np.nan)
    for event in tops.base.system.events:
        found[:, KINDS.index(event.name)] = event.formula(scalars, body)
    return found


def _conclude(measured: Measured) -> None:
    """What follows from the ends: SI units, theta at the end, the class."""
    tops, columns = measured.tops, measured.columns
    for name, (_, unit, _) in COLUMNS.items():
        if unit in (SECOND, NEWTON):
            columns[name] *= tops.unit(unit)
    for name in ("normal_force_min", "normal_force_max"):
        columns[name][~np.isfinite(columns[name])] = np.nan
    ended = np.isfinite(measured.final).all(axis=0)
    theta = columns["theta_end"]
    theta[ended] = tops.values(measured.final[:, ended], np.flatnonzero(ended))["theta"]
    kind = np.full(tops.n, CLASSES.index("under-way"))
    kind[measured.settled] = CLASSES.index("tumbling")
    kind[theta < NEAR] = CLASSES.index("upright")
    kind[theta > np.pi - NEAR] = CLASSES.index("inverted")
    kind[np.isfinite(columns["lifted_at"])] = CLASSES.index("lifted-off")
    sound = np.isin(measured.status, [STATUSES.index(s) for s in ("finished", "liftoff", "fallen", "settled")])
    measured.kind[:] = np.where(sound, kind, CLASSES.index("none"))


def tops_of(source: str, variations: Mapping[str, Any], until: float | None) -> tuple[Tops, list[tuple[int, str]]]:
    """The checked tops of a scenario and its variations, and what is wrong with single ones. Raises ScenarioError."""
    return varied(scenario.load(source, None, until), variations)


def varied(base: Problem, variations: Mapping[str, Any]) -> tuple[Tops, list[tuple[int, str]]]:
    """The checked tops of a problem and its variations, and what is wrong with single ones. Raises ScenarioError."""
    sentences = []
    if not {"turning", "equator"} & {e.name for e in base.system.events} or "ux" not in base.form.units._fields:
        sentences.append('`form` must be "vector" in an ensemble, of a system that has it.')
    if base.precision != "double":
        sentences.append(f'`run.precision` must be "double" in an ensemble, but is "{base.precision}".')
    rules = known(base)
    columns = {}
    for key, values in variations.items():
        if key not in rules:
            sentences.append(f"`{key}` must be one of {', '.join(rules)}, but is not.")
            continue
        columns[key] = np.array(values, dtype=float)
    if not columns and not sentences:
        sentences.append("`variations` must vary something, but is empty.")
    if len({c.shape for c in columns.values()}) > 1 or any(c.ndim != 1 or not c.size for c in columns.values()):
        found = ", ".join(f"{key} {c.shape}" for key, c in columns.items())
        sentences.append(f"`variations` must be arrays of one length and dimension, but are {found}.")
    if {"initial.psi_dot", "initial.omega3"} <= columns.keys():
        sentences.append("`initial.psi_dot` must vary alone, but `initial.omega3` varies too.")
    if base.initial.get("centre_at_rest") and {"initial.nu_x", "initial.nu_y"} & columns.keys():
        sentences.append("`initial.centre_at_rest` must stand alone, but `initial.nu_x` or `initial.nu_y` varies.")
    if sentences:
        raise ScenarioError(sentences)
    tops = Tops(base, columns)
    return tops, tops.faults()


def ensemble(
    source: str,
    variations: Mapping[str, Any],
    *,
    until: float | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], None] | bool = False,
) -> "xr.Dataset":
    """How each of many tops goes: a scenario with other numbers, (n,) each, under dotted keys like `friction.mu`.

    `progress(done, of)` counts tops; True draws a bar.
    Tops that cannot be are marked `invalid`; what is wrong with the first of them stands in the attributes. Raises
    ScenarioError if the scenario or a key is wrong.
    """
    tops, faults = tops_of(source, variations, until)
    with shown(progress, "tops") as tell:
        return dataset(measure(tops, threads=threads, progress=tell), faults)


def dataset(measured: Measured, faults: list[tuple[int, str]]) -> "xr.Dataset":
    """The lines as a labelled Dataset, dimension `top`."""
    import xarray as xr

    found, tops = table(measured), measured.tops
    rules = known(tops.base)
    coords = {
        key: ("top", column, {"units": rules[key].unit.symbol, "long_name": rules[key].long_name})
        for key, column in tops.columns.items()
    }
    attrs = {
        "title": tops.base.system.title,
        **scenario.resolved(tops.base),
        "occupancy": measured.occupancy,
        "seconds": measured.seconds,
        "processor_seconds": measured.processor,
        "faults": [f"top {i}: {sentence}" for i, sentence in faults[:20]],
    }
    return xr.Dataset(found, coords, attrs)


def table(measured: Measured) -> dict[str, Column]:
    """The lines as columns along `top`, by name."""
    found: dict[str, Column] = {
        "status": Column(("top",), measured.status, _flags(STATUSES, "how the run ended")),
        "class": Column(("top",), measured.kind, _flags(CLASSES, "what became of the top")),
    }
    for name, (_, unit, text) in COLUMNS.items():
        found[name] = Column(("top",), measured.columns[name], {"units": unit.symbol, "long_name": text})
    for name, worst in measured.drift.items():
        found[f"drift_{name}"] = Column(("top",), worst, {"units": "1", "long_name": f"worst relative drift: {name}"})
    return found


def _flags(names: tuple[str, ...], text: str) -> dict[str, Any]:
    return {"flag_values": list(range(len(names))), "flag_meanings": " ".join(names), "long_name": text, "units": "1"}
