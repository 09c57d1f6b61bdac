"""Turning angles, the period of nutation, and the band along a run."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..arguments import numbers
from ..columns import flagged, require
from ..errors import InputError
from ..mechanics.system import System
from .body import Top, landscape_of, top
from .labels import attributes, cosine, flags, inclination, labelled


# relative: an energy this close to the minimum touches it (the drift of a good run stays below)
ALLOWANCE = 1e-12


class Swing(NamedTuple):
    """The nutation at given momenta and energies, each (n,)."""

    low: np.ndarray  # q where V = E~, below the minimum; NaN where E~ lies below it
    high: np.ndarray  # and above
    q: np.ndarray  # where V is least
    F: np.ndarray  # V there [J]
    curvature: np.ndarray  # d2V/dln(q)^2 there [J]
    level: np.ndarray  # Level, int8
    period: np.ndarray  # [s]; NaN where it does not settle
    other: (
        np.ndarray
    )  # (2, n) q where V = E~ around a minimum that a higher V parts from this one; NaN: none


def swings(
    t: Top, x: np.ndarray, y: np.ndarray, energy: np.ndarray, theta: np.ndarray | None = None
) -> Swing:
    """The nutation at momenta x, y [SI] and energies [J], each (n,): around the lowest minimum of
    V, or in the well where theta [rad], (n,), lies.
    """
    from . import kernels

    c = t.coefficients
    low, high, q, F, curvature, period = (np.empty(x.size) for _ in range(6))
    other, level = np.full((2, x.size), np.nan), np.empty(x.size, np.int8)
    at = np.full(x.size, np.nan) if theta is None else np.tan(theta / 2) ** (2 * t.upright)
    kernels.turnings(ALLOWANCE, x, y, energy, at, c, low, high, other, q, F, curvature, level)
    turned = t.body._replace(c=abs(t.body.c))  # kernels have z = 1 at q = 0
    kernels.periods(t.system.theta_inertia)(low, high, x, y, energy, c, turned, period)
    return Swing(low, high, q, F, curvature, level, period, other)


def small_period(t: Top, swing: Swing) -> np.ndarray:
    """The period of vanishing nutations about the minimum of V [s], 2 pi sqrt(2 g/V'') by theta,
    (n,).
    """
    q = swing.q
    inertia = t.system.theta_inertia
    assert inertia is not None
    # d2V/dtheta2 = 4/sin(theta)^2 d2V/dln(q)^2, sin(theta)^2 = 4q/(1 + q)^2
    return np.pi * np.sqrt(
        2 * inertia(cosine(q, t.upright), t.body) * (4 * q / (1 + q) ** 2) / swing.curvature
    )


def turning_angles(
    parameters: Mapping[str, float],
    first: Any,
    second: Any,
    energy: Any,
    system: str | System = "tippe-top",
    *,
    theta: Any = None,
) -> xr.Dataset:
    """The two angles where V = E~, the period of nutation between them, and that of small ones.

    [T 4.12, 4.21]

    Parameters
    ----------
    parameters
        The numbers of the system, SI, by name.
    first, second
        The two momenta: D [kg m^2/s] and lambda [kg m^3/s] of a tippe top, L3 and Lz [kg m^2/s] of
        a heavy top.
    energy
        Modified energy E~ [J]. The three are broadcast against one another, with any shape;
        DataArrays keep their dimensions and coordinates.
    system
        A system that has a landscape, or its name.
    theta
        An angle [rad] of the motion, broadcast too: it says in which of two wells the body moves.
        None, NaN: in that of the lower minimum.

    Returns
    -------
    xarray.Dataset
        theta_min <= theta_star <= theta_max [rad], theta_star where V is least in this band (the
        lower of two minima, unless `theta` says otherwise), F [J] there; other_theta_min,
        other_theta_max [rad]: the band in the other well, which the body could move in with the
        same momenta and energy; NaN where there is none; `period` [s], the quadrature of the
        separated equation, NaN where it does not settle to 11 digits (nutations of some 1e-5 rad or
        less, and next to a separatrix); `small_period` [s], exact for vanishing amplitude; `level`:
        above; touching: E~ is the minimum to 1e-12, both angles are theta_star; below; undefined.

    Raises
    ------
    ValueError
        For a system without landscape, and a parameter that is missing, not finite or outside its
        interval.
    """
    from tippetop_kernels.level_crossings import Level

    t = top(parameters, system)
    given = {t.momenta[0]: first, t.momenta[1]: second, "energy": energy}
    (x, y, E, at), shape, dims, coords = _aligned(**given, theta=np.nan if theta is None else theta)
    swing = swings(t, x, y, E, at)
    inner, outer = (swing.low, swing.high) if t.upright == 1 else (swing.high, swing.low)
    others = swing.other[:: t.upright]
    angles = "inclination theta [rad] where V = E~"

    def angle(q: np.ndarray, long_name: str) -> tuple:
        return labelled(
            "theta", dims, inclination(q, t.upright).reshape(shape), long_name=long_name
        )

    data = {
        "theta_min": angle(inner, "least " + angles),
        "theta_max": angle(outer, "largest " + angles),
        "theta_star": angle(swing.q, "theta of least V"),
        "other_theta_min": angle(others[0], "least " + angles + " in the other well"),
        "other_theta_max": angle(others[1], "largest " + angles + " in the other well"),
        "F": labelled("F", dims, swing.F.reshape(shape)),
        "period": labelled("", dims, swing.period.reshape(shape), "s", "period of nutation"),
        "small_period": labelled(
            "", dims, small_period(t, swing).reshape(shape), "s", "period of small nutations"
        ),
        "level": (
            dims,
            swing.level.reshape(shape),
            flags(Level, "how E~ lies to the minimum of V"),
        ),
    }
    return xr.Dataset(data, coords, attributes(t))


def band(
    parameters: Mapping[str, float], run: xr.Dataset, system: str | System = "tippe-top"
) -> xr.Dataset:
    """The nutational band along a run, as the main equation predicts it; none while the body flies.

    [T 4.21, 5.26]

    Parameters
    ----------
    parameters
        The numbers of the system, SI, by name.
    run
        The trajectory of a run: the momenta (routh and jellett, or L3 and Lz) and modified_energy
        [J] along `time`; theta [rad], if it is there, chooses between two wells.
    system
        A system that has a landscape, or its name.

    Returns
    -------
    xarray.Dataset
        As `turning_angles`, along the time of the run: theta_min(t), theta_max(t), F(t), periods;
        with the momenta, the energy and theta of the run.

    Raises
    ------
    ValueError
        As `turning_angles`.
    """
    names = landscape_of(system)[1].columns
    if not isinstance(run, xr.Dataset):
        raise InputError([f"`run` must be the trajectory of a run, a Dataset, but is {run!r:.60}."])
    require(names, run, "the band along a run")
    first, second, energy = (run[name] for name in names)
    angles = turning_angles(parameters, first, second, energy, system, theta=run.get("theta"))
    if "phase" in run:
        angles = angles.where(
            ~xr.DataArray(flagged(run["phase"], "flight"), dims=run["phase"].dims)
        )
    for name in (*names, "theta"):
        if name in run:
            angles[name] = run[name]
    return angles


def _aligned(**arguments: Any) -> tuple[tuple[np.ndarray, ...], tuple[int, ...], tuple, dict]:
    """Arguments broadcast against one another, each (n,); and their shape, dimensions and
    coordinates. Raises InputError.
    """
    arrays: list[Any] = [
        a if isinstance(a, xr.DataArray) else numbers(name, a) for name, a in arguments.items()
    ]
    if any(isinstance(a, xr.DataArray) for a in arrays):
        arrays = list(
            xr.broadcast(*(a if isinstance(a, xr.DataArray) else xr.DataArray(a) for a in arrays))
        )
        dims, coords = arrays[0].dims, dict(arrays[0].coords)
    else:
        try:
            arrays = list(np.broadcast_arrays(*arrays))
        except ValueError:
            shapes = ", ".join(
                f"{name} {array.shape}" for name, array in zip(arguments, arrays, strict=True)
            )
            raise InputError(
                [f"momenta, energy and theta must have shapes that broadcast, but have {shapes}."]
            ) from None
        dims, coords = tuple(f"dim_{i}" for i in range(arrays[0].ndim)), {}
    flat = tuple(np.ascontiguousarray(np.asarray(a, dtype=float).ravel()) for a in arrays)
    return flat, arrays[0].shape, dims, coords
