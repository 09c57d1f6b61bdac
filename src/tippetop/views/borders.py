"""Thresholds as lines over the map of a page, for each choice of the further axes.

The plan of a sweep goes in; lines come out as plain data for the page.
"""

import itertools
from typing import Any

import numpy as np
from contourpy import contour_generator

from ..sweeps import maps
from ..sweeps.design import Axis
from ..sweeps.plan import Plan
from .encoding import encode


EVERY = 3  # of the points that a figure takes: lines on a page are a few hundred pixels long
MOST = 400  # choices of further axes; each takes 20 ms and some kilobytes


def borders(plan: Plan, axes: list[Axis], table: Any) -> dict[str, Any]:
    """Return the lines of a map, as the page takes them.

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
        `labels` of the thresholds, and for each choice of the further axes, the last fastest,
        `lines`: numbers x, y, x, y ... for each label, in base64, NaN between two lines; y is -inf
        and inf where there is one axis. borders.js reads them.
    """
    plane = [axis for axis in axes[:2] if axis.varies]
    further = axes[len(plane) :]
    choices = [np.unique([v for v in axis.numbers if np.isfinite(v)]) for axis in further]
    many = np.prod([len(numbers) for numbers in choices], dtype=float) > MOST
    if not plane or many or any(axis.sampled for axis in further):
        return {"labels": [], "lines": []}
    spread = tuple(maps.map_axis(plan, axis, table[axis.of].attrs) for axis in plane)
    keys = [axis.of for axis in further]
    ratios = [
        maps.borders_of(plan, spread, dict(zip(keys, numbers, strict=True)), EVERY)
        for numbers in itertools.product(*choices)
    ]
    labels = list(dict.fromkeys(label for each in ratios for label in each))
    places = [axis.span[::EVERY] for axis in spread]
    lines = [
        [encode(_lines(places, each[label]), "<f4") if label in each else "" for label in labels]
        for each in ratios
    ]
    return {"labels": labels, "lines": lines}


def _lines(places: list[np.ndarray], logarithms: np.ndarray) -> np.ndarray:
    """Return the points (n, 2) where logarithms of ratios over one or two axes are zero."""
    # interpolated between points as |lambda|/threshold - 1, which is linear in a spin
    values = np.ma.masked_invalid(np.expm1(logarithms))
    reach = (1.0, 1.0)
    if len(places) == 1:
        places = [*places, np.array([-1.0, 1.0])]
        values = np.ma.stack([values, values], axis=1)
        reach = (1.0, np.inf)  # from y = -1 and 1 to -inf and inf
    x, y = places
    paths: Any = contour_generator(x, y, values.T).lines(0.0)
    gap = np.full((1, 2), np.nan)
    return np.concatenate([piece for line in paths for piece in (line * reach, gap)] or [gap])
