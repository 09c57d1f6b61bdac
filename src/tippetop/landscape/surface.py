"""The minimal surface F = inf V over a grid."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..mechanics.system import System
from .body import Top, top
from .labels import at_numbers, attributes, axis, cosine, flags, inclination, labelled, of_momentum


def argmin(q: np.ndarray, status: np.ndarray, upright: int) -> tuple[np.ndarray, np.ndarray]:
    """z = cos(theta) and theta [rad] where V is least: the pole itself where the infimum is
    approached there.

    Parameters
    ----------
    q, status
        As `minima` gives them.
    upright
        z at q = 0: 1 or -1.

    Returns
    -------
    z, theta
        Of the shape of q.
    """
    from tippetop_kernels.minimise import Status

    z, theta = cosine(q, upright), inclination(q, upright)
    for end, at_q in ((Status.AT_LOWER_END, 0.0), (Status.AT_UPPER_END, np.inf)):
        pole = upright if at_q == 0 else -upright
        z[status == end] = pole
        theta[status == end] = 0.0 if pole == 1 else np.pi
    return z, theta


def minima(
    t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None
) -> tuple[np.ndarray, ...]:
    """F [J], q of the minimum and Status over x x y, each (x.size, y.size).

    Parameters
    ----------
    t
        The body.
    x, y
        The momenta, SI, (nx,) and (ny,).
    threads
        How many; all cores if None. No bit depends on it.

    Returns
    -------
    F, q, status
        F in J; status as `tippetop_kernels.minimise.Status`.
    """
    from tippetop_kernels.grid import on_threads

    from . import kernels

    c, two = t.coefficients, t.two_wells
    F, q = np.empty((x.size, y.size)), np.empty((x.size, y.size))
    status = np.empty((x.size, y.size), np.int8)
    on_threads(lambda s: kernels.minima(two, x[s], y, c, F[s], q[s], status[s]), x.size, threads)
    return F, q, status


def gradients(
    t: Top, x: np.ndarray, y: np.ndarray, q: np.ndarray, threads: int | None = None
) -> tuple[np.ndarray, ...]:
    """dF by the first and the second momentum, each (x.size, y.size); q as `minima` gives it.

    Parameters
    ----------
    t, x, y, threads
        As for `minima`.
    q
        (x.size, y.size), where V is least.

    Returns
    -------
    by_x, by_y
        Joules per unit of the momentum.
    """
    from tippetop_kernels.grid import on_threads

    from . import kernels

    by_x, by_y = np.empty_like(q), np.empty_like(q)
    on_threads(
        lambda s: kernels.gradients(x[s], y, t.coefficients, q[s], by_x[s], by_y[s]),
        x.size,
        threads,
    )
    return by_x, by_y


def minimal_surface(
    parameters: Mapping[str, float],
    first: Any,
    second: Any,
    system: str | System = "tippe-top",
    *,
    gradient: bool = True,
    threads: int | None = None,
) -> xr.Dataset:
    """The minimal surface F = inf V [J] over a grid, with where and how it is taken.

    [T 4.13 with section 5]

    Parameters
    ----------
    parameters
        The numbers of the system, SI, by name.
    first, second
        The two momenta, numbers or ascending numbers: D [kg m^2/s] and lambda [kg m^3/s] of a tippe
        top, L3 and Lz [kg m^2/s] of a heavy top.
    system
        A system that has a landscape, or its name.
    gradient
        Whether dF by both momenta is wanted: F_D [1/s] and F_lambda [1/(m s)], F_L3 and F_Lz [1/s].
    threads
        How many; all cores if None. The result does not depend on it.

    Returns
    -------
    xarray.Dataset
        F [J], z = cos(theta) and theta [rad] of the minimum, status, and the gradient, over first x
        second. `status`: attained; at_lower_end, at_upper_end: an infimum that is approached at
        theta = 0, pi (exchanged for heavy tops and pegs), the momenta being on a marked line to
        within four roundings; lower_of_two; unsettled; undefined (an argument is not finite: NaN).
        D = lambda = 0 is on the line theta = 0 (of a peg theta = pi). A momentum that is a number,
        not an array, is no dimension.

    Raises
    ------
    ValueError
        For a system without landscape, a parameter that is missing, not finite or outside its
        interval, and axes that are empty or do not ascend.

    Notes
    -----
    F is good to 1 ulp (tested: 4). The minimiser is good to the rounding of dV/dln(q) over
    d2V/dln(q)^2, q = tan(theta/2)^2: some 1e-15 relative in q, hence in theta and in 1 - |z|,
    except next to the points where the minimum flattens (lambda = lambda_pi on the line theta =
    pi), where the cube root of that is left. The gradient, by the envelope theorem, is good to 3
    ulp (tested: 4).
    """
    from tippetop_kernels.minimise import Status

    t = top(parameters, system)
    x, y = axis(t.momenta[0], first), axis(t.momenta[1], second)
    F, q, status = minima(t, x, y, threads)
    z, theta = argmin(q, status, t.upright)
    dims, momenta = t.momenta, t.landscape.momenta
    data = {
        "F": labelled("F", dims, F),
        "z": labelled("z", dims, z, long_name="z = cos(theta) where V is least"),
        "theta": labelled("theta", dims, theta, long_name="theta where V is least"),
        "status": (dims, status, flags(Status, "how F is taken")),
    }
    if gradient:
        for m, by in zip(momenta, gradients(t, x, y, q, threads), strict=True):
            data[f"F_{m.symbol}"] = labelled("", dims, by, m.rate.symbol, f"dF/d{m.symbol}")
    coords = {m.symbol: of_momentum(m, m.symbol, v) for m, v in zip(momenta, (x, y), strict=True)}
    return at_numbers(
        xr.Dataset(data, coords, attributes(t)), zip(t.momenta, (first, second), strict=True)
    )
