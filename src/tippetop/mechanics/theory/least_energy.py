"""The least energy that Jellett's integral leaves a tippe top, and its critical points.

[T 3.43, 3.44]

At given lambda and z no state has less energy than the one that turns about the arm of the contact,
omega = -lambda a/(a.I a), with its centre of mass at rest. Its critical points are the spinning and
tumbling states, where a gliding top can end.

Symbols
    b         the body in SI units, a `contact.body.Touch`; a: the arm, I: tensor of inertia
    z         cos(theta); lam, lambda: Jellett's integral [kg m^3/s]
    s_z       height of the centre of mass [m]
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..contact.body import Touch, height_energy
from ..operand import formula
from .thresholds import lambda_s, lambda_u, spin_of, spins_by_height
from .tumbling import tumbling, tumbling_is_stable, tumbling_states


@formula
def arm_inertia(z, b):
    """Return a.I a = I1 R^2 sin(theta)^2 + I3 (c - R z)^2 [kg m^4].

    It is I1 times the G(z) of the source. [T 3.44, corrected]
    """
    return b.I1 * b.R**2 * ((1 - z) * (1 + z)) + b.I3 * (b.c - b.R * z) ** 2


@formula
def least_energy(z, lam, b):
    """Return E_lambda(z) = lambda^2/(2 a.I a) + m g s_z [J]. [T 3.44, corrected]"""
    return lam**2 / (2 * arm_inertia(z, b)) + height_energy(z, b)


class AsymptoticState(NamedTuple):
    """A state with v_A = 0 and a vertical reaction.

    kind (upright, tumbling, inverted), theta [rad], phi' (0 of a spinning state) and omega_3
    [rad/s], energy [J], and whether it is stable if the contact glides.
    """

    kind: str
    theta: float
    phi_dot: float
    omega3: float
    energy: float
    stable: bool


def asymptotic_states(lam: float, b: Touch) -> list[AsymptoticState]:
    """Return the critical points of E_lambda, from theta = 0 to pi.

    The first is the upright, the last the inverted spin: `regime` unpacks them by their places.

    [T Theorems 3.3.1 and 3.3.2, corrected]

    Parameters
    ----------
    lam
        Jellett's integral [kg m^3/s].
    b
        The body, SI, floats.
    """

    def state(kind: str, z: float, phi_dot: float, omega3: float, stable: bool) -> AsymptoticState:
        """Return a critical point with its energy."""
        with np.errstate(over="ignore"):
            energy: Any = least_energy(z, np.float64(lam), b)
        return AsymptoticState(kind, math.acos(z), phi_dot, omega3, float(energy), stable)

    low, high = spins_by_height(b)
    spins = {low: abs(lam) < lambda_u(b), high: abs(lam) > lambda_s(b)}
    sense = math.copysign(1, lam)
    tumbling_ones = []
    # from the largest z to the least, as theta rises; at lambda = 0 no top tumbles
    for z in map(float, tumbling_states(lam, b)[::-1] if lam else ()):
        phi_dot, omega3 = (sense * float(rate) for rate in tumbling(z, b))
        stable = bool(tumbling_is_stable(z, b))
        tumbling_ones.append(state("tumbling", z, phi_dot, omega3, stable))
    return [
        state("upright", 1.0, 0.0, spin_of(lam, b), bool(spins["upright"])),
        *tumbling_ones,
        state("inverted", -1.0, 0.0, spin_of(lam, b, inverted=True), bool(spins["inverted"])),
    ]
