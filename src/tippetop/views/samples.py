"""Samples of a motion from the rows of a run: attitude, velocities, forces, momenta."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..mechanics.contact.body import Touch, Turning, angular_velocity_of, tip_inertia
from ..mechanics.friction import slip_coefficient
from ..mechanics.operand import Vector, cross, times
from ..mechanics.rotation import Quaternion, axes
from ..mechanics.systems import find
from ..runs.shape import body_of, shape


Columns = Mapping[str, np.ndarray]
ORIENTATION = slice(0, 4)
OMEGA = slice(4, 7)
NEEDED = (
    *("time", "orientation", "axis", "L", "theta", "theta_dot", "omega3", "phi", "nu_x", "nu_y"),
    *("x", "y", "z", "phase", "ball"),
)
"""Columns without which there is no page; the force and the potential are drawn if they are there.
"""


def needed(attrs: dict[str, Any]) -> list[str]:
    """Return the columns of a trajectory from which samples are made."""
    return [*NEEDED, "normal_force", *well_quantities(find(attrs["system"]))]


def well_quantities(system: Any) -> list[str]:
    """Return the quantities of the potential and of its level, if the system has one."""
    if system.potential is None:
        return []
    return [*system.momenta, system.landscape.energy if system.landscape else "modified_energy"]


def samples(columns: Columns, attrs: dict[str, Any]) -> np.ndarray:
    """Return samples (n, 23), as motion.js reads them, of rows given as columns by name, SI.

    Parameters
    ----------
    columns
        `needed`, as far as the run has them.
    attrs
        The root attributes of its store.
    """
    b = body_of(attrs)
    n = len(columns["time"])
    drawn = shape(attrs)
    third = axes(Quaternion(*columns["orientation"].T))[2]
    if drawn["kind"] == "cylinder":
        none = np.zeros(n)
        spin = columns["theta_dot"]
        omega = Vector(none, spin, none)
        momentum = Vector(none, b.I1 * spin, none)
    else:
        momentum = Vector(*columns["L"].T)
        inert = b._replace(I1=tip_inertia(b)) if drawn["fixed"] else b  # L is about the tip then
        x = Turning(Vector(*columns["axis"].T), momentum)
        omega = angular_velocity_of(x, b.I3 * columns["omega3"], inert)
    offset, radius = _ball(columns, attrs, b)
    arm = Vector(offset * third.x, offset * third.y, offset * third.z - radius)
    slip = _slip(columns, n)
    turning = cross(omega, arm)
    velocity = np.stack([slip[0] - turning.x, slip[1] - turning.y])
    well = [
        columns.get(name, np.full(n, np.nan)) for name in well_quantities(find(attrs["system"]))
    ]
    return np.column_stack(
        [
            columns["orientation"],
            *omega,
            _place(columns, third, offset, radius, drawn["fixed"]),
            _force(columns, velocity, slip, third.z, b),
            *slip,
            np.zeros(n),
            *momentum,
            columns["theta"],
            *well[:-1],
            *np.zeros((3 - len(well), n)),
            *well[-1:],
        ]
    )


def _ball(columns: Columns, attrs: dict[str, Any], b: Touch) -> tuple[Any, Any]:
    """Return offset and radius of the last ball in contact with the plane; numbers or (n,)."""
    if "ball" not in columns or "stem" not in attrs:
        return b.c, b.R
    stem = columns["ball"] == 1
    return np.where(stem, b.c + attrs["stem"]["h"], b.c), np.where(stem, attrs["stem"]["r"], b.R)


def _slip(columns: Columns, n: int) -> np.ndarray:
    """Return the horizontal velocity of the contact point, (2, n); zero without sliding.

    It has no components at a pole: there that of the next row is taken.
    """
    none = np.zeros(n)
    along, across, phi = (columns.get(name, none) for name in ("nu_x", "nu_y", "phi"))
    v = (along + 1j * across) * np.exp(1j * phi)
    known = np.flatnonzero(np.isfinite(v))
    if 0 < len(known) < n:
        v = np.interp(np.arange(n), known, v[known])
    return np.nan_to_num([v.real, v.imag])


def _place(columns: Columns, third: Vector, offset: Any, radius: Any, fixed: bool) -> np.ndarray:
    """Return the centre of mass, (n, 3)."""
    if fixed:
        return np.stack(times(-offset, third), axis=1)
    height = columns["z"] if "z" in columns else radius - offset * third.z
    return np.stack([columns["x"], columns.get("y", np.zeros(len(third.z))), height], axis=1)


def _force(
    columns: Columns, velocity: np.ndarray, slip: np.ndarray, z: np.ndarray, b: Touch
) -> np.ndarray:
    """Return the force of the plane, (n, 3).

    Friction follows from its law in sliding with one phase, else from m r'', row by row.
    """
    n = velocity.shape[1]
    normal = columns.get("normal_force", np.full(n, np.nan))
    if "nu_x" in columns and "phase" not in columns and b.friction.coefficient is not None:
        k = slip_coefficient(np.maximum((slip**2).sum(axis=0), 1e-300), z, b.friction)
        return np.stack([*(-k * normal * slip), normal], axis=1)
    push = b.m * np.gradient(velocity, columns["time"], axis=1) if n > 1 else np.zeros((2, n))
    if "phase" in columns:
        change = np.flatnonzero(np.diff(columns["phase"]) | np.diff(columns["ball"]))
        push[:, np.unique(np.clip([change, change + 1], 0, n - 1))] = 0.0
        push[:, normal == 0] = 0.0
    return np.stack([*push, normal], axis=1)
