"""The compiled kernels of the landscape and the formulas that they are given."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from . import formulas


class Kernels(NamedTuple):
    """The kernels and the formulas that they are given, compiled at first use."""

    minima: Any
    heights: Any
    gradients: Any
    potentials: Any
    turnings: Any
    wells: Any
    periods: Any
    problem: tuple  # prepare, guess, slopes, value, ends
    formulas: dict[str, Any]


INLINED = ("at_momenta", "guess", "slopes", "value", "ends", "gradient", "surface_gradient")
CALLED = ("curvature", "excess")  # from many places: not inlined, which saves a third of the compilation


@cache
def kernels() -> Kernels:
    """The kernels; numba is imported here and in the functions that run them, when they are first called."""
    from tippetop_kernels import grid
    from tippetop_kernels.jit import inlined, kernel
    from tippetop_kernels.staging import in_stages

    inner = {name: inlined(getattr(formulas, name)) for name in INLINED}
    for name, stages in formulas.STAGES.items():
        in_stages(inner[name], *(inlined(stage) for stage in stages))
    inner |= {name: kernel(getattr(formulas, name)) for name in CALLED}
    return Kernels(
        grid.minima,
        grid.heights,
        grid.gradients,
        grid.potentials,
        grid.turnings,
        grid.wells,
        grid.periods,
        tuple(inner[name] for name in ("at_momenta", "guess", "slopes", "value", "ends")),
        inner,
    )


@cache
def compiled(formula: Callable) -> Any:
    """A formula of a system, theta_inertia(z, b), for the kernels."""
    from tippetop_kernels.jit import inlined

    return inlined(formula)
