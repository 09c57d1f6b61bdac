"""Maps of a sweep: the fate of its tops over one or two of its axes, and the borders that theory
draws there.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import greek, units_text
from ..engine.settling import NEAR
from ..engine.status import Status
from ..ensembles.outcomes import CLASSES
from ..errors import InputError
from . import derived
from .design import Axis
from .plan import Plan
from .summary import column, open_sweep


MOST_CELLS = 1000  # along an axis of a map; more values share cells
POINTS = 121  # of a border, along each axis
TOPS_PER_CELL = 4  # where axes were drawn
LETTERS = {
    "mu": "μ",
    "eps": "ε",
    "theta": "θ",
    "omega3": "ω₃",
    "alpha": "α",
    "lambda": "λ",
    "sigma": "σ",
    "gamma": "γ",
}
"""Letters of the axes, where their names have none."""
NEEDED = {
    "class": ("class", "theta_end"),
    "inversion": ("inverted_at", "first_equator"),
    "normal-force": ("normal_force_min", "normal_force_max"),
    "lyapunov": ("lyapunov",),
}
"""What is mapped, and what is added to it where a sweep has but one axis."""
SHOWN = (*CLASSES, "near-upright")
"""The classes that a map tells apart: of the tops under way, those that have not left the upright
yet.
"""
ENDS = "class"
"""Beside `inversion`: the most frequent class in the cells without a time, NaN in the others."""


@dataclass(frozen=True)
class MapAxis:
    """An axis of a map: its key, label, and the edges of its cells, ascending."""

    key: str
    label: str
    edges: np.ndarray
    log: bool

    @property
    def centres(self) -> np.ndarray:
        """The middles of the cells."""
        a, b = self.edges[:-1], self.edges[1:]
        return np.sqrt(a * b) if self.log else (a + b) / 2

    @property
    def span(self) -> np.ndarray:
        """Evenly spread points across the axis."""
        first, last = self.edges[[0, -1]]
        return np.geomspace(first, last, POINTS) if self.log else np.linspace(first, last, POINTS)


@dataclass(frozen=True)
class Map:
    """Fields over cells, (x,) or (x, y): names -> array, NaN where there is nothing; borders: label
    -> function over the `span`s of the axes, zero at the border; `notes` say what is mapped of what
    the axes do not show.
    """

    kind: str
    title: str
    axes: tuple[MapAxis, ...]
    fields: dict[str, np.ndarray]
    borders: dict[str, np.ndarray]
    notes: list[str]
    classes: tuple[str, ...] = SHOWN  # the names of the field `class`


def make_map(path: Path, kind: str) -> Map:
    """A map of a stored sweep.

    Raises InputError: no such kind, or its column was not kept; StoreError.
    """
    if kind not in NEEDED:
        raise InputError(
            [f"the kind of figure must be one of {', '.join(NEEDED)} of a sweep, but is `{kind}`."]
        )
    table = open_sweep(path)
    plan = Plan.from_tables(table.attrs["plan"])
    if kind == "inversion" and _of_pegs(plan):
        raise InputError(
            [
                "the figure `inversion` must be of tops with alpha > 0: near theta = pi a peg "
                "is lowest."
            ]
        )
    varying = [axis for axis in plan.design.axes if axis.sampled or len(set(axis.values)) > 1] or [
        plan.design.axes[0]
    ]
    wanted = NEEDED[kind][:1] if len(varying) > 1 else NEEDED[kind]
    missing = [name for name in wanted if name not in table]
    if missing:
        raise InputError(
            [f"the figure `{kind}` must have {', '.join(missing)}, but the plan did not keep it."]
        )
    axes = tuple(map_axis(plan, axis, table[axis.key].attrs) for axis in varying[:2])
    numbers = plan.design.numbers(np.arange(plan.n))
    units = {axis.key: table[axis.key].attrs["units"] for axis in varying[2:]}
    chosen, notes = _slice(plan, varying[2:], numbers, units)
    chosen &= column(path, table, "status") != Status.TODO.code
    for axis in axes:
        chosen &= np.isfinite(numbers[axis.key])
    cells, shape = _cells(axes, numbers)[chosen], tuple(len(axis.edges) - 1 for axis in axes)
    fields = {}
    for name in wanted:
        values = shown_classes(path, table) if name == "class" else column(path, table, name)
        values = values / _weight(plan, numbers) if kind == "normal-force" else values
        fields[name] = _gathered(name, cells, values[chosen], math.prod(shape)).reshape(shape)
    if kind == "inversion" and "class" in table:
        ends = _gathered(
            "class", cells, shown_classes(path, table)[chosen], math.prod(shape)
        ).reshape(shape)
        fields[ENDS] = np.where(np.isnan(fields[wanted[0]]), ends, np.nan)
    if len(cells) and np.bincount(cells).max() > 1:
        how = {"class": "most frequent", "normal_force_min": "least"}.get(wanted[0], "median")
        notes.append(f"{how} of the tops in a cell")
    if table.attrs["status"] != "finished":
        notes.append("unfinished")
    title = table.attrs["title"].partition(": ")[2]
    return Map(kind, title, axes, fields, _borders(plan, axes, varying[2:]), notes)


def borders_of(
    plan: Plan, axes: tuple[MapAxis, ...], further: dict[str, float], every: int = 1
) -> dict[str, np.ndarray]:
    """log(|lambda|/threshold) over every so many-th point of the spans of axes, by what the
    threshold means; none where theory has none, or where it is on one side alone.

    Parameters
    ----------
    axes
        Those of a map.
    further
        The numbers of all other axes, by key.
    """
    borders = plan.base.system.borders
    if borders is None:
        return {}
    grids = np.meshgrid(*(axis.span[::every] for axis in axes), indexing="ij")
    shape = grids[0].shape
    numbers = {axis.key: grid.ravel() for axis, grid in zip(axes, grids, strict=True)}
    numbers |= {key: np.full(grids[0].size, value) for key, value in further.items()}
    with np.errstate(all="ignore"):
        columns = derived.resolved(plan.base, numbers)
        lam, b = np.abs(derived.jellett(plan.base, columns)), derived.body(plan.base, columns)
        limits = borders(b)
        ratios = {
            label: (np.log(lam / limit) + np.zeros(lam.shape)).reshape(shape)
            for label, limit in limits.items()
        }
        return {
            label: values
            for label, values in ratios.items()
            if (values < 0).any() and (values > 0).any()
        }


def _of_pegs(plan: Plan) -> bool:
    """Return whether the tops of a sweep have alpha < 0, which keeps its sign."""
    alpha = plan.columns(np.zeros(1, int)).get(
        "parameters.alpha", plan.base.parameters.get("alpha", 1)
    )
    return bool(np.any(np.less(alpha, 0)))


def shown_classes(path: Path, table: Any) -> np.ndarray:
    """The class of each top, as a number of SHOWN; without theta at the end, as it is stored.

    Raises StoreError.
    """
    classes = np.asarray(column(path, table, "class"), dtype=int)
    if "theta_end" not in table:
        return classes
    waits = (classes == CLASSES.index("under-way")) & (
        np.abs(column(path, table, "theta_end")) < NEAR
    )
    return np.where(waits, SHOWN.index("near-upright"), classes)


def map_axis(plan: Plan, axis: Axis, attrs: dict[str, Any]) -> MapAxis:
    """The cells of an axis: one for each of its numbers, or bins where they are too many or were
    drawn.
    """
    label = labelled(axis.key, attrs)
    values = (
        np.unique(np.array(axis.values)[np.isfinite(axis.values)])
        if axis.values
        else np.array(axis.between)
    )
    if not len(values):
        raise InputError([f"the figure must have numbers on `{axis.key}`, but there are none."])
    log = axis.log and values[0] > 0
    scaled = np.log(values) if log else values
    if axis.sampled:
        sampled = sum(a.sampled for a in plan.design.axes)
        edges = _bins(scaled, (plan.n / TOPS_PER_CELL) ** (1 / min(sampled, 2)))
    else:
        edges = _bins(scaled, MOST_CELLS) if len(values) > MOST_CELLS else _around(scaled)
    return MapAxis(axis.key, label, np.exp(edges) if log else edges, log)


def labelled(key: str, attrs: dict[str, Any]) -> str:
    """Name, symbol and unit of an axis."""
    words, symbol = (
        greek(attrs["long_name"]).partition(":")[0],
        LETTERS.get(key.rpartition(".")[2], ""),
    )
    if symbol and words.endswith(f" {key.rpartition('.')[2]}"):
        words = words.rpartition(" ")[0]
    name = words if not symbol or symbol in words else f"{words} {symbol}"
    return name if attrs["units"] == "1" else f"{name} ({units_text(attrs['units'])})"


def _bins(values: np.ndarray, count: float) -> np.ndarray:
    """Edges of about so many even bins from the first value to the last."""
    return np.linspace(values[0], values[-1], int(np.clip(count, 4, MOST_CELLS)) + 1)


def _around(values: np.ndarray) -> np.ndarray:
    """Edges of cells with one of the values in each."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middles = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middles[0]], middles, [2 * values[-1] - middles[-1]]])


def _cells(axes: tuple[MapAxis, ...], numbers: dict[str, np.ndarray]) -> np.ndarray:
    """The cell of every top, the last axis fastest."""
    cells = np.zeros(1, int)
    for axis in axes:
        cells = cells * (len(axis.edges) - 1) + np.searchsorted(
            axis.edges[1:-1], numbers[axis.key], side="right"
        )
    return cells


def _slice(
    plan: Plan, others: list[Axis], numbers: dict[str, np.ndarray], units: dict[str, str]
) -> tuple[np.ndarray, list[str]]:
    """Which tops are mapped, and what that means: of further axes of the grid the middle number."""
    chosen, notes = np.ones(plan.n, bool), []
    for axis in others:
        table, _, name = axis.key.rpartition(".")
        symbol = (
            f"{LETTERS[name]}{'(0)' if table == 'initial' else ''}" if name in LETTERS else axis.key
        )
        if axis.sampled:
            notes.append(f"all {symbol}")
            continue
        middle = axis.values[len(axis.values) // 2]
        chosen &= numbers[axis.key] == middle
        unit = "" if units[axis.key] == "1" else f" {units_text(units[axis.key])}"
        notes.append(f"{symbol} = {middle:.4g}{unit} (one of {len(axis.values)})")
    return chosen, notes


def _gathered(name: str, cells: np.ndarray, values: np.ndarray, size: int) -> np.ndarray:
    """One number for each cell: the most frequent class, the least force, the median of anything
    else.
    """
    result = np.full(size, np.nan)
    counts = np.bincount(cells, minlength=size)
    if name == "class":
        each = np.bincount(cells * len(SHOWN) + values, minlength=size * len(SHOWN)).reshape(
            size, -1
        )
        return np.where(counts > 0, each.argmax(axis=1), np.nan)
    ranked = np.where(np.isnan(values), np.inf, values)  # what never happens comes last
    order = np.lexsort((ranked, cells))
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    filled = counts > 0
    rank = (
        0
        if name == "normal_force_min"
        else np.where(name == "normal_force_max", counts - 1, (counts - 1) // 2)
    )
    result[filled] = ranked[order[(first + rank)[filled]]]
    return np.where(np.isinf(result), np.nan, result)


def _weight(plan: Plan, numbers: dict[str, np.ndarray]) -> Any:
    """m g of the tops [N]."""
    b = derived.body(plan.base, derived.resolved(plan.base, numbers))
    return b.m * b.g


def _borders(plan: Plan, axes: tuple[MapAxis, ...], others: list[Axis]) -> dict[str, np.ndarray]:
    """The borders of a map; none where some of its tops have other numbers than its axes say."""
    if any(axis.sampled for axis in others):
        return {}
    keys = {axis.key for axis in axes}
    rest = [axis for axis in plan.design.axes if axis.key not in keys]
    return borders_of(plan, axes, {axis.key: axis.values[len(axis.values) // 2] for axis in rest})
