"""How far estimates would move if the world were not quite that of the scenario.

Each influence has a plausible size. Near the end of a fit, where it is linear, it changes the
residuals by a vector, and the numbers by the pseudo-inverse of the Jacobian times that.
"""

import copy
import math
from collections.abc import Mapping

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays
from ..errors import InputError
from ..problem import Problem
from ..scenario import build
from .misfit import Misfit


TILTED = "a table tilted by 0.1 degrees"
TILT = math.radians(0.1)
AIR = "the drag of still air on a sphere of its size"
DISC = "a contact disc of 0.1 mm"
PATCH = 1e-4
# Fraction of a change that is computed, where the effect is proportional to it
PART = 0.01
# Coulomb coefficient of a law that has none
USUAL_MU = 0.2
DENSITY, VISCOSITY = 1.2, 1.5e-5
"""Of air [kg/m^3], kinematic [m^2/s]."""


def air_of_sphere(radius: float, spin: float) -> tuple[float, float]:
    """Return c1 and c2 of the torque of the air on a sphere that turns about a diameter.

    The torque is rho omega^2 R^5 (6.45/sqrt(Re) + 32.1/Re)/2, Re = omega R^2/nu (Dennis, Singh and
    Ingham, J. Fluid Mech. 101, 1980), which c1 omega + c2 omega^2 meets at this spin [rad/s].
    """
    c1 = 16.05 * DENSITY * VISCOSITY * radius**3
    return c1, 3.225 * DENSITY * math.sqrt(VISCOSITY / spin) * radius**4


def changes(misfit: Misfit, values: Mapping[str, float]) -> Arrays:
    """Return how the residuals change under each influence that the scenario lacks.

    Parameters
    ----------
    misfit
        Of the measurements; its observation has the scenario.
    values
        The fitted numbers.

    Returns
    -------
    dict
        (directions, residuals) by influence, which may act along one or two directions. One that
        the system of the scenario cannot have is left out.
    """
    problem = misfit.observation.problem
    tables = build.resolved(problem)
    tables["run"] = {"until": problem.until}
    del tables["form"]
    start = {**tables["initial"], **{n.partition(".")[2]: v for n, v in values.items()}}
    spin = abs(float(start.get("omega3", 0.0))) or 1.0
    law = tables.get("friction", {}).get("law", "none")
    cases: dict[str, list[dict[str, float]]] = {}
    if "tilt" not in tables.get("plane", {}):
        cases[TILTED] = [{"plane.tilt": TILT, "plane.azimuth": turn} for turn in (0.0, math.pi / 2)]
    if "air" not in tables and "R" in tables["parameters"]:
        c1, c2 = air_of_sphere(float(start.get("R", tables["parameters"]["R"])), spin)
        cases[AIR] = [{"air.c1": c1, "air.c2": c2}]
    if law not in ("none", "coulomb", "contensou") and "mu_d" not in tables["friction"]:
        mu = 3 * math.pi / 16 * tables["friction"].get("mu_coulomb", USUAL_MU)
        cases[DISC] = [{"friction.mu_d": mu * PATCH}]
    found = {}
    for name, some in cases.items():
        keys = list(some[0])
        extended = {**tables}
        for key in keys:
            table, _, number = key.partition(".")
            extended[table] = {**extended.get(table, {}), number: 0.0}
        points = [dict.fromkeys(keys, 0.0)]
        points += [{k: v if k == "plane.azimuth" else PART * v for k, v in p.items()} for p in some]
        rows = _residuals(misfit, extended, keys, [{**values, **p} for p in points])
        if rows is not None:
            found[name] = (rows[1:] - rows[0]) / PART
    if law == "coulomb":
        friction = {"law": "contensou", "patch": PATCH, "mu_r": 0.0}
        friction["mu"] = tables["friction"]["mu"]
        before = _residuals(misfit, tables, [], [dict(values)])
        after = _residuals(misfit, {**tables, "friction": friction}, [], [dict(values)])
        if before is not None and after is not None:
            found[DISC] = after - before
    return found


def _residuals(
    misfit: Misfit, tables: PlainData, keys: list[str], points: list[dict[str, float]]
) -> np.ndarray | None:
    """Return residuals (points, numbers) under changed tables; None if they are refused."""
    observation = copy.copy(misfit.observation)
    try:
        problem: Problem = build.problem(tables)
        known = [name for name in observation.own if name in problem.rules]
        observation.own = (*known, *keys)
        observation.predicted = observation.predictions_of(problem, observation.own)
        observation.predicted.refine()
        rows, _ = misfit.read(observation, points, misfit.rows)
    except InputError:
        return None
    return rows if np.isfinite(rows).all() else None
