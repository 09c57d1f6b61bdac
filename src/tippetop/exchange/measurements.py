"""Measurements from a table, with the prediction of a scenario for them.

A file and a problem go in, an `Observation` comes out, for `fitting` and `likelihood`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import dotted_keys, measured, path_of, takes
from ..errors import InputError
from ..mechanics.units import RADIAN
from ..problem import Problem
from .motion import convention_of, motion, place_of
from .motion_table import read
from .observation import Observation


MOST_ROWS = 100_000


@takes(convention_of)
def observed(
    data: str | Path,
    problem: Problem,
    free: Sequence[str],
    *,
    marker: Sequence[float] | str | None = None,
    noise: float | str | None = None,
    **frames: Any,
) -> Observation:
    """Return measurements and the prediction of a scenario for them.

    `noise`: the standard deviation of measured angles [rad], or a text such as "1 deg".

    Raises
    ------
    InputError
        If the table, the names or the conventions are wrong.
    """
    data = path_of("data", data)
    convention = convention_of(**frames)
    at = place_of("marker", marker)
    noise = None if noise is None else measured("noise", noise, RADIAN)
    if noise is not None and not 0 < noise < np.pi:
        raise InputError(f"`noise` must be an angle between 0 and pi, but is {noise} rad.")
    table = read(
        data,
        wrapped=bool(problem.system.vectors),
        noise=noise or 0.0,
        track=convention.track,
    )
    if len(table.t) > MOST_ROWS:
        raise InputError(
            f"`{data}` must have at most {MOST_ROWS:,} rows to be fitted, but has {len(table.t):,}."
        )
    columns = [f"marker_{c}" for c in "xyz"]
    if len({at is not None, *map(table.has, columns)}) > 1:
        raise InputError(
            f"a marker must have the columns {', '.join(columns)} in `{data}` and a place on "
            "the body (--marker x,y,z, metres in body axes), but one of them is missing."
        )
    names = dotted_keys(free, problem.rules)
    seen = motion(table, convention)
    return Observation(problem, names, seen, at, noise, convention.chip)
