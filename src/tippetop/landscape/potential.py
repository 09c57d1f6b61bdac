"""The effective potential V over a grid."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from .body import attributes, axis, kernels, labelled, top


# --- the potential --------------------------------------------------------------------------------------------------


def potential(
    parameters: Mapping[str, float], z: Any, first: Any, second: Any, system: str = "tippe-top"
) -> xr.Dataset:
    """V [J] and its derivatives by z over the grid z x first x second, dimensions of length one dropped.

    `z` = cos(theta) in (-1, 1), ascending; first and second momentum are D [kg m^2/s] and lambda [kg m^3/s] for tippe
    tops, L3 and Lz [kg m^2/s] for heavy tops. No digits are lost near the poles: 1 - z is exact there, and X is formed
    without cancellation. Outside (-1, 1), at z = +-1 too, and for infinite arguments V is NaN: it is +oo at a pole off
    the marked line; the end values on it are those of `marked_lines`. [T 4.12, 2.38, 5.26]
    """
    t, k = top(parameters, system), kernels()
    z, x, y = axis("z", z), axis(t.momenta[0], first), axis(t.momenta[1], second)
    V, V_z, V_zz = (np.empty((z.size, x.size, y.size)) for _ in range(3))
    f = k.formulas
    with np.errstate(invalid="ignore"):
        k.potentials(f["lean"], f["slopes"], f["value"], t.upright * z, x, y, t.relief, V, V_z, V_zz)
    dims = ("z", *t.momenta)
    scale = 1 / t.relief.gamma.head
    return xr.Dataset(
        {
            "V": labelled("V", dims, V),
            "V_z": labelled("V_z", dims, V_z * (t.upright * scale), "J", "dV/dz"),
            "V_zz": labelled("V_zz", dims, V_zz * scale, "J", "d2V/dz2"),
        },
        {
            "z": labelled("z", "z", z),
            t.momenta[0]: labelled(t.momenta[0], t.momenta[0], x),
            t.momenta[1]: labelled(t.momenta[1], t.momenta[1], y),
            "theta": labelled("theta", "z", np.arccos(np.clip(z, -1, 1))),
        },
        attributes(t),
    ).squeeze([d for d in t.momenta if {t.momenta[0]: x, t.momenta[1]: y}[d].size == 1])
