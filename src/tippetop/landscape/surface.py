"""The minimal surface F = inf V over a grid.

A body, t, and arrays of the two momenta go in; a labelled Dataset comes out.

Symbols
    F, q      minimum of the potential [J], and its place, see `formulas`; status: how it was found
"""

from typing import Any

import numpy as np
import xarray as xr

from .landscape_body import Top
from .landscape_labels import axis, cosine, flags, grid, inclination, labelled, momenta


def variables(t: Top, F: np.ndarray, q: np.ndarray, status: np.ndarray) -> dict[str, tuple]:
    """Return the results of `minima` as labelled variables F, z, theta and status.

    Where the infimum is approached at a pole, z and theta are those of the pole. The schema of a
    stored surface is made from this with empty arrays.
    """
    from tippetop_kernels.minimise import Status

    at_ends = [status == Status.AT_LOWER_END, status == Status.AT_UPPER_END]
    q = np.select(at_ends, [0.0, np.inf], q)
    least = "where V is least"
    z = cosine(q, t.bottom_z)
    theta = inclination(q, t.bottom_z)
    return {
        "F": labelled(t.momenta, F, "J", "minimal surface F, infimum of V over z"),
        "z": labelled(t.momenta, z, "1", f"z = cos(theta) {least}"),
        "theta": labelled(t.momenta, theta, "rad", f"theta {least}"),
        "status": (t.momenta, status, flags(Status, "how F is taken")),
    }


def minima(
    t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None
) -> tuple[np.ndarray, ...]:
    """Compute F [J], q of the minimum and `minimise.Status`, each (x.size, y.size).

    Parameters
    ----------
    t
        The body.
    x, y
        The momenta, SI, (nx,) and (ny,).
    threads
        How many; all cores if None. The result does not depend on it.
    """
    from tippetop_kernels.grid import on_threads

    from . import kernels

    c = t.coefficients
    two = t.two_wells
    F, q = np.empty((2, x.size, y.size))
    status = np.empty((x.size, y.size), np.int8)
    # s: the slice of rows of one thread
    on_threads(lambda s: kernels.minima(two, x[s], y, c, F[s], q[s], status[s]), x.size, threads)
    return F, q, status


def minimal_surface(
    t: Top,
    first: Any,
    second: Any,
    *,
    gradient: bool = True,
    threads: int | None = None,
) -> xr.Dataset:
    """Compute the minimal surface F = inf V [J] over a grid. [T 4.13]

    Parameters
    ----------
    t
        The body.
    first, second
        The two momenta, numbers or ascending numbers: D [kg m^2/s] and lambda [kg m^3/s] of a tippe
        top, L3 and Lz [kg m^2/s] of a heavy top.
    gradient
        Whether dF by both momenta is computed: F_D [1/s] and F_lambda [1/(m s)], F_L3 and F_Lz
        [1/s].
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
    InputError
        For axes that are empty or do not ascend.

    Notes
    -----
    F is good to 1 ulp (tested: 4). The minimiser is good to the rounding of dV/dln(q) over
    d2V/dln(q)^2, q = tan(theta/2)^2: some 1e-15 relative in q, hence in theta and in 1 - |z|,
    except next to the points where the minimum flattens (lambda = lambda_pi on the line theta =
    pi), where the cube root of that is left. The gradient, by the envelope theorem, is good to 3
    ulp (tested: 4).
    """
    from tippetop_kernels.grid import on_threads

    from . import kernels

    x, y = map(axis, t.momenta, (first, second))
    F, q, status = minima(t, x, y, threads)
    data = variables(t, F, q, status)
    if gradient:
        by = np.empty((2, *F.shape))
        on_threads(
            lambda s: kernels.gradients(x[s], y, t.coefficients, q[s], *by[:, s]), x.size, threads
        )
        for m, values in zip(t.landscape.momenta, by, strict=True):
            data[f"F_{m.symbol}"] = labelled(t.momenta, values, m.rate.symbol, f"dF/d{m.symbol}")
    return grid(t, data, momenta(t, x, y), (first, second))
