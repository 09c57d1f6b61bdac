"""Motions of tables in our conventions: z up, axis 3 along the symmetry axis, quaternions wxyz.

A `motion_table.Table` goes in; arrays by name come out, SI, for comparisons and fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arguments import choice
from ..columns import Arrays
from ..errors import InputError
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, rotated
from .headers import CAMERA, KIND, KINDS
from .motion_table import Table


ORDERS = {"wxyz": (0, 1, 2, 3), "xyzw": (3, 0, 1, 2)}
UPS = ("z", "y")
UNIT = 0.02  # by which the length of a quaternion or an axis may differ from 1


class Convention(NamedTuple):
    """The conventions of the frames of a table.

    Parameters
    ----------
    quaternion
        The order of columns q_0 ... q_3: "wxyz" or "xyzw"; None where they are named by letters.
    up
        The letter of the vertical, and of the body's axis of symmetry: "z" or "y". With "y" their
        z, x, y are our x, y, z.
    track
        The name of the object whose columns are read, where a table has several.
    chip
        The place of the accelerometer in body axes, from the centre of mass [m].
    """

    quaternion: str | None = None
    up: str = "z"
    track: str | None = None
    chip: tuple[float, float, float] = (0.0, 0.0, 0.0)


Place = str | Sequence[float] | None


def convention_of(
    *,
    quaternion: str | None = None,
    up: str = "z",
    track: str | None = None,
    chip: Sequence[float] | str | None = None,
) -> Convention:
    """Return the conventions of these arguments. Raises InputError."""
    choice("up", up, UPS)
    if quaternion is not None:
        choice("quaternion", quaternion, ORDERS)
    return Convention(quaternion, up, track, place_of("chip", chip) or (0.0, 0.0, 0.0))


def place_of(name: str, given: Place) -> tuple[float, float, float] | None:
    """Return three lengths [m], which may be a text with commas; None stays None.

    `name` is that of the argument in messages. Raises InputError.
    """
    if given is None:
        return None
    try:
        x, y, z = (float(part) for part in (given.split(",") if isinstance(given, str) else given))
    except (TypeError, ValueError):
        x = y = z = np.nan
    if not np.isfinite([x, y, z]).all():
        raise InputError(f"`{name}` must be three lengths x,y,z [m], but is {given!r:.40}.")
    return x, y, z


def motion(table: Table, convention: Convention = Convention()) -> Arrays:  # noqa: B008 - a tuple
    """Return the motion of a table in our conventions, SI, with quantities that follow from others.

    Given numbers are never replaced: quantities that follow only fill their gaps, those of the
    orientation first.

    Returns
    -------
    dict
        The scalars and cameras of the table by their names, (rows,); the `KINDS` of vectors,
        (rows, 3), NaN where a component is not given; `orientation`, unit quaternions wxyz, body
        to space, (rows, 4). An axis is a unit vector.

    Raises
    ------
    InputError
        For missing conventions and non-rotations.
    """
    turn = (0, 1, 2) if convention.up == "z" else (2, 0, 1)  # y up: (z, x, y) are ours
    found = {name: rows for name, rows in table.columns.items() if name not in KIND}
    for kind, (columns, *_) in KINDS.items():
        names = columns.split()
        if kind != "orientation" and any(map(table.has, names)):
            none = np.full(len(table.t), np.nan)
            rows = np.stack([table.columns.get(name, none) for name in names], axis=1)
            found[kind] = rows[:, turn]

    def fill(name: str, rows: np.ndarray) -> None:
        """Fill the gaps of the quantity `name`, or all of it if it is missing, with these rows."""
        given = found.get(name, rows)
        found[name] = np.where(np.isnan(given), rows, given)

    if "axis" in found:
        found["axis"] = _unit(table, found["axis"], "axis")
    q = _quaternion(table, convention, turn)
    if q is not None:
        found["orientation"] = q
        fill("axis", axis_of(q))
        if "gyroscope" in found:
            fill("omega", turned(q, found["gyroscope"]))
    if {"theta", "phi"} <= found.keys():
        theta = found["theta"]
        phi = found["phi"]
        parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        fill("axis", np.stack(parts, axis=1))
    if "axis" in found:
        axis = found["axis"]
        fill("theta", np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))
        if "omega" in found:
            fill("omega3", (found["omega"] * axis).sum(axis=1))
    return found


def _quaternion(table: Table, convention: Convention, turn: tuple[int, ...]) -> np.ndarray | None:
    """Return unit quaternions wxyz, (rows, 4), NaN in gaps; None if the table has none.

    `turn` are the indices of our x, y, z among their axes. Raises InputError.
    """
    order = convention.quaternion
    if order is None and any(table.has(f"q_{i}") for i in range(4)):
        raise InputError(
            f"`{table.path}`: the order of the quaternion q_0 ... q_3 must be named "
            "(--quaternion wxyz or xyzw)."
        )
    names = [f"q_{part}" for part in ORDERS.get(order or "", "wxyz")]
    if order is None and not any(map(table.has, names)):
        return None
    if not table.has(*names):
        raise InputError(
            f"`{table.path}`: a quaternion must have the columns {', '.join(sorted(names))}, all "
            "of them: --quaternion names the order of numbered ones."
        )
    q = np.stack([table.columns[name] for name in names], axis=1)
    q[:, 1:] = q[:, 1:][:, turn]
    return _unit(table, q, "quaternion")


def _unit(table: Table, rows: np.ndarray, what: str) -> np.ndarray:
    """Return rows of a vector, named `what` in messages, scaled to length 1.

    Raises InputError if a row is incomplete, or its length differs from 1 by more than `UNIT`.
    """
    gaps = np.isnan(rows)
    if (partial := gaps.any(axis=1) & ~gaps.all(axis=1)).any():
        raise InputError(
            f"`{table.path}`: in each row all {rows.shape[1]} numbers of the {what} must be given, "
            f"or none, but some are missing at {table.t[partial.argmax()]:.9g} s."
        )
    size = np.sqrt((rows**2).sum(axis=1))
    off = np.nanmax(np.abs(size - 1), initial=0.0)
    if off > UNIT:
        raise InputError(
            f"`{table.path}`: the length of the {what} must be 1, but differs by {off:.2g} "
            "somewhere."
        )
    return rows / size[:, None]


def turned(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return vectors v (..., 3) in body axes as components in space, (..., 3).

    q (..., 4) are unit quaternions wxyz, body to space. Leading axes broadcast: one vector may be
    turned by n quaternions, or n vectors by one.
    """
    parts = rotated(Quaternion(*np.moveaxis(q, -1, 0)), Vector(*np.moveaxis(v, -1, 0)))
    return np.stack(parts, axis=-1)


def in_body_axes(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the components along body axes of vectors v (..., 3) in space: inverse of `turned`.

    q (..., 4) are unit quaternions wxyz, body to space.
    """
    return turned(q * [1, -1, -1, -1], v)


def axis_of(q: np.ndarray) -> np.ndarray:
    """Return the axis of symmetry in space, (..., 3), of unit quaternions wxyz q, (..., 4)."""
    return turned(q, np.array([0.0, 0.0, 1.0]))


def theta_of(q: np.ndarray) -> np.ndarray:
    """Return the inclination theta of the axis [rad], (n,), of unit quaternions wxyz q (n, 4)."""
    w, x, y, z = q.T
    return 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))


def angle_in_picture(axis: np.ndarray, name: str) -> np.ndarray:
    """Return the angles [rad], (...), of axes (..., 3) in the picture of a camera.

    They are 0 upwards in the picture and positive to the right, in (-pi, pi]. `name` is the column,
    `camera_AZIMUTH` or `camera_AZIMUTH_ELEVATION` [degrees], which determines the camera.
    """
    match = CAMERA.fullmatch(name)
    assert match is not None
    a, e = np.deg2rad([float(angle or 0) for angle in match.groups()])
    up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
    return np.arctan2(axis @ [-np.sin(a), np.cos(a), 0.0], axis @ up)


def angle_between(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the angles of rotation [rad], (n,), in 0 to pi, between orientations q and p.

    They are unit quaternions (n, 4); q and -q are the same orientation.
    """
    near = np.minimum(np.linalg.norm(q - p, axis=1), np.linalg.norm(q + p, axis=1))
    return 4 * np.arcsin(np.clip(near / 2, 0, 1))
