"""The exact motion of a case at given times, in the columns of a result.

A problem and times go in, a `Truth` comes out, for `case_files` and `score`.
"""

from typing import Any, NamedTuple

import numpy as np

from ..exchange.motion import angle_between, theta_of
from ..exchange.simulators import columns_of
from ..problem import Problem
from ..runs.run import Solution, solve, with_rows_at


# fields of `Truth` and their headers, which results of engines have too; columns are in this order
VECTORS = {
    "position": [f"{c} [m]" for c in "xyz"],
    "quaternion": [f"q_{c}" for c in "wxyz"],
    "velocity": [f"v{c} [m/s]" for c in "xyz"],
    "omega": [f"omega_{c} [rad/s]" for c in "xyz"],
    "force": [f"force_{c} [N]" for c in "xyz"],
}


OF_EXCHANGE = ("place", "orientation", "velocity", "omega", "force")
"""Names in `exchange` of the fields of `Truth` after `t`, in their order."""


class Truth(NamedTuple):
    """A motion in SI units; (rows, 3) or, of the quaternion, (rows, 4).

    `truth` makes it for the reference, `score` for the result of an engine.
    """

    t: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    force: np.ndarray


def sample_times(problem: Problem) -> np.ndarray:
    """Return the times of the rows of a reference [s]."""
    return np.union1d(0.0, problem.times[:])


def truth(problem: Problem, times: np.ndarray, precision: Any = "double") -> tuple[Truth, Solution]:
    """Return the motion of a problem at ascending times [s], and its run.

    A run that ends early has fewer rows. The sign of the quaternion is continuous, so that engines
    can interpolate its rows.
    """
    run = solve(with_rows_at(problem, times, precision=precision))
    columns = columns_of(run.problem, run.times, run.rows)
    motion = Truth(run.times, *(columns[name] for name in OF_EXCHANGE))
    flips = (motion.quaternion[1:] * motion.quaternion[:-1]).sum(axis=1) < 0
    signs = np.cumprod(np.where(flips, -1.0, 1.0))
    motion.quaternion[1:] *= signs[:, None]
    return motion, run


def differences(a: Truth, b: Truth) -> dict[str, np.ndarray]:
    """Return the differences of two motions, (rows,) each; NaN where one lacks columns.

    Certificates, `named_cases` and `score` take them by these names.
    """
    result = {
        "attitude [rad]": angle_between(a.quaternion, b.quaternion),
        "theta [rad]": np.abs(theta_of(a.quaternion) - theta_of(b.quaternion)),
    }
    units = {"position": "m", "velocity": "m/s", "omega": "rad/s", "force": "N"}
    for name, unit in units.items():
        difference = getattr(a, name) - getattr(b, name)
        result[f"{name} [{unit}]"] = np.linalg.norm(difference, axis=1)
    return result
