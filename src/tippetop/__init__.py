"""tippetop: tops that roll and glide, integrated to rounding, with their events, potentials and surfaces.

>>> import tippetop
>>> run = tippetop.run("inverting", until=8)
>>> print(run)
>>> trajectory = tippetop.datasets(run)["trajectory"]
"""

from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .api import integrate as integrate
    from .api import load as load
    from .api import run as run
    from .archive import open_group as open_group
    from .ensembles import ensemble as ensemble
    from .friction import LAWS as LAWS
    from .landscape import band as band
    from .landscape import marked_lines as marked_lines
    from .landscape import minimal_surface as minimal_surface
    from .landscape import potential as potential
    from .landscape import turning_angles as turning_angles
    from .problem import Problem as Problem
    from .results import datasets as datasets
    from .scenario import ScenarioError as ScenarioError
    from .sweep_report import gridded as gridded
    from .sweeping import sweep as sweep
    from .systems import SYSTEMS as SYSTEMS

_PLACES = {
    "integrate": "api",
    "load": "api",
    "run": "api",
    "open_group": "archive",
    "ensemble": "ensembles",
    "LAWS": "friction",
    "band": "landscape",
    "marked_lines": "landscape",
    "minimal_surface": "landscape",
    "potential": "landscape",
    "turning_angles": "landscape",
    "Problem": "problem",
    "datasets": "results",
    "ScenarioError": "scenario",
    "gridded": "sweep_report",
    "sweep": "sweeping",
    "SYSTEMS": "systems",
}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    """Public names, imported when first used: `tippetop --help` must not wait for LLVM."""
    if name not in _PLACES:
        raise AttributeError(f"module 'tippetop' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_PLACES[name]}", __name__), name)
