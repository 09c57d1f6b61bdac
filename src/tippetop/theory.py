"""The theory of tops: thresholds, regimes, modes, asymptotic states, nutation, main equation."""

from .library.asymptotics import accelerations, asymptotic_states, least_energy
from .library.theory import linear_modes, nutation, reconstruct, regime, thresholds


__all__ = [
    "accelerations",
    "asymptotic_states",
    "least_energy",
    "linear_modes",
    "nutation",
    "reconstruct",
    "regime",
    "thresholds",
]
