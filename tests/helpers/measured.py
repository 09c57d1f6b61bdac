"""Tables of measurements in files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np


AXIS = "axis_x,axis_y,axis_z"


def written(path: Path, columns: Mapping[str, Any]) -> Path:
    """Write columns, or several under one header with commas, as CSV with all their digits."""
    table = np.column_stack([*columns.values()])
    np.savetxt(path, table, "%.17g", ",", header=",".join(columns), comments="")
    return path
