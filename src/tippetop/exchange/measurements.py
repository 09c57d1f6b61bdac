"""Measurements from a table, with the prediction of a scenario for them.

A file and a problem go in, an `Observation` comes out, for `fitting` and `likelihood`.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..arguments import dotted_keys, measured
from ..errors import InputError
from ..mechanics.units import RADIAN
from ..problem import Problem
from .motion import Convention, motion
from .motion_table import read
from .observation import Observation


MOST_ROWS = 100_000


def observation_of(
    problem: Problem,
    data: str | Path,
    free: Sequence[str],
    convention: Convention,
    marker: tuple[float, float, float] | None,
    noise: float | str | None = None,
) -> Observation:
    """Return measurements and the prediction of a scenario for them.

    `noise`: the standard deviation of measured angles [rad], or a text such as "1 deg".

    Raises
    ------
    InputError
        If the table, the names or the conventions are wrong.
    """
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
    if len({marker is not None, *map(table.has, columns)}) > 1:
        raise InputError(
            f"a marker must have the columns {', '.join(columns)} in `{data}` and a place on "
            "the body (--marker x,y,z, metres in body axes), but one of them is missing."
        )
    names = dotted_keys(free, problem.rules)
    seen = motion(table, convention)
    return Observation(problem, names, seen, marker, noise, convention.chip)
