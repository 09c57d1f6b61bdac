"""How near a top comes to the poles theta = 0 and pi: where the centrifugal wall of its potential
turns it back.
"""

from typing import Any, NamedTuple

import numpy as np

from ..system import System


# [rad] what comes nearer counts as reaching the pole: 1 - z has no digits left there in 80 bits
NEAREST = 1e-8
STEPS = 80  # angles, evenly spread in their logarithm, at which a wall is looked for
HALVINGS = 32
WIDE = np.longdouble  # V of z = cos(theta) loses digits next to the poles


class PoleDistances(NamedTuple):
    """Least angles [rad] between the axis and the vertical; 0: the pole is reached."""

    upright: Any  # least theta
    inverted: Any  # least pi - theta


def closest_approach(system: System, scalars: Any, b: Any) -> PoleDistances:
    """How near the motion from a start comes to each pole, from V and E~ alone: nothing is
    integrated. [T 4.11, 2.38]

    Parameters
    ----------
    system
        A system with `potential`, whose momenta and E~ are constant: a rolling tippe top, a heavy
        top with fixed tip.
    scalars
        The scalars of its start, numbers or arrays (n,), in any consistent units.
    b
        The body, in the same units, numbers or arrays (n,).

    Returns
    -------
    PoleDistances
        Numbers or arrays (n,); to some 1e-9 of the distance. Where V has two wells the wall nearest
        to the start counts.

    Notes
    -----
    Near a pole sin(theta) at the turn is |phi' sin(theta)^2| over the speed of the axis: a top that
    is to miss the vertical by an angle must have as much of L_z -+ L_3.

    A form that is singular at the poles (`reduced`, `euler`) is wrong by some 1e-14/distance^2 in
    theta after a few passages (canonical rolling top, 2 s: 6e-14 at 0.066 rad, 2e-10 at 0.007, 3e-8
    at 7e-4, 2e-5 at 2e-5).
    """
    assert system.potential is not None
    assert system.theta_inertia is not None
    formulas = {quantity.name: quantity.formula for quantity in system.quantities}
    momenta = [np.asarray(formulas[name](scalars, b), WIDE) for name in system.momenta]
    z, s2, z_dot = (np.asarray(value, WIDE) for value in (scalars.z, scalars.s2, scalars.z_dot))
    start = np.arctan2(np.sqrt(s2), z)
    distances = []
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        energy = system.theta_inertia(z, b) * z_dot**2 / s2 + system.potential(
            np.cos(start), *momenta, b
        )
        for pole in (1, -1):

            def stopped(angle: Any, pole: int = pole) -> Any:
                assert system.potential is not None
                return system.potential(pole * np.cos(angle), *momenta, b) > energy

            first = np.maximum(start if pole == 1 else WIDE(np.pi) - start, NEAREST)
            distances.append(_wall(stopped, first))
    return PoleDistances(*distances)


def _wall(stopped: Any, first: Any) -> Any:
    """The largest angle below `first` at which the motion is stopped; 0 where it is not."""
    ratio = (NEAREST / first) ** (1 / WIDE(STEPS))
    inside, outside = first, first
    hits = np.zeros(np.shape(first), bool)
    for _ in range(STEPS):
        inside = np.where(hits, inside, outside)
        outside = np.where(hits, outside, outside * ratio)
        hits = hits | stopped(outside)
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        turned = stopped(middle)
        outside, inside = np.where(turned, middle, outside), np.where(turned, inside, middle)
    return np.where(hits, inside, 0.0).astype(float)[()]
