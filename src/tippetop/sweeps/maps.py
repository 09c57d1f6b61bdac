"""Maps of a sweep: the fate of its tops over one or two axes, and the borders of theory.

The store of a sweep goes in; a `Map` comes out, which `figures.sweep_map` draws.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays, greek, units_text
from ..engine.settling import NEAR
from ..engine.status import Status
from ..ensembles.outcomes import CLASSES
from ..errors import InputError
from ..store.root import column
from . import derived_axes
from .design import Axis
from .plan import Plan
from .sweep_summary import open_sweep, plan_of


POINTS = 121  # of a border, along each axis
CELLS, TOPS_PER_CELL = (4, 1000), 4  # along an axis that was drawn
# the columns of a figure: the first is mapped, the others are added where a sweep has one axis
NEEDED = {
    "class": ("class", "theta_end"),
    "inversion": ("inverted_at", "first_equator"),
    "normal-force": ("normal_force_min", "normal_force_max"),
    "lyapunov": ("lyapunov",),
}
# the classes of a map, after the stored ones: tops under way that are still upright are apart
SHOWN = (*CLASSES, "near-upright")


@dataclass(frozen=True)
class MapAxis:
    """An axis of a map: its key, label, and the edges of its cells, ascending."""

    of: str
    label: str
    edges: np.ndarray
    log: bool

    @property
    def centres(self) -> np.ndarray:
        """The middles of the cells."""
        a = self.edges[:-1]
        b = self.edges[1:]
        return np.sqrt(a * b) if self.log else (a + b) / 2

    @property
    def span(self) -> np.ndarray:
        """Evenly spread points across the axis."""
        first, last = self.edges[[0, -1]]
        return np.geomspace(first, last, POINTS) if self.log else np.linspace(first, last, POINTS)


@dataclass(frozen=True)
class Map:
    """Fields over cells by column, (x,) or (x, y), NaN in cells without a value.

    `kind` is a key of NEEDED. The field `class` has indices of `classes`.
    With `inversion`, the field `class` is the most frequent class in the cells without a time.
    `borders`: label -> function over the `span`s of the axes, zero at the border.
    `notes` list what the axes do not show.
    """

    kind: str
    title: str
    axes: tuple[MapAxis, ...]
    fields: Arrays
    borders: Arrays
    notes: list[str]
    classes: tuple[str, ...] = SHOWN  # the names of the field `class`


def make_map(path: Path, kind: str) -> Map:
    """Return a map of a stored sweep.

    Raises InputError for an unknown kind, or one whose column was not kept; StoreError.
    """
    table = open_sweep(path)
    plan = plan_of(table)
    numbers = plan.design.numbers(np.arange(plan.n))
    columns = derived_axes.resolved(plan.base, numbers)
    # 1: a system without `alpha` has no pegs
    alpha = columns.get("parameters.alpha", plan.base.parameters.get("alpha", 1))
    if kind == "inversion" and np.any(np.less(alpha, 0)):
        raise InputError(
            "the figure `inversion` must be of tops with alpha > 0: near theta = pi a peg "
            "is lowest."
        )
    several = [axis for axis in plan.design.axes if axis.varies]
    varying = several or [plan.design.axes[0]]
    wanted = NEEDED[kind][:1] if len(varying) > 1 else NEEDED[kind]
    if missing := [name for name in wanted if name not in table]:
        raise InputError(
            f"the figure `{kind}` must have {', '.join(missing)}, but the plan did not keep it."
        )
    axes = tuple(map_axis(plan, axis, table[axis.of].attrs) for axis in varying[:2])
    chosen = column(path, table, "status") != Status.TODO.code
    notes = []
    for axis in varying[2:]:  # the middle number of further axes is shown
        if axis.sampled:
            notes.append(f"all {greek(axis.of)}")
            continue
        chosen &= numbers[axis.of] == _middle(axis)
        units = units_text(table[axis.of].attrs["units"]).replace("1", "")  # a pure number
        number = f"{_middle(axis):.4g} {units}".rstrip()
        notes.append(f"{greek(axis.of)} = {number} (one of {len(axis.numbers)})")
    for axis in varying[:2]:
        chosen &= np.isfinite(numbers[axis.of])
    shape = tuple(len(axis.edges) - 1 for axis in axes)
    # of each top, the number of its cell along each axis
    places = [np.searchsorted(a.edges[1:-1], numbers[a.of], side="right") for a in axes]
    cells = np.ravel_multi_index(places, shape)[chosen]

    def field(name: str) -> np.ndarray:
        """Return the values of a column on the cells of the map, as of `Map.fields`.

        A normal force is in units of the weight.
        """
        values = values_of(path, table, name)
        if kind == "normal-force":
            b = derived_axes.body(plan.base, columns)
            values = values / (b.m * b.g)
        return _gathered(name, cells, values[chosen], shape)

    fields = {name: field(name) for name in wanted}
    if kind == "inversion" and "class" in table:
        fields["class"] = np.where(np.isnan(fields[wanted[0]]), field("class"), np.nan)
    if len(cells) and np.bincount(cells).max() > 1:
        how = {"class": "most frequent", "normal_force_min": "least"}.get(wanted[0], "median")
        notes.append(f"{how} of the tops in a cell")
    if table.attrs["status"] != "finished":
        notes.append("unfinished")
    borders = {}  # none where the tops of a cell have other numbers than its axes
    if not any(axis.sampled for axis in varying[2:]):
        rest = [axis for axis in plan.design.axes if axis not in varying[:2]]
        borders = borders_of(plan, axes, {axis.of: _middle(axis) for axis in rest})
    return Map(kind, plan.base.system.title, axes, fields, borders, notes)


def borders_of(
    plan: Plan, axes: tuple[MapAxis, ...], further: dict[str, float], every: int = 1
) -> Arrays:
    """Return log(|lambda|/threshold) over the spans of axes, by the label of the threshold.

    It is 0 at the border; a threshold that is on one side of all points is left out. `make_map`
    calls it for a figure, `views.borders` for a page.

    Parameters
    ----------
    plan
        The plan of the sweep.
    axes
        Those of a map.
    further
        The numbers of all other axes, by key.
    every
        Take every n-th point of the spans.
    """
    borders = plan.base.system.borders
    if borders is None:
        return {}
    grids = np.meshgrid(*(axis.span[::every] for axis in axes), indexing="ij")
    numbers = {axis.of: grid.ravel() for axis, grid in zip(axes, grids, strict=True)}
    numbers |= {key: np.full(grids[0].size, value) for key, value in further.items()}
    with np.errstate(all="ignore"):
        columns = derived_axes.resolved(plan.base, numbers)
        lam = np.abs(derived_axes.jellett(plan.base, columns))
        ratios = {
            label: (np.log(lam / limit) + np.zeros(lam.shape)).reshape(grids[0].shape)
            for label, limit in borders(derived_axes.body(plan.base, columns)).items()
        }
        return {label: v for label, v in ratios.items() if (v < 0).any() and (v > 0).any()}


def values_of(path: Path, table: Any, name: str) -> np.ndarray:
    """Return a column of all tops; `class` as indices of SHOWN. Raises StoreError."""
    values = column(path, table, name)
    if name != "class" or "theta_end" not in table:
        return values
    near = np.abs(column(path, table, "theta_end")) < NEAR
    waits = (values == CLASSES.index("under-way")) & near
    return np.where(waits, SHOWN.index("near-upright"), values)


def map_axis(plan: Plan, axis: Axis, attrs: PlainData) -> MapAxis:
    """Return the cells of an axis: one for each number, or bins of drawn numbers.

    `attrs` are the attributes of its column, with its name in words and its unit. Edges ascend, as
    `make_map` searches numbers in them. Raises InputError.
    """
    given = axis.numbers or axis.between or ()
    values = np.unique([v for v in given if np.isfinite(v)])
    if not len(values):
        raise InputError(f"the figure must have numbers on `{axis.of}`, but there are none.")
    log = axis.is_log and values[0] > 0
    scaled = np.log(values) if log else values
    if axis.sampled:
        drawn = sum(a.sampled for a in plan.design.axes)
        count = (plan.n / TOPS_PER_CELL) ** (1 / min(drawn, 2))  # a map has two axes at most
        edges = np.linspace(scaled[0], scaled[-1], int(np.clip(count, *CELLS)) + 1)
    elif len(values) == 1:
        edges = scaled[0] + np.array([-0.5, 0.5])
    else:
        middles = (scaled[1:] + scaled[:-1]) / 2
        edges = np.r_[2 * scaled[0] - middles[0], middles, 2 * scaled[-1] - middles[-1]]
    return MapAxis(axis.of, labelled(attrs), np.exp(edges) if log else edges, log)


def labelled(attrs: PlainData) -> str:
    """Return name and unit of an axis as a label, from the attributes of its column."""
    words = greek(attrs["long_name"]).partition(":")[0]
    return words if attrs["units"] == "1" else f"{words} ({units_text(attrs['units'])})"


def _middle(axis: Axis) -> float:
    """Return the middle one of the numbers of an axis."""
    return axis.numbers[len(axis.numbers) // 2]


def _gathered(
    name: str, cells: np.ndarray, values: np.ndarray, shape: tuple[int, ...]
) -> np.ndarray:
    """Return the most frequent class, the extreme force, or the median in each cell.

    Parameters
    ----------
    name
        The column, which decides among the three.
    cells
        The number of the cell of each value, (k,).
    values
        (k,); NaN is left out.
    shape
        That of the cells, in which the result is returned; NaN in cells without a value.
    """
    import pandas as pd

    result = np.full(math.prod(shape), np.nan)
    if name == "class":
        each = pd.crosstab(cells, values).idxmax(axis=1)
    else:  # an event that never happens comes last; "lower": the value of a top, no mean with inf
        groups = pd.Series(np.where(np.isnan(values), np.inf, values)).groupby(cells)
        least_or_most = {"normal_force_min": groups.min, "normal_force_max": groups.max}
        each = least_or_most.get(name, lambda: groups.quantile(0.5, interpolation="lower"))()
    result[each.index] = each.replace(np.inf, np.nan)
    return result.reshape(shape)
