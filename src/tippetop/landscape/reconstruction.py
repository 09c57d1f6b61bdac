"""theta(t) of a run from its D(t) and E~(t), by the main equation. [T 4.40, 5.26]

A trajectory of a run goes in, a labelled Dataset comes out; `theory.main_equation` solves the
equation.
"""

import math
import warnings

import numpy as np
import xarray as xr

from ..columns import require, significant_turnings
from ..errors import InputError
from ..mechanics.contact.surroundings import require_still
from ..mechanics.theory import main_equation
from ..problem import Problem


# of a swing, from one turning to the next: with fewer the curves through D and E~ mean nothing
LEAST_ROWS = 4


def reconstruction(
    problem: Problem, rows: xr.Dataset, events: xr.Dataset, period: float | None
) -> xr.Dataset:
    """Return theta along the rows of a run, and the times of its turnings. Raises InputError.

    Parameters
    ----------
    problem
        The problem that was integrated.
    rows, events
        The tables of the run, whole: the first row is at a turning.
    period
        A guess of the period of nutation [s]; by default twice the first turning time.
    """
    system = problem.system
    require_still(problem.tables, "the run")
    if problem.contact is not None:
        raise InputError(
            "the run must be one whose contact keeps its phase, but its contact may change it."
        )
    if len(system.momenta) != 2:
        raise InputError(
            f"the run must be one of a tippe top or a heavy top, but is one of {system.name}."
        )
    if speed := problem.initial.get("theta_dot"):
        raise InputError(
            f"`initial.theta_dot` must be 0, so that the run starts at a turning, but is {speed:g}."
        )
    names = "modified_energy", *system.momenta
    require(("theta", *names), rows, "what theta is reconstructed from")
    times = rows["time"].values
    turned = events["time"].values[significant_turnings(events)]
    turned = turned[turned <= times.max(initial=0.0)]
    if period is None:
        if not turned.size:
            raise InputError(
                "`period` must be given where the run has no turnings, but is missing."
            )
        period = 2 * float(turned[0])
    if period <= (apart := float(np.diff(times).min(initial=np.inf))):
        raise InputError(
            f"`period` must be longer than the {apart:.3g} s between two rows, but is "
            f"{period:.3g} s."
        )
    swings = np.append(0.0, turned if turned.size else period / 2)
    least = np.diff(np.searchsorted(times, swings)).min()
    if least < LEAST_ROWS:
        raise InputError(
            f"the run must have rows enough, some hundred in each nutation, but has {least} "
            "between two turnings: a smaller `output_step`."
        )
    energy, *momenta = (rows[name].values for name in names)
    z = math.cos(float(rows["theta"][0]))
    solution = main_equation.reconstruct(system, problem.body(), times, momenta, energy, z, period)
    if solution.early:
        end = float(times[np.isfinite(solution.z)].max())
        warnings.warn(
            f"the reconstruction ends at t = {end:.4g} s: later its error may reach "
            f"{solution.mismatch:.1e} in cos(theta), so that theta is not given.",
            stacklevel=3,
        )
    theta = {"units": "rad", "long_name": "theta by the main equation"}
    about = {"units": "s", "long_name": "times of the turnings"}
    return xr.Dataset(
        {"theta": ("time", np.arccos(solution.z), theta)},
        {"time": rows["time"], "turning": ("turning", solution.turnings, about)},
        {"mismatch": solution.mismatch},
    )
