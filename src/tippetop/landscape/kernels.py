"""The compiled kernels of the landscape; imported when a grid is computed.

Formulas of `formulas` go into kernels of `tippetop_kernels.grid`; `surface` and `turning` call
them.
"""

from collections.abc import Callable
from functools import cache

from tippetop_kernels import grid
from tippetop_kernels.compilation import Entry, inlined

from .formulas import (
    at_momenta,
    curvature,
    excess,
    guess,
    reaches_pole,
    slope,
    slopes,
    surface_gradient,
    value,
)


# the arguments have the order of parameters of `tippetop_kernels.grid`
minima = grid.minima(at_momenta, guess, slopes, slope, value, reaches_pole)
gradients = grid.gradients(at_momenta, surface_gradient)


@cache
def turnings(theta_inertia: Callable) -> Entry:
    """Return the kernel of turning angles and periods for the theta_inertia(z, b) of a system.

    Cached, because another object would be compiled again. The kernel takes z = 1 at q = 0.
    """
    return grid.turnings(at_momenta, slope, value, excess, curvature, inlined(theta_inertia))
