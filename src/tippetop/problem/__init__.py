"""What is to be integrated: checked bodies, starts and spans, and the units in which they are integrated.

`Problem` is one run. `Problems` are many that differ in numbers only, arrays of shape (n,); everything that is computed
of a run is computed there, and a single run is the case n = 1.
"""

from .choice import AUTO, Choice, choice
from .faults import key_faults, variation_faults
from .kept import ORIENTATION, PSI, TURN, column_faults, column_names
from .many import Problems
from .one import KEYFRAME_STEPS, PRECISIONS, ROUNDING, UNTIL, Problem


__all__ = [
    "AUTO",
    "KEYFRAME_STEPS",
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
    "key_faults",
    "variation_faults",
]
