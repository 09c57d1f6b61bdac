"""Residuals of measured attitudes, in as many numbers as noise has directions."""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion


def of_axis(seen: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Return the chords between unit vectors (rows, 3), across the measured one, (rows, 2).

    The noise of an axis has two directions, not three.
    """
    pole = np.where(seen[:, 2:] < 0, -1.0, 1.0) * [[0.0, 0.0, 1.0]]
    swing = rotation.swing(Vector(*pole.T), Vector(*seen.T))
    # (2, space, rows)
    across = np.array([rotation.rotated(swing, Vector(*e)) for e in np.eye(3)[:2]])
    apart = np.einsum("ixr,rx->ri", across, third)
    half = np.sqrt(np.maximum((1 + (seen * third).sum(axis=1)) / 2, 1e-12))
    return -apart / half[:, None]  # half: cosine of half the angle


def of_orientation(seen: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Return the rotation vectors (rows, 3) from predicted to measured quaternions (rows, 4)."""
    there, here = (np.array(rotation.axes(Quaternion(*q.T))) for q in (seen, predicted))
    between = there.transpose(2, 1, 0) @ here.transpose(2, 0, 1)  # (axes, space, rows) each
    pairs = ((2, 1), (0, 2), (1, 0))
    sine = np.stack([between[:, i, j] - between[:, j, i] for i, j in pairs], axis=1) / 2
    size = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(size, (np.trace(between, axis1=1, axis2=2) - 1) / 2)
    return sine * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 1.0)[:, None]


OF_ATTITUDES = {"axis": of_axis, "orientation": of_orientation}
"""Residuals of measured attitudes (rows, parts), by kind of measurement."""
PARTS = {"axis": 2, "orientation": 3}
"""Their numbers of parts."""
