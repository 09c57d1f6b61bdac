"""Friction laws, F_h = -k g_n v_A, as records such as `Viscous(mu=0.3)`."""

from .mechanics.friction import Contensou, Coulomb, Frictionless, Latitude, Mixed, Stribeck, Viscous
from .mechanics.systems.cylinder import Modified


__all__ = [
    "Contensou",
    "Coulomb",
    "Frictionless",
    "Latitude",
    "Mixed",
    "Modified",
    "Stribeck",
    "Viscous",
]
