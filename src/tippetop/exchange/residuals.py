"""How far measured attitudes are from predicted ones, in as many numbers as noise has
directions.
"""

import numpy as np

from ..mechanics import rotation
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion


def of_axis(
    seen: np.ndarray, third: np.ndarray, moves: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of unit vectors (rows, 3): the chord between them, split along two axes across the measured
    one, (rows, 2); and how it moves where `third` moves so, (rows, 3, free), less the sign. Noise
    of an axis has two directions, not three.
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
    """The rotation vector from predicted axes (rows, space, axes) to measured quaternions (rows,
    4), (rows, 3).
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
    """The rotation vector by which axes (rows, 3) turn where they move so, (rows, 3, free): half
    the sum of axis x change.
    """
    a, c = first[:, :, None], third[:, :, None]
    b, moved = (
        np.cross(c, a, axis=1),
        np.cross(third_moves, a, axis=1) + np.cross(c, first_moves, axis=1),
    )
    pairs = ((a, first_moves), (b, moved), (c, third_moves))
    return np.asarray(sum(np.cross(axis, change, axis=1) for axis, change in pairs)) / 2
