"""What is to be integrated: checked bodies, starts and spans, and the units in which they are
integrated.

`Problem` is one run. `Problems` are many that differ in numbers only, arrays of shape (n,);
everything that is computed of a run is computed there, and a single run is the case n = 1.
"""

from .choice import AUTO, Choice, choice
from .differentiable import MOST_DERIVATIVES, derivative_faults, kept_faults, refuse
from .faults import key_faults, shape_faults, variation_faults
from .kept import ORIENTATION, PSI, TURN, column_faults, column_names
from .many import Problems
from .one import PRECISIONS, Problem
from .options import KEYFRAME_STEPS, ROUNDING, UNTIL


__all__ = [
    "AUTO",
    "KEYFRAME_STEPS",
    "MOST_DERIVATIVES",
    "ORIENTATION",
    "PRECISIONS",
    "PSI",
    "ROUNDING",
    "TURN",
    "UNTIL",
    "Choice",
    "Problem",
    "Problems",
    "choice",
    "column_faults",
    "column_names",
    "derivative_faults",
    "kept_faults",
    "key_faults",
    "refuse",
    "shape_faults",
    "variation_faults",
]
