"""Columns of many motions at given times, for sets of values of the free numbers of a scenario."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from ..columns import Arrays
from ..engine.expressions import AXES, component
from ..engine.orientation import quaternion
from ..engine.tangent import Tangents
from ..ensembles import ensemble
from ..ensembles.rows_at_times import rows_at_times
from ..errors import InputError
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, axes, outer
from ..mechanics.units import METRE, METRE_PER_SECOND2, PER_SECOND2, RADIAN_PER_SECOND
from ..problem import Problem, name_faults
from ..runs.shape import moments


# Tolerance of the integrator while numbers are searched: half of the time
TOLERANCE = 1e-9
# Steps per internal unit of time beyond which a motion is given up: a canonical inversion takes 9,
# a rattleback 27
MOST_STEPS = 60.0
IN_BODY = {
    "gyroscope": RADIAN_PER_SECOND,
    "omega": RADIAN_PER_SECOND,
    "turning": PER_SECOND2,
    "accelerometer": METRE_PER_SECOND2,
}
"""Units of the values of `engine.variational.CHIP`."""
ACCELEROMETER = ("accelerometer", "gyroscope", "turning")
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
    most
        Steps per internal unit of time beyond which a motion is given up; 0: any number.

    Raises
    ------
    InputError
        If the problem has no number of a name, or its motion is not one of doubles from a start.
    """

    def __init__(self, problem: Problem, free: Sequence[str], most: float = MOST_STEPS):
        self.exact = problem
        self.problem = dataclasses.replace(problem, tolerance=max(TOLERANCE, problem.tolerance))
        self.tangents = None
        if not problem.system.is_hybrid:
            self.tangents = Tangents(self.problem, free, most)
        elif faults := name_faults(problem, free, without=("run.",)):
            raise InputError(faults)

    def refine(self) -> None:
        """Predict with the tolerance of the scenario from now on."""
        self.problem = self.exact
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
        turned = {"orientation", "L"} if IN_BODY.keys() & names else set()
        known = turned | ({*names} - IN_BODY.keys())
        tops = ensemble.vary(self.problem, points, orientation="orientation" in known)
        read = rows_at_times(tops, times, known)[0]
        if turned:
            frame = np.array(axes(Quaternion(*np.moveaxis(read["orientation"], -1, 0))))
            inertia = moments(tops.body(lambda number: np.broadcast_to(number, tops.n)))
            read["gyroscope"] = np.einsum("axpr,prx,ap->pra", frame, read["L"], 1 / inertia)
            read["omega"] = np.einsum("axpr,pra->prx", frame, read["gyroscope"])
        return read

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


def at_chip(read: Arrays, chip: Sequence[float]) -> np.ndarray:
    """Return the specific force at a place in the body, (..., 3) [m/s^2].

    `read`: the values `ACCELEROMETER` of a motion.
    """
    w = read["gyroscope"]
    bent = np.cross(read["turning"], chip) + np.cross(w, np.cross(w, chip))
    return np.asarray(read["accelerometer"] + bent)
