"""Friction laws, F_h = -k g_n v_A, as records such as `Viscous(mu=0.3)`."""

from .mechanics import friction as _laws
from .mechanics.systems.cylinder import Modified


__all__ = sorted([*_laws.__all__, Modified.__name__])
globals().update({name: getattr(_laws, name) for name in _laws.__all__})
