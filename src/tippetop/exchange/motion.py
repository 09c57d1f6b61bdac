"""Motions of tables in our conventions: z up, axis 3 along the symmetry axis, quaternions wxyz."""

from typing import Any, NamedTuple

import numpy as np

from ..arguments import choice
from ..errors import InputError
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, rotated
from .headers import SCALARS
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
    """

    quaternion: str | None = None
    up: str = "z"


def convention_of(quaternion: str | None, up: str) -> Convention:
    """Return the conventions of these arguments. Raises InputError."""
    choice("up", up, UPS)
    if quaternion is not None:
        choice("quaternion", quaternion, ORDERS)
    return Convention(quaternion, up)


class Motion(NamedTuple):
    """A motion in our conventions, SI; None for quantities that the table lacks.

    Parameters
    ----------
    t, theta, phi, psi, theta_dot, phi_dot, omega3
        (rows,).
    axis
        The unit vector 3hat along the axis of the body, space frame, (rows, 3).
    orientation
        Unit quaternion wxyz, body to space, (rows, 4).
    place, velocity
        Of the centre of mass, space frame, (rows, 3), NaN where a component is not given.
    omega
        Angular velocity, space frame, (rows, 3).
    force
        Of the contact on the body, space frame, (rows, 3).
    marker
        Places of a marker on the body, space frame, (rows, 3).
    """

    t: np.ndarray
    theta: np.ndarray | None = None
    phi: np.ndarray | None = None
    psi: np.ndarray | None = None
    theta_dot: np.ndarray | None = None
    phi_dot: np.ndarray | None = None
    omega3: np.ndarray | None = None
    axis: np.ndarray | None = None
    orientation: np.ndarray | None = None
    place: np.ndarray | None = None
    velocity: np.ndarray | None = None
    omega: np.ndarray | None = None
    force: np.ndarray | None = None
    marker: np.ndarray | None = None


def motion(table: Table, convention: Convention = Convention()) -> Motion:  # noqa: B008 - a tuple
    """Return the motion of a table. Raises InputError for missing conventions and non-rotations."""
    turn = (0, 1, 2) if convention.up == "z" else (2, 0, 1)  # y up: (z, x, y) are ours
    q = _quaternion(table, convention, turn)
    scalars: Any = (table.columns.get(name) for name in SCALARS)
    whole = Motion(*scalars)
    theta, phi, omega3 = whole.theta, whole.phi, whole.omega3
    axis = _vector(table, "axis_{}", turn)
    axis = None if axis is None else _unit(table, axis, "axis")
    axis = _filled(axis, None if q is None else axis_of(q))
    if theta is not None and phi is not None:
        parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        axis = _filled(axis, np.stack(parts, axis=1))
    omega, own = _vector(table, "omega_{}", turn), _vector(table, "omega_body_{}", turn)
    if own is not None:
        omega3 = _filled(omega3, own[:, 2])
        omega = _filled(omega, None if q is None else turned(q, own))
    if axis is not None:
        theta = _filled(theta, np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))
        omega3 = _filled(omega3, None if omega is None else (omega * axis).sum(axis=1))
    place, velocity, force, marker = (
        _vector(table, names, turn) for names in ("{}", "v{}", "force_{}", "marker_{}")
    )
    return whole._replace(
        theta=theta,
        omega3=omega3,
        axis=axis,
        orientation=q,
        place=place,
        velocity=velocity,
        omega=omega,
        force=force,
        marker=marker,
    )


def _filled(given: np.ndarray | None, other: np.ndarray | None) -> np.ndarray | None:
    """Return measurements, with the other ones in their gaps; None if both are missing."""
    if given is None or other is None:
        return other if given is None else given
    return np.where(np.isnan(given), other, given)


def _quaternion(table: Table, convention: Convention, turn: tuple[int, ...]) -> np.ndarray | None:
    """Return unit quaternions wxyz, (rows, 4); NaN in gaps."""
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
    q = table.stacked(*names)
    q[:, 1:] = q[:, 1:][:, turn]
    return _unit(table, q, "quaternion")


def _unit(table: Table, rows: np.ndarray, what: str) -> np.ndarray:
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


def _vector(table: Table, pattern: str, turn: tuple[int, ...]) -> np.ndarray | None:
    """Return components in our frame, (rows, 3), NaN if not given; None if all are missing."""
    names = [pattern.format(c) for c in "xyz"]
    if not any(table.has(name) for name in names):
        return None
    none = np.full(len(table.t), np.nan)
    rows = np.stack([table.columns.get(name, none) for name in names], axis=1)
    return rows[:, turn]


def turned(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return vectors v, (3,) or (n, 3), rotated by unit quaternions (n, 4)."""
    return np.stack(rotated(Quaternion(*q.T), Vector(*v.T)), axis=1)


def axis_of(q: np.ndarray) -> np.ndarray:
    """Return the axis of symmetry in space, (n, 3), of unit quaternions (n, 4)."""
    return turned(q, np.array([0.0, 0.0, 1.0]))


def theta_of(q: np.ndarray) -> np.ndarray:
    """Return the inclination of the axis [rad], (n,), of unit quaternions (n, 4)."""
    w, x, y, z = q.T
    return 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))


def angle_between(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the angles of rotation between orientations [rad], (n,), in 0 to pi."""
    near = np.minimum(np.linalg.norm(q - p, axis=1), np.linalg.norm(q + p, axis=1))
    return 4 * np.arcsin(np.clip(near / 2, 0, 1))
