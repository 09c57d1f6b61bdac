"""Samples of a motion from the rows of a run: attitude, velocities, forces, momenta.

Columns in SI units go in; an array comes out, as motion.js reads it.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..mechanics.contact.body import Touch, filled, tip_inertia
from ..mechanics.contact.surroundings import at_present, pushing
from ..mechanics.friction import slip_coefficient
from ..mechanics.operand import Vector, cross
from ..mechanics.rotation import Quaternion, axes
from ..mechanics.systems import find
from ..runs.shape import angular_velocity, body_of, lowest, shape


Columns = Mapping[str, np.ndarray]
ORIENTATION = slice(0, 4)
OMEGA = slice(4, 7)
NEEDED = (
    *("time", "orientation", "L", "theta", "theta_dot", "phi", "nu_x", "nu_y"),
    *("x", "y", "z", "phase", "ball"),
)
"""Columns without which there is no page; the force and the potential are drawn if they are there.
"""


def needed(attrs: dict[str, Any]) -> list[str]:
    """Return the columns of a trajectory from which samples are made."""
    return [*NEEDED, "normal_force", *well_quantities(find(attrs["system"]))]


def well_quantities(system: Any) -> list[str]:
    """Return the quantities of the potential, and last that of its level, if the system has one."""
    if system.potential is None:
        return []
    return [*system.momenta, system.landscape.energy if system.landscape else "modified_energy"]


def samples(columns: Columns, attrs: dict[str, Any]) -> np.ndarray:
    """Return samples (n, 23), as motion.js reads them, of rows given as columns by name, SI.

    The channels: orientation (4), angular velocity, centre of mass, force of the plane, sliding,
    angular momentum (3 each), theta, two momenta and the level of the potential. The command `film`
    reads the place and theta; from the angular velocity on `phase_formulas.channels` has the same.

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
    orientation = columns["orientation"]
    third = axes(Quaternion(*orientation.T))[2]
    if drawn["kind"] == "cylinder":
        none = np.zeros(n)
        spin = columns["theta_dot"]
        omega = Vector(none, spin, none)
        momentum = Vector(none, b.I1 * spin, none)
    else:
        momentum = Vector(*columns["L"].T)
        turned = b._replace(I1=tip_inertia(b)) if drawn["fixed"] else b  # L is about the tip
        omega = Vector(*angular_velocity(orientation, columns["L"], turned).T)
    arm = Vector(*lowest(orientation, _touching(columns, attrs, b)).T)
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
            _place(columns, arm, drawn["fixed"]),
            _force(columns, velocity, slip, third.z, b),
            *slip,
            np.zeros(n),  # a contact slides in the plane
            *momentum,
            columns["theta"],
            *well[:-1],
            *np.zeros((3 - len(well), n)),  # the level is the last channel
            *well[-1:],
        ]
    )


def _touching(columns: Columns, attrs: dict[str, Any], b: Touch) -> Touch:
    """Return the body b with R and c of the last ball that touched the plane, [m].

    They are (n,) for rows of a body with a stem. `columns` are those of the rows by name.
    """
    if "ball" not in columns or "stem" not in attrs:
        return b
    stem = columns["ball"] == 1
    of_stem = b.c + attrs["stem"]["h"], attrs["stem"]["r"]
    return b._replace(c=np.where(stem, of_stem[0], b.c), R=np.where(stem, of_stem[1], b.R))


def _slip(columns: Columns, n: int) -> np.ndarray:
    """Return the horizontal velocity of the contact point, (2, n) [m/s]; zero without sliding.

    It has no components at a pole: there that of the next row is taken.
    """
    none = np.zeros(n)
    along, across, phi = (columns.get(name, none) for name in ("nu_x", "nu_y", "phi"))
    v = (along + 1j * across) * np.exp(1j * phi)
    known = np.flatnonzero(np.isfinite(v))
    if 0 < len(known) < n:
        v = np.interp(np.arange(n), known, v[known])
    return np.nan_to_num([v.real, v.imag])


def _place(columns: Columns, arm: Vector, fixed: bool) -> np.ndarray:
    """Return the place of the centre of mass, (n, 3) [m]; from the tip if that is `fixed`.

    `arm` goes from the centre of mass to the contact, components (n,) [m].
    """
    if fixed:
        return -np.stack(arm, axis=1)
    y = columns.get("y", np.zeros(len(arm.z)))
    return np.stack([columns["x"], y, columns.get("z", -arm.z)], axis=1)


def _force(
    columns: Columns, velocity: np.ndarray, slip: np.ndarray, z: np.ndarray, b: Touch
) -> np.ndarray:
    """Return the force of the plane, (n, 3) [N].

    `velocity` (2, n) is that of the centre of mass, `slip` (2, n) that of the contact [m/s], z is
    cos(theta) (n,), b the body. Friction follows from its law in sliding with one phase, else from
    m r'', row by row, and is 0 next to a change of phase.
    """
    n = velocity.shape[1]
    normal = columns.get("normal_force", np.full(n, np.nan))
    if "nu_x" in columns and "phase" not in columns and b.friction.coefficient is not None:
        # not 0, where k of Coulomb's law itself is infinite
        k = slip_coefficient(np.maximum((slip**2).sum(axis=0), 1e-300), z, b.friction)
        return np.stack([*(-k * normal * slip), normal], axis=1)
    push = b.m * np.gradient(velocity, columns["time"], axis=1) if n > 1 else np.zeros((2, n))
    if b.around:
        none = np.zeros(n)
        if b.around.table:
            b = at_present(b, filled(x=columns["x"], y=columns["y"]))
        push = push - b.m * np.stack(pushing(Vector(velocity[0], velocity[1], none), none, b)[:2])
    if "phase" in columns:
        change = np.flatnonzero(np.diff(columns["phase"]) | np.diff(columns["ball"]))
        push[:, np.unique(np.clip([change, change + 1], 0, n - 1))] = 0.0
        push[:, normal == 0] = 0.0
    return np.stack([*push, normal], axis=1)
