"""Derivatives of runs by their numbers, and the growth of errors of their start."""

from .library.derivatives import Sensitivities, lyapunov, sensitivities


__all__ = ["Sensitivities", "lyapunov", "sensitivities"]
