"""How far estimates would move if the world were not quite that of the scenario.

Each influence has a plausible size. Near the end of a fit, where it is linear, it changes the
residuals by a vector, and the numbers by the pseudo-inverse of the Jacobian times that.
"""

import math

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays
from ..errors import InputError
from ..problem import Problem
from ..scenario import build
from .misfit import Misfit


# Words for the report, and the sizes that they contain: a change of one is a change of both. PATCH
# is a radius [m], and also that of a disc in `law_choice.under`
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
    # 32.1/2 in c1; 6.45/2 in c2, with the root of Re at this spin
    c1 = 16.05 * DENSITY * VISCOSITY * radius**3
    return c1, 3.225 * DENSITY * math.sqrt(VISCOSITY / spin) * radius**4


def changes(misfit: Misfit, values: dict[str, float]) -> Arrays:
    """Return how the residuals change under each influence that the scenario lacks.

    Parameters
    ----------
    misfit
        Of the measurements; its observation has the scenario.
    values
        The free numbers, SI, floats: those of a minimum.

    Returns
    -------
    dict
        (directions, residuals) by influence, which may act along one or two directions. One that
        the system of the scenario cannot have is left out. The keys are phrases that begin or end
        a sentence of the report (`fitting.judged`, `_hidden`), and keys of `Fit.influences`.
    """
    observation = misfit.observation
    tables = observation.tables(values)
    friction = tables.get("friction", {"law": "none"})
    law = friction["law"]
    plane = tables.get("plane", {})
    # By influence: tables without it, then with each direction of it, and the part of its size that
    # they have
    cases: dict[str, tuple[list[PlainData], float]] = {}
    if "tilt" not in plane:
        tilts = (0.0, 0.0), (PART * TILT, 0.0), (PART * TILT, math.pi / 2)
        some = [{"plane": {**plane, "tilt": tilt, "azimuth": turn}} for tilt, turn in tilts]
        cases[TILTED] = some, PART
    if "air" not in tables and "R" in tables["parameters"]:
        spin = abs(tables["initial"].get("omega3", 0.0)) or 1.0
        c1, c2 = air_of_sphere(tables["parameters"]["R"], spin)
        cases[AIR] = [{"air": {"c1": size * c1, "c2": size * c2}} for size in (0.0, PART)], PART
    if law == "coulomb":
        # patch and mu_r as the disc in `law_choice`: a change of one is a change of both
        disc = {"law": "contensou", "patch": PATCH, "mu_r": 0.0, "mu": friction["mu"]}
        cases[DISC] = [{}, {"friction": disc}], 1.0
    elif law not in ("none", "contensou") and "mu_d" not in friction:
        # 3 pi/16 as `simulators.DRILLING`, Hertz's pressure: a change of one is a change of both
        drilling = 3 * math.pi / 16 * friction.get("mu_coulomb", USUAL_MU) * PATCH
        some = [{"friction": {**friction, "mu_d": size * drilling}} for size in (0.0, PART)]
        cases[DISC] = some, PART

    def residuals(changes: PlainData) -> np.ndarray:
        """Return the residuals (numbers,) with changed tables; NaN if these are refused.

        A system may lack an influence, or an accelerometer is measured, and the contact could
        change with it. `changes` leaves the influence out.
        """
        try:
            other = observation.under(changed(tables, changes))
        except InputError:
            return np.full(observation.count, np.nan)
        return misfit.read(other, values, misfit.rows)[0]

    found = {}
    for name, (some, part) in cases.items():
        every = np.array([*map(residuals, some)])
        if np.isfinite(every).all():
            found[name] = (every[1:] - every[0]) / part
    return found


def changed(tables: PlainData, changes: PlainData) -> Problem:
    """Return a scenario with other tables, in the form that suits them. Raises InputError.

    `tables` are those that `build.resolved` returns.
    """
    every = {name: table for name, table in tables.items() if name != "form"}
    return build.problem(every | {"run": {"until": tables["run"]["until"]}} | changes)
