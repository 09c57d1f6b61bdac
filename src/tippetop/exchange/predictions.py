"""Columns of many motions at given times, for sets of values of the free numbers of a scenario."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from ..columns import Arrays
from ..engine.expressions import AXES, component
from ..engine.orientation import quaternion
from ..engine.status import Status
from ..engine.tangent import Tangents
from ..ensembles.hybrid_tops import faults_of, problem_of
from ..errors import InputError
from ..mechanics.operand import Vector
from ..mechanics.rotation import outer
from ..mechanics.units import METRE, METRE_PER_SECOND2, PER_SECOND2, RADIAN_PER_SECOND
from ..problem import Problem, Problems, name_faults
from ..runs.run import solve, with_rows_at


# Tolerance of the integrator while numbers are searched: three fifths of the time
TOLERANCE = 1e-9
# Steps per internal unit of time beyond which a motion is given up: a canonical inversion takes 9
MOST_STEPS = 25.0
IN_BODY = {
    "gyroscope": RADIAN_PER_SECOND,
    "omega": RADIAN_PER_SECOND,
    "turning": PER_SECOND2,
    "accelerometer": METRE_PER_SECOND2,
}
"""Units of the values of `engine.variational.CHIP`."""
VALUES = {
    "axis": tuple(component(f"u{c}") for c in "xyz"),
    "orientation": AXES,
    "z": ("height",),
    **{name: tuple(f"{name}_{c}" for c in "xyz") for name in IN_BODY},
}
"""Values from which a column is made, if not those of its name."""


class Predictions:
    """Motions of a scenario whose free numbers have given values.

    Parameters
    ----------
    problem
        The scenario.
    free
        Dotted names of the free numbers; an initial number that is not given is 0.

    Raises
    ------
    InputError
        If the problem has no number of a name, or its motion is not one of doubles from a start.
    """

    def __init__(self, problem: Problem, free: Sequence[str]):
        self.problem = problem
        self.tangents = None
        if not problem.system.is_hybrid:
            coarse = dataclasses.replace(problem, tolerance=TOLERANCE)
            self.tangents = Tangents(coarse, free, MOST_STEPS)
        elif faults := name_faults(problem, free, without=("run.",)):
            raise InputError(faults)

    def refine(self) -> None:
        """Predict with the tolerance of the scenario from now on."""
        if self.tangents is not None:
            self.tangents.problem = self.problem

    def read(
        self, points: Mapping[str, np.ndarray], times: np.ndarray, names: Sequence[str]
    ) -> Arrays:
        """Return columns (points, rows) or (points, rows, parts), SI, by name.

        They are NaN where a motion cannot be computed.

        Parameters
        ----------
        points
            Values of the free numbers, (points,) each, SI.
        times
            (points, rows) [s], ascending.
        names
            Of the columns.
        """
        if self.tangents is not None:
            return self._read_smooth(self.tangents, points, times, names)
        if not points:
            points = {"run.until": times[:, -1]}
        turns = "orientation" in names
        return rows_at_times(Problems.vary(self.problem, points, turns), times, names)[0]

    def _read_smooth(
        self,
        tangents: Tangents,
        points: Mapping[str, np.ndarray],
        times: np.ndarray,
        names: Sequence[str],
    ) -> Arrays:
        """Read motions that a single system of equations describes."""
        parts = {name: VALUES.get(name, (name,)) for name in names}
        pars = tangents.parameters(np.zeros((len(tangents.values), len(times))), points)
        wanted = tuple(dict.fromkeys(part for some in parts.values() for part in some))
        read = tangents.read(0, pars, times.T, wanted)
        system = self.problem.system
        units = {**system.angles._asdict(), **IN_BODY, "z": METRE}
        units |= {q.name: q.unit for q in system.quantities}
        found = {}
        for name, some in parts.items():
            values = [read[part][0].T for part in some]
            if name == "orientation":
                values = list(quaternion(outer(Vector(*values[:3]), Vector(*values[3:]))))
            scale = self.problem.unit(units[name]) if name in units else 1.0
            found[name] = scale * (np.stack(values, axis=-1) if len(values) > 1 else values[0])
        return found


def rows_at_times(
    tops: Problems, times: np.ndarray, names: Sequence[str]
) -> tuple[Arrays, np.ndarray]:
    """Return columns of tops at given times, and the codes of their `Status`, (tops,).

    Parameters
    ----------
    tops
        The runs; each ends with its last time.
    times
        (tops, rows) [s], ascending.
    names
        Of columns of runs.
    """
    found: Arrays = {}
    status = np.full(tops.n, Status.INVALID.code)
    for top in np.flatnonzero(tops.valid).tolist():
        later = times[top] >= 0
        try:
            problem = problem_of(tops, top)
            if faults := faults_of(problem):
                raise InputError(faults)
            run = solve(with_rows_at(problem, times[top, later]))
        except InputError:
            continue
        status[top] = run.status.code
        columns = run.columns()
        after = times[top, later] > run.progress.t_end
        for name in names:
            values = columns[name].values
            values[after] = np.nan
            every = found.setdefault(name, np.full((*times.shape, *values.shape[1:]), np.nan))
            every[top, later] = values
    widths = {"axis": (3,), "orientation": (4,)}
    for name in names:
        found.setdefault(name, np.full((*times.shape, *widths.get(name, ())), np.nan))
    return found, status
