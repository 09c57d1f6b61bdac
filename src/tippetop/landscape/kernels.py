"""The compiled kernels of the landscape, bound to its formulas. Imported only where a grid is computed."""

from functools import cache

from tippetop_kernels import grid
from tippetop_kernels.compilation import inlined
from tippetop_kernels.staging import in_stages

from .formulas import STAGES, at_momenta, curvature, ends, excess, guess, slopes, surface_gradient, value


for _formula, _stages in STAGES.items():
    in_stages(_formula, *_stages)
PROBLEM = at_momenta, guess, slopes, value, ends
minima = grid.minima(*PROBLEM)
heights = grid.heights(*PROBLEM)
gradients = grid.gradients(at_momenta, surface_gradient)
potentials = grid.potentials(at_momenta, slopes, value)
turnings = grid.turnings(*PROBLEM, excess, curvature)
wells = grid.wells(at_momenta, slopes, value, excess, curvature)


@cache
def periods(theta_inertia):
    """Return the kernel of periods for the theta_inertia(z, b) of a system."""
    return grid.periods(at_momenta, excess, inlined(theta_inertia))
