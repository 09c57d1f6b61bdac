"""The registry: one line per system."""

from ..system import System
from .cylinder import GLIDING_CYLINDER
from .gliding_heavy_top import GLIDING_HEAVY_TOP
from .heavy_top import HEAVY_TOP
from .rolling_cylinder import ROLLING_CYLINDER
from .rolling_tippe_top import ROLLING_TIPPE_TOP
from .tippe_top import TIPPE_TOP


SYSTEMS: dict[str, System] = {
    system.name: system
    for system in (TIPPE_TOP, ROLLING_TIPPE_TOP, GLIDING_HEAVY_TOP, HEAVY_TOP, GLIDING_CYLINDER, ROLLING_CYLINDER)
}
