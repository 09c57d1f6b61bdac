"""Keyframes: exact states of an integrator, from which any part of a run is integrated again.

A driver goes in at a step, a row of the table `keyframes` comes out, and back again for `replay`.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column, column
from ..engine.driver import Driver
from ..engine.observables import Observables
from ..engine.taylor import driver_of, fingerprint
from ..mechanics.units import SECOND
from ..problem import Problem


# Keyframes per chunk: 1 MB.
PER_CHUNK = 1024
EXACT = ("state", "time", "until")
"""Entries of a snapshot that have the precision of the run; all others are doubles."""
PARTS = {"double": 1, "longdouble": 2, "quad": 3}
"""Number of doubles that add up to a number exactly, by precision."""


def columns(problem: Problem, driver: Driver, t_end: float, steps: int) -> dict[str, Column]:
    """Return the present state, after `steps` steps at `t_end` [s], as a row of `keyframes`.

    Values have the shape (1, ...); numbers wider than doubles are split, so that none is rounded.
    `state` has all numbers of `_snapshot` in its order, by which `restore` reads stored keyframes.
    """
    exact = np.concatenate(
        [np.ravel(np.array(value, problem.number)) for value in _snapshot(driver).values()]
    )
    parts = []
    with np.errstate(invalid="ignore"):  # of an infinite double only the first part counts
        for _ in range(PARTS[problem.precision]):
            parts.append(exact.astype(float))
            exact = exact - parts[-1].astype(exact.dtype)
    words = "exact state and event data, internal: doubles to be added"
    state = {"units": "1", "long_name": words, "equations": fingerprint(driver)}
    dims = ("keyframe",)
    return {
        "time": column(np.array([t_end]), SECOND, "time", dims),
        "step": Column(dims, np.array([steps]), {"units": "1", "long_name": "steps made"}),
        "state": Column((*dims, "number", "part"), np.stack(parts, axis=-1)[None], state),
    }


def restore(driver: Driver, row: dict[str, np.ndarray]) -> None:
    """Set a driver to the state of a keyframe, a row by column; its `state` is (number, part).

    The driver's present snapshot has only the names and shapes, in the order in which `columns`
    joined them: a change of one is a change of both.
    """
    first = 0
    kept = {}
    for name, like in _snapshot(driver).items():
        parts = row["state"][first : first + np.size(like)].T
        first += np.size(like)
        exact = sum(parts.astype(driver.number)[1:], parts[0].astype(driver.number))
        kept[name] = np.reshape(exact if name in EXACT else parts[0], np.shape(like))
    driver.restore(kept, kept["state"], tuple(kept["time"]))


def _snapshot(driver: Driver) -> dict[str, Any]:
    """Return the snapshot of a driver, with a state of the same length in every phase.

    So all keyframes of a run have the same length, as rows of one array.
    """
    kept = driver.snapshot()
    return kept | {"state": [*kept["state"], *[0.0] * (driver.width - len(kept["state"]))]}


def rows(path: Path, problem: Problem) -> dict[str, Column]:
    """Return the start and the keyframes of a stored run as rows. Raises StoreError."""
    from ..store.root import loaded, open_group

    table = loaded(open_group(path, "keyframes"), path)
    driver = driver_of(problem)
    states = [problem.start()[None, :]]
    for state in table["state"].values:
        restore(driver, {"state": state})
        states.append(driver.present())
    times = np.concatenate([[0.0], table["time"].values])
    return Observables(problem).columns(times, np.concatenate(states))
