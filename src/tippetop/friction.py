"""Friction laws, F_h = -k g_n v_A, as records such as `Viscous(mu=0.3)`."""

from .mechanics import friction as _laws
from .mechanics.friction import *  # noqa: F403
from .mechanics.systems.cylinder import Modified


__all__ = sorted([*_laws.__all__, Modified.__name__])
