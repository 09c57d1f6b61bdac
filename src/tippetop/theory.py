"""The theory of tops: thresholds, regimes, modes, asymptotic states, main equation."""

from .library.theory import (
    asymptotic_states,
    least_energy,
    linear_modes,
    reconstruct,
    regime,
    thresholds,
)


__all__ = [
    "asymptotic_states",
    "least_energy",
    "linear_modes",
    "reconstruct",
    "regime",
    "thresholds",
]
