"""Checked problems: bodies, starts and spans, and the internal units of their integration.

`Problem` is one run. `Problems` are runs that differ only in numbers, arrays of shape (n,); the
numbers of a single run are computed there, as the case n = 1.
"""

from .batch import Problems
from .derivability import refuse
from .faults import key_faults
from .options import KEYFRAME_STEPS, ROUNDING, UNTIL
from .problem import AUTO, PRECISIONS, Problem, numbers_of
from .row_columns import PSI, TURN, column_faults, column_names


__all__ = [
    "AUTO",
    "KEYFRAME_STEPS",
    "PRECISIONS",
    "PSI",
    "ROUNDING",
    "TURN",
    "UNTIL",
    "Problem",
    "Problems",
    "column_faults",
    "column_names",
    "key_faults",
    "numbers_of",
    "refuse",
]
