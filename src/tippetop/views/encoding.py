"""Arrays as text in a page."""

import base64

import numpy as np


def encode(values: np.ndarray, kind: str) -> str:
    """Return an array in base64, in the type `kind` of numpy: little-endian, as the page reads."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()
