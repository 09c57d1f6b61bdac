"""The theory of tops: thresholds, regimes, modes, asymptotic states, main equation."""

from .library.asymptotics import asymptotic_states, least_energy
from .library.theory import linear_modes, reconstruct, regime, thresholds


__all__ = [
    "asymptotic_states",
    "least_energy",
    "linear_modes",
    "reconstruct",
    "regime",
    "thresholds",
]
