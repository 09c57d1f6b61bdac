"""Turning angles, the period of nutation, and the band along a run."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..mechanics.systems import tippe_top
from .body import attributes, cosine, flags, inclination, kernels, labelled, top
from .formulas import SHAPES


ALLOWANCE = 1e-12  # relative: an energy this close to the minimum touches it (the drift of a good run stays below)


# --- turning angles and nutation ------------------------------------------------------------------------------------


def turning_angles(
    parameters: Mapping[str, float], first: Any, second: Any, energy: Any, system: str = "tippe-top"
) -> xr.Dataset:
    """The two angles where V = E~ [J], the period of nutation between them, and that of small nutations.

    The arguments are broadcast against one another, with any shape; DataArrays keep their dimensions and coordinates.
    theta_min <= theta_star <= theta_max [rad]; theta_star is where V is least (the lower of two minima). `period` [s]
    is the quadrature of the separated equation, NaN where it does not settle to 11 digits (nutations of some 1e-5 rad
    or less, and next to a separatrix); `small_period` [s] is 2 pi sqrt(2 g/V''), exact for vanishing amplitude.
    `level`: above; touching: E~ is the minimum to 1e-12, both angles are theta_star; below; undefined. [T 4.12, 4.21]
    """
    from tippetop_kernels.level_crossings import Level

    t, k = top(parameters, system), kernels()
    arrays: list[Any] = [
        a if isinstance(a, xr.DataArray) else np.asarray(a, dtype=float) for a in (first, second, energy)
    ]
    if any(isinstance(a, xr.DataArray) for a in arrays):
        arrays = list(xr.broadcast(*(a if isinstance(a, xr.DataArray) else xr.DataArray(a) for a in arrays)))
        dims, coords = arrays[0].dims, dict(arrays[0].coords)
    else:
        arrays = list(np.broadcast_arrays(*arrays))
        dims, coords = tuple(f"dim_{i}" for i in range(arrays[0].ndim)), {}
    shape = arrays[0].shape
    x, y, E = (np.ascontiguousarray(np.asarray(a, dtype=float).ravel()) for a in arrays)
    low, high, q, F, V_ss = (np.empty(x.size) for _ in range(5))
    level = np.empty(x.size, np.int8)
    f = k.formulas
    k.turnings(
        *k.problem, f["excess"], f["bend"], t.several, ALLOWANCE, x, y, E, t.relief, low, high, q, F, V_ss, level
    )
    period = np.empty(x.size)
    k.periods(f["lean"], f["excess"], f["inertia"], low, high, x, y, E, t.relief, t.body, period)
    z = cosine(q, t.upright)
    small = np.pi * np.sqrt(2 * tippe_top.theta_inertia(z, t.body) * (4 * q / (1 + q) ** 2) / V_ss)
    inner, outer = (low, high) if t.upright == 1 else (high, low)
    angles = "inclination theta [rad] where V = E~"
    data = {
        "theta_min": labelled("theta", dims, inclination(inner, t.upright).reshape(shape), long_name="least " + angles),
        "theta_max": labelled(
            "theta", dims, inclination(outer, t.upright).reshape(shape), long_name="largest " + angles
        ),
        "theta_star": labelled("theta", dims, inclination(q, t.upright).reshape(shape), long_name="theta of least V"),
        "F": labelled("F", dims, F.reshape(shape)),
        "period": labelled("", dims, period.reshape(shape), "s", "period of nutation"),
        "small_period": labelled("", dims, small.reshape(shape), "s", "period of small nutations"),
        "level": (dims, level.reshape(shape), flags(Level, "how E~ lies to the minimum of V")),
    }
    return xr.Dataset(data, coords, attributes(t))


def band(parameters: Mapping[str, float], run: xr.Dataset, system: str = "tippe-top") -> xr.Dataset:
    """The nutational band along a run, as the main equation predicts it: theta_min(t), theta_max(t), F(t), periods.

    `run` has the momenta (routh and jellett, or L3 and Lz) and modified_energy [J] along `time`. [T 4.21, 5.26]
    """
    names = run_names(system)
    first, second, energy = (run[name] for name in names)
    found = turning_angles(parameters, first, second, energy, system)
    for name in (*names, "theta"):
        if name in run:
            found[name] = run[name]
    return found


def run_names(system: str) -> tuple[str, str, str]:
    """The variables of a run that place it in its landscape: two momenta and the energy."""
    return ("routh", "jellett", "modified_energy") if SHAPES[system].upright == 1 else ("L3", "Lz", "modified_energy")
