"""The registry of systems: one line per system of the package; others come by `add` or by entry points.

Entry points are looked for when a name is asked for that is not known (a scan takes 10 to 70 ms): the group
`tippetop.systems` gives System records, `tippetop.friction` gives friction laws under the entry point's name.
"""

import re
import warnings
from collections.abc import Callable
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from ...errors import InputError
from .. import friction
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


def add(system: System) -> None:
    """Registers a system under its name, which must be new. Raises InputError."""
    name = system.name
    if not isinstance(name, str) or not re.fullmatch(friction.NAME, name):
        raise InputError(
            [f"the name of a system must be letters, digits, - and _, and begin with no digit, but is {name!r:.60}."]
        )
    if SYSTEMS.get(name, system) is not system:
        raise InputError([f"the name of a system must be new, but `{name}` is known."])
    SYSTEMS[name] = system


def add_law(name: str, law: friction.Law) -> None:
    """Registers a friction law under a name that no law has, of no system either. Raises InputError."""
    for system in SYSTEMS.values():
        if name in system.laws and name not in friction.LAWS:
            raise InputError([f"the name of a law must be new, but `{name}` is one of {system.name}."])
    friction.add(name, law)


def find(name: str) -> System | None:
    """The system of a name, of the package, registered, or of an entry point; None if there is none."""
    if name not in SYSTEMS:
        load_entry_points()
    return SYSTEMS.get(name)


@cache
def load_entry_points() -> None:
    """Registers, once a process, what installed packages offer; one that fails is left out with a warning."""
    groups: dict[str, Callable[[str, Any], None]] = {
        "tippetop.friction": add_law,
        "tippetop.systems": lambda _, system: add(system),
    }
    for group, register in groups.items():
        for entry in entry_points(group=group):
            try:
                register(entry.name, entry.load())
            except Exception as error:  # any package may have installed it, and broken it
                warnings.warn(f"`{entry.name}` of {group} is left out: {error}", stacklevel=2)
