"""Residuals of measurements, in as many numbers as their noise has directions.

Predictions and measurements go in, residuals come out, for `observation` and `comparison`.
"""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion
from .headers import CAMERA


def residuals(kind: str, seen: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Return measurements `seen` (rows, ...) of a kind minus predictions, (..., rows, parts), SI.

    Differences of angles are within half a turn; an axis has two parts, an orientation three.
    """
    if kind == "axis":
        return _of_axis(seen, predicted)
    if kind == "orientation":
        return _of_orientation(seen, predicted)
    off = seen - predicted
    if kind in ("phi", "psi") or CAMERA.fullmatch(kind):
        off = np.remainder(off + np.pi, 2 * np.pi) - np.pi
    return off


def _of_axis(seen: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Return the residuals of predicted axes `third` from measured ones `seen` (rows, 3).

    They are chords between unit vectors, in the two directions across the measured one, (..., rows,
    2): the noise of an axis has no third direction. `comparison.differences` makes angles of them.
    """
    pole = np.where(seen[:, 2:] < 0, -1.0, 1.0) * [[0.0, 0.0, 1.0]]
    swing = rotation.swing(Vector(*pole.T), Vector(*seen.T))
    # (2, space, rows)
    across = np.array([rotation.rotated(swing, Vector(*e)) for e in np.eye(3)[:2]])
    apart = np.einsum("ixr,...rx->...ri", across, third)
    # opposite axes have no direction between them: their residual stays finite
    half = np.sqrt(np.maximum((1 + (seen * third).sum(axis=-1)) / 2, 1e-12))
    return -apart / half[..., None]  # half: cosine of half the angle


def _of_orientation(seen: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Return the rotation vectors from `predicted` orientations to measured ones, `seen`.

    They are (..., rows, 3) [rad] in space, of unit quaternions wxyz (..., rows, 4) and (rows, 4).
    """
    here = rotation.inverse(Quaternion(*np.moveaxis(predicted, -1, 0)))
    w, *vector = np.array(rotation.after(Quaternion(*seen.T), here))
    sine = np.linalg.norm(vector, axis=0)
    angle = 2 * np.where(w < 0, -1, 1) * np.arctan2(sine, np.abs(w))
    return np.moveaxis(vector * (angle / np.maximum(sine, 1e-300)), 0, -1)
