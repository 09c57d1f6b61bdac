"""Residuals of measured attitudes, in as many numbers as noise has directions.

Predictions and measurements go in, residuals come out, for `observation`.
"""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion


def of_axis(seen: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Return the residuals of predicted axes `third` from measured ones `seen` (rows, 3).

    They are chords between unit vectors, in the two directions across the measured one, (..., rows,
    2): the noise of an axis has no third direction.
    """
    pole = np.where(seen[:, 2:] < 0, -1.0, 1.0) * [[0.0, 0.0, 1.0]]
    swing = rotation.swing(Vector(*pole.T), Vector(*seen.T))
    # (2, space, rows)
    across = np.array([rotation.rotated(swing, Vector(*e)) for e in np.eye(3)[:2]])
    apart = np.einsum("ixr,...rx->...ri", across, third)
    half = np.sqrt(np.maximum((1 + (seen * third).sum(axis=-1)) / 2, 1e-12))
    return -apart / half[..., None]  # half: cosine of half the angle


def of_orientation(seen: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Return the rotation vectors from `predicted` orientations to measured ones, `seen`.

    They are (..., rows, 3) [rad] in space, of unit quaternions wxyz (..., rows, 4) and (rows, 4).
    """
    here = rotation.inverse(Quaternion(*np.moveaxis(predicted, -1, 0)))
    w, *vector = np.array(rotation.after(Quaternion(*seen.T), here))
    sine = np.linalg.norm(vector, axis=0)
    angle = 2 * np.where(w < 0, -1, 1) * np.arctan2(sine, np.abs(w))
    return np.moveaxis(vector * (angle / np.maximum(sine, 1e-300)), 0, -1)


def wrapped(angles: np.ndarray) -> np.ndarray:
    """Return angles [rad] brought to [-pi, pi) by whole turns."""
    return np.remainder(angles + np.pi, 2 * np.pi) - np.pi


OF_ATTITUDES = {"axis": of_axis, "orientation": of_orientation}
"""Residuals of measured attitudes (rows, parts), by kind of measurement."""
PARTS = {"axis": 2, "orientation": 3}
"""Their numbers of parts."""
