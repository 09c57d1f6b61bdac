"""The heavy top with a fixed tip in closed form, and the names of its motions."""

import math
from typing import Any, NamedTuple

import numpy as np


class ClosedForm(NamedTuple):
    """z(t) = z1 + (z2 - z1) sn^2(W (t - t0), k) of a heavy top with a fixed tip. [section 8]"""

    z1: float
    z2: float
    z3: float
    W: float
    k2: float

    @property
    def period(self) -> float:
        """Return 2 K(k)/W [s]."""
        from scipy.special import ellipk

        return 2 * float(ellipk(self.k2)) / self.W

    def z(self, t: Any) -> np.ndarray:
        """Return z = cos(theta) at times since a maximum of theta (z = z1)."""
        from scipy.special import ellipj

        sn, *_ = ellipj(self.W * np.asarray(t, dtype=float), self.k2)
        return self.z1 + (self.z2 - self.z1) * sn**2


def closed_form(
    energy: float, Lz: float, L3: float, inertia: float, I3: float, weight: float
) -> ClosedForm:
    """Return the closed form of theta(t) by the integrals. [section 8]

    Parameters
    ----------
    energy
        E [J], that of weight counted from the tip.
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
    z1, z2, z3 = (float(z) for z in roots)
    return ClosedForm(
        z1, z2, z3, math.sqrt(weight * (z3 - z1) / (2 * inertia)), (z2 - z1) / (z3 - z1)
    )


# of order one: turning angles, or a cusp, that are this close are one; a double root has eight
# digits
NEAR = 1e-7


def heavy_top_motion(
    energy: float, Lz: float, L3: float, inertia: float, I3: float, weight: float
) -> str:
    """Return the name of the motion of a heavy top with a fixed tip; arguments as of `closed_form`.

    [T ch. 2]
    """
    form = closed_form(energy, Lz, L3, inertia, I3, weight)
    scale = math.sqrt(inertia * weight)
    if abs(L3) < NEAR * scale:
        if abs(Lz) < NEAR * scale:
            return "planar pendulum" if form.z2 - form.z1 > NEAR else "at rest"
        return "spherical pendulum" if form.z2 - form.z1 > NEAR else "conical pendulum"
    if form.z2 - form.z1 < NEAR:
        return "spinning" if 1 - abs(form.z1) < NEAR else "regular precession"
    turn = Lz / L3  # phi' = (L_z - L_3 z)/(I1* sin^2) changes sign at this z
    if form.z1 + NEAR < turn < form.z2 - NEAR:
        return "nutation with loops"
    if abs(turn - form.z1) <= NEAR or abs(turn - form.z2) <= NEAR:
        return (
            "nutation through the vertical" if abs(abs(turn) - 1) < NEAR else "nutation with cusps"
        )
    return "nutation without loops"
