"""The minimal surface F = inf V over a grid."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from .body import Top, attributes, axis, cosine, flags, inclination, kernels, labelled, top


def argmin(q: np.ndarray, status: np.ndarray, upright: int) -> np.ndarray:
    """z where V is least: the pole itself where the infimum is approached there."""
    from tippetop_kernels.minimise import Status

    z = cosine(q, upright)
    z[status == Status.AT_LOWER_END] = upright
    z[status == Status.AT_UPPER_END] = -upright
    return z


# --- the minimal surface --------------------------------------------------------------------------------------------


def minima(t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None) -> tuple[np.ndarray, ...]:
    """F [J], q of the minimum and Status over x x y, each (x.size, y.size)."""
    from tippetop_kernels.grid import on_threads

    k = kernels()
    F, q = np.empty((x.size, y.size)), np.empty((x.size, y.size))
    status = np.empty((x.size, y.size), np.int8)
    on_threads(lambda s: k.minima(*k.problem, t.several, x[s], y, t.relief, F[s], q[s], status[s]), x.size, threads)
    return F, q, status


def heights(t: Top, x: np.ndarray, y: np.ndarray, threads: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """F [J] and Status alone over x x y, in four fifths of the time; F is as good as that of `minima`."""
    from tippetop_kernels.grid import on_threads

    k, F, status = kernels(), np.empty((x.size, y.size)), np.empty((x.size, y.size), np.int8)
    on_threads(lambda s: k.heights(*k.problem, t.several, x[s], y, t.relief, F[s], status[s]), x.size, threads)
    return F, status


def minimal_surface(
    parameters: Mapping[str, float],
    first: Any,
    second: Any,
    system: str = "tippe-top",
    *,
    gradient: bool = True,
    threads: int | None = None,
) -> xr.Dataset:
    """F = inf V [J] over the grid first x second (D x lambda, or L3 x Lz), with where and how it is taken.

    F is good to 1 ulp (tested: 4). The minimiser, z = cos(theta) and theta [rad], is good to the rounding of dV/dln(q)
    over d2V/dln(q)^2, q = tan(theta/2)^2: some 1e-15 relative in q, hence in theta and in 1 - |z|, except next to the
    points where the minimum flattens (lambda = lambda_pi on the line theta = pi), where the cube root of that is left.
    With `gradient`, F_D and F_lambda by the envelope theorem, to 1e-13 of the larger of |F_D|, F/|D| (likewise lambda).

    `status`: attained; at_lower_end, at_upper_end: an infimum that is approached at theta = 0, pi (exchanged for heavy
    tops), D and lambda being on a marked line to within four roundings; lower_of_two; unsettled; undefined (an argument
    is not finite: NaN). D = lambda = 0 is on the line theta = 0. Raises ValueError for axes that are empty or do not
    ascend. [T 4.13 with section 5]
    """
    from tippetop_kernels.minimise import Status

    t = top(parameters, system)
    x, y = axis(t.momenta[0], first), axis(t.momenta[1], second)
    F, q, status = minima(t, x, y, threads)
    dims = t.momenta
    z, theta = argmin(q, status, t.upright), inclination(q, t.upright)
    theta[status == Status.AT_LOWER_END] = 0.0 if t.upright == 1 else np.pi
    theta[status == Status.AT_UPPER_END] = np.pi if t.upright == 1 else 0.0
    data = {
        "F": labelled("F", dims, F),
        "z": labelled("z", dims, z, long_name="z = cos(theta) where V is least"),
        "theta": labelled("theta", dims, theta, long_name="theta where V is least"),
        "status": (dims, status, flags(Status, "how F is taken")),
    }
    if gradient:
        from tippetop_kernels.grid import on_threads

        k, by_x, by_y = kernels(), np.empty_like(F), np.empty_like(F)
        f = k.formulas
        on_threads(
            lambda s: k.gradients(f["lean"], f["gradient"], x[s], y, t.relief, q[s], by_x[s], by_y[s]), x.size, threads
        )
        units = {"D": "s-1", "lambda": "m-1 s-1", "L3": "s-1", "Lz": "s-1"}
        for name, by in zip(dims, (by_x, by_y), strict=True):
            data[f"F_{name}"] = labelled("", dims, by, units[name], f"dF/d{name}")
    coords = {name: labelled(name, name, v) for name, v in zip(dims, (x, y), strict=True)}
    return xr.Dataset(data, coords, attributes(t))
