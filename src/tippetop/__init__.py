"""tippetop: tops that roll and glide, integrated to rounding, with their events, potentials and surfaces.

>>> import tippetop
>>> run = tippetop.run("inverting", until=8)
>>> print(run)
>>> trajectory = tippetop.datasets(run)["trajectory"]
"""

from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .ensembles.ensemble import ensemble as ensemble
    from .errors import InputError as InputError
    from .landscape.marked_lines import marked_lines as marked_lines
    from .landscape.potential import potential as potential
    from .landscape.surface import minimal_surface as minimal_surface
    from .landscape.turning import band as band
    from .landscape.turning import turning_angles as turning_angles
    from .mechanics.friction import LAWS as LAWS
    from .mechanics.systems import SYSTEMS as SYSTEMS
    from .problem import Problem as Problem
    from .runs.attributes import datasets as datasets
    from .runs.run import run as run
    from .runs.run import solve as integrate  # noqa: F401
    from .scenario.build import load as load
    from .store.root import open_group as open_group
    from .sweeps.summary import gridded as gridded
    from .sweeps.sweep import sweep as sweep

_PLACES = {
    "run": ("runs.run", "run"),
    "integrate": ("runs.run", "solve"),
    "load": ("scenario.build", "load"),
    "open_group": ("store.root", "open_group"),
    "ensemble": ("ensembles.ensemble", "ensemble"),
    "LAWS": ("mechanics.friction", "LAWS"),
    "band": ("landscape.turning", "band"),
    "marked_lines": ("landscape.marked_lines", "marked_lines"),
    "minimal_surface": ("landscape.surface", "minimal_surface"),
    "potential": ("landscape.potential", "potential"),
    "turning_angles": ("landscape.turning", "turning_angles"),
    "Problem": ("problem", "Problem"),
    "datasets": ("runs.attributes", "datasets"),
    "InputError": ("errors", "InputError"),
    "gridded": ("sweeps.summary", "gridded"),
    "sweep": ("sweeps.sweep", "sweep"),
    "SYSTEMS": ("mechanics.systems", "SYSTEMS"),
}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    """Public names, imported when first used: `tippetop --help` must not wait for LLVM."""
    if name not in _PLACES:
        raise AttributeError(f"module 'tippetop' has no attribute {name!r}")
    from importlib import import_module

    module, attribute = _PLACES[name]
    return getattr(import_module(f".{module}", __name__), attribute)
