"""The registry: one line per system."""

from ..system import System
from .tippe_top import TIPPE_TOP


SYSTEMS: dict[str, System] = {system.name: system for system in (TIPPE_TOP,)}
