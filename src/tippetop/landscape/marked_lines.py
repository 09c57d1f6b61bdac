"""The two spinning states of a tippe top as lines on the minimal surface."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ..mechanics.systems import spinning
from .body import attributes, axis, labelled, top


# --- the spinning states --------------------------------------------------------------------------------------------


def marked_lines(parameters: Mapping[str, float], lam: Any) -> xr.Dataset:
    """The spinning states theta = 0, pi of a tippe top with Jellett's integral `lam` [kg m^3/s]: boundary values.

    D [kg m^2/s], E~ [J], omega_3 [rad/s] of each `end`, and whether it lies on the minimal surface: theta = 0 always,
    theta = pi iff |lambda| >= lambda_pi (an attribute). [T 4.23-4.28; 5.1]
    """
    t = top(parameters)
    lam, z = axis("lambda", lam), np.array([1.0, -1.0])
    lam_pi = float(spinning.lambda_pi(t.body))
    Z, Lam = z[:, None], lam[None, :]
    dims = ("end", "lambda")
    return xr.Dataset(
        {
            "D": labelled("D", dims, spinning.momentum(Z, Lam, t.body)),
            "E": labelled("E", dims, spinning.energy(Z, Lam, t.body), "J", "modified energy E~ of the spinning state"),
            "omega3": labelled("omega3", dims, spinning.spin(Z, Lam, t.body), "rad s-1", "spin omega_3"),
            "on_surface": (dims, (Z > 0) | (np.abs(Lam) >= lam_pi), {"long_name": "E~ = F there"}),
        },
        {"end": ["theta = 0", "theta = pi"], "lambda": labelled("lambda", "lambda", lam)},
        attributes(t, lambda_pi=lam_pi),
    )
