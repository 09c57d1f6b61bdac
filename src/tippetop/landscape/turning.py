"""Turning angles, the period of nutation, and the band along a run.

A body, momenta and energies go in; labelled Datasets come out. `kernels` computes the crossings.
"""

from typing import Any

import numpy as np
import xarray as xr

from ..arguments import numbers
from ..columns import flagged, require
from ..errors import InputError
from .landscape_body import Top
from .landscape_labels import attributes, cosine, flags, inclination, labelled


# relative: an energy this close to the minimum touches it (the drift of a good run stays below)
ALLOWANCE = 1e-12


def turning_angles(
    t: Top,
    first: Any,
    second: Any,
    energy: Any,
    *,
    theta: Any = None,
) -> xr.Dataset:
    """Compute the angles where V = E~ and the periods of this and of small nutations.

    [T 4.12, 4.21]

    Parameters
    ----------
    t
        The body.
    first, second
        The two momenta: D [kg m^2/s] and lambda [kg m^3/s] of a tippe top, L3 and Lz [kg m^2/s] of
        a heavy top.
    energy
        Modified energy E~ [J]. The three are broadcast against one another, with any shape;
        DataArrays keep their dimensions and coordinates.
    theta
        An angle [rad] of the motion, broadcast too: it selects one of two wells.
        None, NaN: that of the lower minimum.

    Returns
    -------
    xarray.Dataset
        theta_min <= theta_star <= theta_max [rad], theta_star where V is least in this band (the
        lower of two minima, unless `theta` selects the other), F [J] there; other_theta_min,
        other_theta_max [rad]: the band in the other well, which the body could move in with the
        same momenta and energy; NaN where there is none; `period` [s], the quadrature of the
        separated equation, NaN where it does not settle to 11 digits (nutations of some 1e-5 rad or
        less, and next to a separatrix); `small_period` [s], exact for vanishing amplitude; `level`:
        above; touching: E~ is the minimum to 1e-12, both angles are theta_star; below; undefined.
    """
    from tippetop_kernels.level_crossings import Level

    from . import kernels

    given = {t.momenta[0]: first, t.momenta[1]: second, "energy": energy}
    aligned = _aligned(**given, theta=np.nan if theta is None else theta)
    x, y, E, at = (np.array(a.values, float).ravel() for a in aligned)
    at = np.tan(at / 2) ** (2 * t.bottom_z)  # q of theta, the inverse of `inclination`
    c = t.coefficients
    inertia = t.system.theta_inertia
    assert inertia is not None
    level = np.empty(x.size, np.int8)
    found = np.empty((8, x.size))
    turned = t.body._replace(c=abs(t.body.c))  # kernels have z = 1 at q = 0
    kernels.turnings(inertia)(ALLOWANCE, x, y, E, at, c, turned, level, found)
    low, high, q, F, curvature, period, *other = found  # in the order of the kernel
    # 2 pi sqrt(2 g/V''): d2V/dtheta2 = 4/sin(theta)^2 d2V/dln(q)^2, sin(theta)^2 = 4q/(1 + q)^2
    square = 2 * inertia(cosine(q, t.bottom_z), t.body) * (4 * q / (1 + q) ** 2) / curvature
    # theta falls with q where the pole q = 0 is theta = pi
    (inner, outer), others = (low, high)[:: t.bottom_z], other[:: t.bottom_z]
    angles = "inclination theta [rad] where V = E~"
    second_well = "in the other well"
    dims = aligned[0].dims
    shape = aligned[0].shape

    def over(values: np.ndarray, units: str, long_name: str) -> tuple:
        """Return values as a labelled variable over the dimensions of the arguments."""
        return labelled(dims, values.reshape(shape), units, long_name)

    def angle(q: np.ndarray, long_name: str) -> tuple:
        """Return theta of q as a labelled variable [rad]."""
        return over(inclination(q, t.bottom_z), "rad", long_name)

    data = {
        "theta_min": angle(inner, f"least {angles}"),
        "theta_max": angle(outer, f"largest {angles}"),
        "theta_star": angle(q, "theta of least V"),
        "other_theta_min": angle(others[0], f"least {angles} {second_well}"),
        "other_theta_max": angle(others[1], f"largest {angles} {second_well}"),
        "F": over(F, "J", "minimal surface F, infimum of V over z"),
        "period": over(period, "s", "period of nutation"),
        "small_period": over(np.pi * np.sqrt(square), "s", "period of small nutations"),
        "level": (dims, level.reshape(shape), flags(Level, "how E~ lies to the minimum of V")),
    }
    return xr.Dataset(data, aligned[0].coords, attributes(t))


def band(t: Top, run: xr.Dataset) -> xr.Dataset:
    """Compute the predicted band along a run, NaN while the body flies. [T 4.21, 5.26]

    Parameters
    ----------
    t
        The body.
    run
        The trajectory of a run: the momenta (routh and jellett, or L3 and Lz) and modified_energy
        [J] along `time`; theta [rad], if it is there, selects one of two wells.

    Returns
    -------
    xarray.Dataset
        As `turning_angles`, along the time of the run: theta_min(t), theta_max(t), F(t), periods;
        with the momenta, the energy and theta of the run.
    """
    names = t.landscape.columns
    require(names, run, "the band along a run")
    first, second, energy = (run[name] for name in names)
    angles = turning_angles(t, first, second, energy, theta=run.get("theta"))
    if "phase" in run:
        angles = angles.where(~run["phase"].copy(data=flagged(run["phase"], "flight")))
    return angles.assign({name: run[name] for name in (*names, "theta") if name in run})


def _aligned(**arguments: Any) -> tuple[xr.DataArray, ...]:
    """Return arguments, numbers or arrays by name, broadcast against one another as DataArrays.

    DataArrays are aligned by their dimensions, others by their shapes. Raises InputError.
    """
    arrays: list[Any] = [
        a if isinstance(a, xr.DataArray) else numbers(name, a) for name, a in arguments.items()
    ]
    try:
        if not any(isinstance(a, xr.DataArray) for a in arrays):
            arrays = list(np.broadcast_arrays(*arrays))
        return xr.broadcast(*map(xr.DataArray, arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in zip(arguments, arrays, strict=True))
        raise InputError(
            f"momenta, energy and theta must have shapes that broadcast, but have {shapes}."
        ) from None
