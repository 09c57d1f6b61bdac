"""Residuals of measured attitudes, in as many numbers as noise has directions."""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion


def of_axis(
    seen: np.ndarray, third: np.ndarray, moves: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the chords between unit vectors (rows, 3), across the measured one, (rows, 2).

    Also return their derivatives, less the sign, for the derivatives `moves` of `third`,
    (rows, 3, free). The noise of an axis has two directions, not three.
    """
    pole = np.where(seen[:, 2:] < 0, -1.0, 1.0) * [[0.0, 0.0, 1.0]]
    swing = rotation.swing(Vector(*pole.T), Vector(*seen.T))
    across = np.array(
        [rotation.rotated(swing, Vector(*e)) for e in np.eye(3)[:2]]
    )  # (2, space, rows)
    apart = np.einsum("ixr,rx->ri", across, third)
    half = np.sqrt(np.maximum((1 + (seen * third).sum(axis=1)) / 2, 1e-12))[
        :, None
    ]  # cos of half the angle
    along = np.einsum("rx,rxf->rf", seen, moves)[:, None, :]
    turned = np.einsum("ixr,rxf->rif", across, moves)
    return -apart / half, turned / half[:, :, None] - apart[:, :, None] * along / (
        4 * half[:, :, None] ** 3
    )


def of_orientation(seen: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the rotation vectors (rows, 3) from predicted axes to measured quaternions.

    The axes are (rows, space, axes), the quaternions (rows, 4).
    """
    there = np.array(rotation.axes(Quaternion(*seen.T)))  # (axes, space, rows)
    between = there.transpose(2, 1, 0) @ axes.transpose(0, 2, 1)
    pairs = ((2, 1), (0, 2), (1, 0))
    sine = np.stack([between[:, i, j] - between[:, j, i] for i, j in pairs], axis=1) / 2
    size = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(size, (np.trace(between, axis1=1, axis2=2) - 1) / 2)
    return sine * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 1.0)[:, None]


def turning(
    first: np.ndarray, third: np.ndarray, first_moves: np.ndarray, third_moves: np.ndarray
) -> np.ndarray:
    """Return the rotation vector of axes (rows, 3) for their derivatives, (rows, 3, free).

    It is half the sum of axis x change.
    """
    a = first[:, :, None]
    c = third[:, :, None]
    b = np.cross(c, a, axis=1)
    moved = np.cross(third_moves, a, axis=1) + np.cross(c, first_moves, axis=1)
    pairs = ((a, first_moves), (b, moved), (c, third_moves))
    return np.asarray(sum(np.cross(axis, change, axis=1) for axis, change in pairs)) / 2
