"""theta(t) of a run made again from its D(t) and E~(t): the main equation as an equation of motion. [T 4.40, 5.26]"""

import math
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..columns import require
from ..engine.observables import Observables
from ..errors import InputError
from ..mechanics.theory import main_equation
from ..mechanics.units import SECOND
from ..problem import Problem


if TYPE_CHECKING:
    import xarray as xr

LARGEST_MISMATCH = 1e-6  # of cos(theta) where pieces of a reconstruction meet; a good one has 1e-9 and less


def reconstruction(
    problem: Problem, trajectory: "Callable[[], xr.Dataset]", events: "Callable[[], xr.Dataset]", period: float | None
) -> "xr.Dataset":
    """theta along the rows of a run, and the times of its turnings. Raises InputError; see `tippetop.reconstruct`.

    Parameters
    ----------
    problem
        What was integrated.
    trajectory, events
        They give the tables of the run.
    period
        A guess of the period of nutation [s]; by default twice the first turning time.
    """
    import xarray as xr

    system = problem.system
    if problem.contact is not None:
        raise InputError(["the run must be one whose contact stays what it is, but its contact may change its phase."])
    if len(system.momenta) != 2:
        raise InputError([f"the run must be one of a tippe top or a heavy top, but is one of {system.name}."])
    rows = trajectory()
    require(("theta", "modified_energy", *system.momenta), rows, "what theta is reconstructed from")
    log = events()
    turning = (log["kind"].values == 0) & log["significant"].values.astype(bool)
    if period is None and not turning.any():
        raise InputError(["`period` must be given where the run has no turnings, but is missing."])
    guess = 2 * float(log["time"].values[turning][0]) if period is None else period
    units = {quantity.name: quantity.unit for quantity in system.quantities}
    second = float(problem.scales.of(SECOND))
    energy, *momenta = (
        rows[name].values / float(problem.scales.of(units[name])) for name in ("modified_energy", *system.momenta)
    )
    solution = main_equation.reconstruct(
        system,
        Observables(problem).body,
        rows["time"].values / second,
        momenta,
        energy,
        math.cos(float(rows["theta"][0])),
        guess / second,
    )
    if not solution.mismatch <= LARGEST_MISMATCH:
        warnings.warn(
            f"the pieces of the reconstruction disagree by {solution.mismatch:.1e} in cos(theta): "
            "theta is not to be relied on.",
            stacklevel=3,
        )
    theta = {"units": "rad", "long_name": "theta by the main equation"}
    return xr.Dataset(
        {"theta": ("time", np.arccos(solution.z), theta)},
        {
            "time": rows["time"],
            "turning": ("turning", solution.turnings * second, {"units": "s", "long_name": "times of the turnings"}),
        },
        {"mismatch": solution.mismatch},
    )
