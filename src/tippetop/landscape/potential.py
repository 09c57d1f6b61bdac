"""The effective potential V over a grid.

A body, z = cos(theta) and momenta go in, a labelled Dataset comes out.
"""

from typing import Any

import numpy as np
import xarray as xr

from .formulas import at_momenta, slopes, value
from .landscape_body import Top
from .landscape_labels import axis, grid, labelled, momenta


def potential(t: Top, z: Any, first: Any, second: Any) -> xr.Dataset:
    """Compute V of a top and its derivatives by z over a grid. [T 4.12, 2.38, 5.26]

    Parameters
    ----------
    t
        The body.
    z
        cos(theta) in (-1, 1), a number or ascending numbers.
    first, second
        The two momenta, numbers or ascending numbers: D [kg m^2/s] and lambda [kg m^3/s] of a tippe
        top, L3 and Lz [kg m^2/s] of a heavy top.

    Returns
    -------
    xarray.Dataset
        V, V_z and V_zz [J] over z and both momenta, by their symbols; arguments that are numbers,
        not arrays, are no dimensions. No digits are lost near the poles: 1 - z is exact there, and
        X is formed without cancellation. Outside (-1, 1), at z = +-1 too, and for infinite
        arguments V is NaN: it is +oo at a pole off the marked line; the end values on it are those
        of `marked_lines`.

    Raises
    ------
    InputError
        For axes that are empty or do not ascend.
    """
    given = z, first, second
    z, x, y = map(axis, ("z", *t.momenta), given)
    V, V_z, V_zz = np.empty((3, z.size, x.size, y.size))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        cosine = np.where(np.abs(z) < 1, t.bottom_z * z, np.nan)[:, None]
        # tan(theta/2)^2, or cot(theta/2)^2 where the pole q = 0 is theta = pi
        q = (1 - cosine) / (1 + cosine)
        w = (1 - cosine) * (1 + cosine)
        for i, one in enumerate(x):  # not all at a time: formulas need much memory
            p = at_momenta(one, y, t.coefficients)
            V[:, i] = value(q, p, t.coefficients)
            g1, g2, _ = slopes(q, p, t.coefficients)
            # by the chain rule, dln(q)/dz = -2/(1 - z^2); the factor gamma follows in `scale`
            V_z[:, i] = -2 * g1 / (q * w)
            V_zz[:, i] = 4 * (g2 - cosine * g1) / (q * w * w)
    dims = ("z", *t.momenta)
    scale = 1 / t.coefficients.gamma.head
    data = {
        "V": labelled(dims, V, "J", "effective potential V"),
        # an odd derivative changes its sign where q is seen upside down
        "V_z": labelled(dims, V_z * (t.bottom_z * scale), "J", "dV/dz"),
        "V_zz": labelled(dims, V_zz * scale, "J", "d2V/dz2"),
    }
    theta = labelled("z", np.arccos(np.clip(z, -1, 1)), "rad", "inclination theta of the axis")
    axes = {"z": labelled("z", z, "1", "z = cos(theta)"), **momenta(t, x, y), "theta": theta}
    return grid(t, data, axes, given)
