"""States of phases as rows of the run."""

from typing import Any

import numpy as np

from ...mechanics.contact.body import jellett_of
from ...mechanics.contact.phases.legs import Kind, Reached
from ...mechanics.contact.phases.row import PHASES, Row
from ...mechanics.contact.phases.rules import stem_height
from ...mechanics.operand import dot
from .balls import Balls


def rows_of(
    kind: Kind, ball: int, balls: Balls, states: np.ndarray, carried: np.ndarray, taken: Any, number: Any
) -> np.ndarray:
    """States (n, variables) of a phase as rows.

    Parameters
    ----------
    kind, ball
        The phase, and the number of the ball in contact.
    balls
        All balls.
    states
        Internal units.
    carried
        The integrals, (n, k), scaled.
    taken
        Jellett's integral when the ball was taken, a number or (n,).
    number
        The type of numbers.

    Returns
    -------
    rows
        (n, variables of a row), internal units.
    """
    body, n = balls[ball], len(states)
    says: Reached = kind.says(type(kind.form.units)(*states.T[: len(kind.form.units)]), body)
    if not kind.keeps_jellett:
        taken = jellett_of(says.L.z, dot(says.L, says.u), body)
    gap = stem_height(says.height, says.u.z, balls[1].c, balls[1].R) if balls.stem else 0
    row = Row(
        *says.u, *says.L, *says.velocity, says.height, *says.force,
        body.R, body.c, gap, PHASES.index(kind.phase), ball, taken, says.drilled,
    )  # fmt: skip
    rows = np.empty((n, len(row) + carried.shape[1]), dtype=number)
    for k, value in enumerate(row):
        rows[:, k] = value
    rows[:, len(row) :] = carried
    return rows
