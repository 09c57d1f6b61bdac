"""Growth of small errors of the start, and the time after which a double has lost its digits.

A problem and times go in, a `Growth` comes out.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from ..engine.derivatives.through import followed
from ..engine.observables import ALONE, values_of
from ..mechanics.contact.rows import LOWEST, NUMBERS
from ..problem import Problem
from .run import with_phases


# The texts of `Growth.sentence`, and docstrings here and of `lyapunov`, write both numbers out
ROUNDING = 1e-16  # the error of the start
LOST = 1e-3  # size of the error at which digits of a figure are lost
# of the largest: shorter directions of the start are left out (at a pole, phi turns nothing)
INDEPENDENT = 1e-9


class Growth(NamedTuple):
    """The growth of small errors of the start along a run.

    Parameters
    ----------
    times
        (rows,) [s], from 0.
    factor
        The largest growth of an error, (rows,); 1 at the start. An error is measured by the
        Euclidean norm of the state (of a tippe top 3hat, L, r') in units of m, R (of heavy tops l)
        and 2^k s, the nearest to sqrt(R/g).
    """

    times: np.ndarray
    factor: np.ndarray

    @property
    def exponents(self) -> np.ndarray:
        """Return the finite-time Lyapunov exponent up to each row [1/s]; NaN at the start."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.times > 0, np.log(self.factor) / self.times, np.nan)

    @property
    def horizon(self) -> float:
        """Return the time [s] at which an error of 1e-16 has grown to 1e-3; NaN if none."""
        beyond = np.flatnonzero(self.factor * ROUNDING > LOST)
        if not len(beyond):
            return math.nan
        # beyond[0] is 1 at least: the factor of the first row is 1
        around = slice(beyond[0] - 1, beyond[0] + 1)
        logs = np.log(self.factor[around])
        return float(np.interp(math.log(LOST / ROUNDING), logs, self.times[around]))

    def sentence(self) -> str:
        """Return the horizon or, without one, the largest error, as a sentence.

        It is the attribute `sentence` of the Dataset that `lyapunov` returns.
        """
        if math.isfinite(self.horizon):
            return (
                f"an error of 1e-16 at the start grows to 1e-3 at t = {self.horizon:.6g} s: "
                "double precision is not enough beyond"
            )
        end = self.times[-1]
        rate = self.exponents[-1]
        size = ROUNDING * float(self.factor.max())
        exponent = f"Lyapunov exponent {rate:.3g} 1/s to t = {end:.6g} s"
        return f"an error of 1e-16 at the start grows to at most {size:.2g} ({exponent})"


def growth(problem: Problem, times: np.ndarray) -> Growth:
    """Return the growth of errors of the start, by the variational equations.

    It is the largest singular value of the map from errors of the start, of length 1 in the norm of
    `Growth`, to those of each row; NaN where a row has no derivatives.

    Parameters
    ----------
    problem
        The run, in doubles; it is repeated in vector form where its system has one.
    times
        Of the rows [s], (n,), ascending within the run, the first 0.

    Raises
    ------
    InputError
        If the run has no derivatives.
    """
    system = problem.system
    data = dict(problem.initial)
    theta = data.get("theta", 0.0)
    angles = system.start(data, math.sin(theta), math.cos(theta), problem.body())._asdict()
    if "moving" in angles:  # a start by vectors
        found = values_of(problem.alone, problem.start()[:, None], ALONE)
        units = system.angles._asdict()
        angles = {n: np.nan_to_num(found[n][0]) * problem.scales.of(units[n]) for n in units}
    start = {name: float(value) for name, value in angles.items() if name in system.initial}
    left_out = {"x", "y"}
    if system.is_hybrid and not start.get("gap", 0.0) > 0:
        left_out |= LOWEST.keys()  # errors of a body on the plane leave it there
    wrt = [f"initial.{name}" for name in start if name not in left_out]
    form = system.forms.get("vector", problem.form)
    given = dataclasses.replace(problem, initial=start, form=form, orientation=False)
    _, driver = with_phases(given)
    states = followed(given, wrt, times, driver, np.eye(len(wrt))).rows
    without = {"L3", *NUMBERS}  # L3 is L.3hat
    counted = [i for i, name in enumerate(form.units._fields) if name not in without]
    # 1: first derivatives (0: values); the last direction is that of time
    moves = states[counted, 1, :-1].transpose(2, 0, 1)  # (rows, variables, directions)
    _, sizes, turn = np.linalg.svd(moves[0], full_matrices=False)
    kept = sizes > INDEPENDENT * sizes[0]
    unit = turn[kept].T / sizes[kept]  # directions of the start that are orthogonal and of length 1
    return Growth(
        times,
        np.array(
            [np.linalg.norm(row @ unit, 2) if np.isfinite(row).all() else np.nan for row in moves]
        ),
    )
