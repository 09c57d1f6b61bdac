"""Thresholds as lines over the map of a page: where they run, for each choice of the further axes."""

import itertools
from collections import defaultdict
from typing import Any

import numpy as np

from ..sweeps import maps
from ..sweeps.design import Axis
from ..sweeps.plan import Plan
from .given import encoded


EVERY = 3  # of the points that a figure takes: lines on a page are a few hundred pixels long
MOST = 400  # choices of further axes; each takes 20 ms and some kilobytes


def borders(plan: Plan, axes: list[Axis], table: Any) -> dict[str, Any]:
    """The lines of a map, as the page takes them.

    Parameters
    ----------
    plan
        Of the sweep.
    axes
        As the page has them: the first two are drawn, the others are chosen by sliders.
    table
        Of the sweep.

    Returns
    -------
    dict
        `labels` of the thresholds, and for each choice of the further axes, the last fastest, `lines`: numbers x, y, x,
        y ... for each label, NaN between two lines; y is -inf and inf where there is one axis.
    """
    plane = [axis for axis in axes[:2] if axis.sampled or len(set(axis.values)) > 1]
    rest = [axis for axis in axes if axis not in plane]
    choices = [np.unique([v for v in axis.values if np.isfinite(v)]) for axis in axes[2:]]
    nothing: dict[str, Any] = {"labels": [], "lines": []}
    if not plane or any(axis.sampled for axis in rest) or np.prod([len(c) for c in choices], dtype=float) > MOST:
        return nothing
    spread = tuple(maps.map_axis(plan, axis, table[axis.key].attrs) for axis in plane)
    fixed = {axis.key: axis.values[0] for axis in rest}
    further = [axis.key for axis in axes[2:]]
    ratios = [
        maps.borders_of(plan, spread, fixed | dict(zip(further, numbers, strict=True)), EVERY)
        for numbers in itertools.product(*choices)
    ]
    labels = list(dict.fromkeys(label for each in ratios for label in each))
    places = [axis.span[::EVERY] for axis in spread]
    lines = [
        [encoded(_lines(places, each[label]), "<f4") if label in each else "" for label in labels] for each in ratios
    ]
    return {"labels": labels, "lines": lines}


def _lines(places: list[np.ndarray], logarithms: np.ndarray) -> np.ndarray:
    """Where the logarithms of ratios over one or two axes are zero, (n, 2)."""
    values = np.expm1(logarithms)  # |lambda|/threshold - 1 is linear in a spin
    if len(places) == 1:
        at = np.flatnonzero((values[1:] > 0) != (values[:-1] > 0))
        at = at[np.isfinite(values[at]) & np.isfinite(values[at + 1])]
        part = at + values[at] / (values[at] - values[at + 1])
        paths = [np.array([[x, -np.inf], [x, np.inf]]) for x in _placed(places[0], part)]
    else:
        paths = [
            np.stack([_placed(p, line[:, i]) for i, p in enumerate(places)], axis=1) for line in zero_lines(values)
        ]
    gap = np.full((1, 2), np.nan)
    return np.concatenate([piece for line in paths for piece in (line, gap)] or [gap])


def _placed(points: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The numbers of an axis between its points."""
    return np.interp(at, np.arange(len(points)), points)


def zero_lines(values: np.ndarray) -> list[np.ndarray]:
    """The lines on which a function over a grid is zero, as points in steps of the grid, (n, 2): every cell is cut into
    two triangles, in which it is linear. They end where the function is no number."""
    n, m = values.shape
    corners = np.stack([*np.meshgrid(np.arange(n), np.arange(m), indexing="ij"), values], axis=-1)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    triangles = np.concatenate([np.stack(three, axis=2).reshape(-1, 3, 3) for three in ((a, b, c), (a, c, d))])
    above = triangles[..., 2] > 0
    count = above.sum(axis=1)
    cut = (count > 0) & (count < 3) & np.isfinite(triangles[..., 2]).all(axis=1)
    triangles, above, count = triangles[cut], above[cut], count[cut]
    alone = np.argmax(above == (count == 1)[:, None], axis=1)  # the corner on its side of the line
    first, *others = (triangles[np.arange(len(alone)), (alone + k) % 3] for k in range(3))
    ends = [first + (first[:, 2:] / (first[:, 2:] - other[:, 2:])) * (other - first) for other in others]
    return joined(np.round(np.stack(ends, axis=1)[..., :2], 9))


def joined(segments: np.ndarray) -> list[np.ndarray]:
    """Segments (n, 2, 2) with common ends as lines, so that a dashed stroke runs through."""
    pairs = [tuple(map(tuple, pair)) for pair in segments.tolist()]
    at: dict[tuple, list[int]] = defaultdict(list)
    for i, (one, other) in enumerate(pairs):
        if one != other:
            at[one].append(i)
            at[other].append(i)
    left = {i for ends in at.values() for i in ends}
    lines = []
    for start in sorted(at, key=lambda point: len(at[point]) != 1):  # open lines begin at an end
        line = [start]
        while here := [i for i in at[line[-1]] if i in left]:
            left.remove(here[0])
            one, other = pairs[here[0]]
            line.append(other if one == line[-1] else one)
        if len(line) > 1:
            lines.append(np.array(line))
    return lines
