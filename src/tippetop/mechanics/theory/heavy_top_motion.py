"""The swing of the heavy top with a fixed tip, and the names of its motions.

Conserved numbers of a motion in SI units go in; heights z = cos(theta), or words, come out.
"""

import math

import numpy as np


def turning_heights(
    energy: float, Lz: float, L3: float, inertia: float, I3: float, weight: float
) -> np.ndarray:
    """Return z1 < z2 < z3, where z'^2 of a heavy top with a fixed tip vanishes.

    z = cos(theta) swings between the first two.

    Parameters
    ----------
    energy
        Total energy [J]; the potential energy is zero at the height of the tip.
    Lz, L3
        Angular momenta about the vertical through the tip and about the axis [kg m^2/s].
    inertia
        I1* = I1 + m l^2 [kg m^2].
    I3
        Axial moment of inertia [kg m^2].
    weight
        m g l [J].
    """
    free = 2 * (energy - L3**2 / (2 * I3)) / inertia
    beta = 2 * weight / inertia
    a = L3 / inertia
    b = Lz / inertia
    # f(z) = (free - beta z)(1 - z^2) - (b - a z)^2
    f = np.array([beta, -free - a * a, 2 * a * b - beta, free - b * b])
    roots = np.sort(np.roots(f).real)
    for _ in range(3):  # polish: companion eigenvalues lose a few digits
        slope = np.polyval(np.polyder(f), roots)
        simple = np.abs(slope) > 1e-5 * np.abs(f).max()
        roots = roots - np.divide(np.polyval(f, roots), slope, out=np.zeros(3), where=simple)
    return roots


# of order one: turning angles, or a cusp, that are this close are one; a double root has eight
# digits
NEAR = 1e-7


def heavy_top_motion(
    energy: float, Lz: float, L3: float, inertia: float, I3: float, weight: float
) -> str:
    """Return the name of the motion of a heavy top with a fixed tip, in words for users.

    The arguments are those of `turning_heights`. [T ch. 2]
    """
    low, high, _ = turning_heights(energy, Lz, L3, inertia, I3, weight)
    scale = math.sqrt(inertia * weight)
    if abs(L3) < NEAR * scale:
        if abs(Lz) < NEAR * scale:
            return "planar pendulum" if high - low > NEAR else "at rest"
        return "spherical pendulum" if high - low > NEAR else "conical pendulum"
    if high - low < NEAR:
        return "spinning" if 1 - abs(low) < NEAR else "regular precession"
    turn = Lz / L3  # phi' = (L_z - L_3 z)/(I1* sin^2) changes sign at this z
    if low + NEAR < turn < high - NEAR:
        return "nutation with loops"
    if abs(turn - low) <= NEAR or abs(turn - high) <= NEAR:
        return (
            "nutation through the vertical" if abs(abs(turn) - 1) < NEAR else "nutation with cusps"
        )
    return "nutation without loops"
