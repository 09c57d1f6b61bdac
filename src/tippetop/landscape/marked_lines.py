"""The two spinning states of a tippe top as lines on the minimal surface.

A body and lambda go in, a labelled Dataset comes out.
"""

from typing import Any

import numpy as np
import xarray as xr

from ..mechanics.theory import spinning
from ..mechanics.theory.thresholds import spin
from .landscape_body import Top
from .landscape_labels import attributes, axis, labelled, momenta


def marked_lines(t: Top, lam: Any) -> xr.Dataset:
    """Compute the lines of the spinning states theta = 0, pi on the minimal surface. [T 4.23-4.28]

    Parameters
    ----------
    t
        A tippe top.
    lam
        Jellett's integral lambda [kg m^3/s], a number or ascending numbers, (n,).

    Returns
    -------
    xarray.Dataset
        Over `end` (theta = 0, theta = pi) and `lambda`, (2, n): D [kg m^2/s], E, the energy E~ [J],
        omega3 [rad/s], and on_surface, whether E~ = F there. The spin with the centre of mass
        lowest (theta = 0, of a peg theta = pi) is always on the surface; the other one iff |lambda|
        >= lambda_pi, which is an attribute [kg m^3/s].

    Raises
    ------
    InputError
        For another body, for an empty axis, and for numbers that do not ascend.
    """
    t.require_spinning()
    lam = axis("lambda", lam)
    dims = ("end", "lambda")
    lam_pi = float(spinning.lambda_pi(t.body))
    Z = np.array([[1.0], [-1.0]])
    Lam = lam[None, :]
    D = spinning.momentum(Z, Lam, t.body)
    energy = spinning.energy(Z, Lam, t.body)
    on_surface = (t.bottom_z == Z) | (np.abs(Lam) >= lam_pi)
    return xr.Dataset(
        {
            **momenta(t, D, lam, dims=dims),
            "E": labelled(dims, energy, "J", "modified energy E~ of the spinning state"),
            "omega3": labelled(dims, spin(Z, Lam, t.body), "rad s-1", "spin omega_3"),
            "on_surface": (dims, on_surface, {"long_name": "E~ = F there"}),
        },
        {"end": ["theta = 0", "theta = pi"]},
        attributes(t) | {"lambda_pi": lam_pi},
    )
