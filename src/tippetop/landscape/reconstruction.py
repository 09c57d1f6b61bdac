"""theta(t) of a run from its D(t) and E~(t), by the main equation. [T 4.40, 5.26]"""

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

# of a swing, from one turning to the next: with fewer the curves through D and E~ mean nothing
LEAST_ROWS = 4


def reconstruction(
    problem: Problem,
    trajectory: "Callable[[], xr.Dataset]",
    events: "Callable[[], xr.Dataset]",
    period: float | None,
) -> "xr.Dataset":
    """Return theta along the rows of a run, and the times of its turnings. Raises InputError.

    Parameters
    ----------
    problem
        The problem that was integrated.
    trajectory, events
        Functions that return the tables of the run.
    period
        A guess of the period of nutation [s]; by default twice the first turning time.
    """
    import xarray as xr

    system = problem.system
    if problem.contact is not None:
        raise InputError(
            "the run must be one whose contact keeps its phase, but its contact may change it."
        )
    if len(system.momenta) != 2:
        raise InputError(
            f"the run must be one of a tippe top or a heavy top, but is one of {system.name}."
        )
    rows, log = trajectory(), events()
    require(("theta", "modified_energy", *system.momenta), rows, "what theta is reconstructed from")
    times = rows["time"].values
    if len(times) < LEAST_ROWS:
        raise InputError(
            f"the run must have rows enough, some hundred in each nutation, but has {len(times)}."
        )
    turned = log["time"].values[(log["kind"].values == 0) & log["significant"].values.astype(bool)]
    if period is None:
        if not turned.size:
            raise InputError(
                "`period` must be given where the run has no turnings, but is missing."
            )
        period = 2 * float(turned[0])
    if period <= (apart := float(np.diff(times).min())):
        raise InputError(
            f"`period` must be longer than the {apart:.3g} s between two rows, but is "
            f"{period:.3g} s."
        )
    swings = np.append(0.0, turned if turned.size else period / 2)
    between = np.diff(np.searchsorted(times, swings[swings <= times[-1]]))
    if between.size and between.min() < LEAST_ROWS:
        raise InputError(
            "the run must have rows enough, some hundred in each nutation, but has "
            f"{between.min()} between two turnings: a smaller `output_step`."
        )
    units = {quantity.name: quantity.unit for quantity in system.quantities}
    second = float(problem.scales.of(SECOND))
    energy, *momenta = (
        rows[name].values / float(problem.scales.of(units[name]))
        for name in ("modified_energy", *system.momenta)
    )
    solution = main_equation.reconstruct(
        system,
        Observables(problem).body,
        times / second,
        momenta,
        energy,
        math.cos(float(rows["theta"][0])),
        period / second,
    )
    if solution.early:
        end = float(times[np.isfinite(solution.z)].max())
        gap = f"its pieces disagree by {solution.mismatch:.1e} in cos(theta)"
        why = "no turning is found beyond" if solution.mismatch <= main_equation.APART else gap
        warnings.warn(
            f"the reconstruction ends at t = {end:.4g} s: {why}. After it theta is not to be "
            "relied on, and not given.",
            stacklevel=3,
        )
    theta = {"units": "rad", "long_name": "theta by the main equation"}
    about = {"units": "s", "long_name": "times of the turnings"}
    return xr.Dataset(
        {"theta": ("time", np.arccos(solution.z), theta)},
        {"time": rows["time"], "turning": ("turning", solution.turnings * second, about)},
        {"mismatch": solution.mismatch},
    )
