"""Linear modes near a spinning state: how fast a small lean grows, and whether the spin is stable.

Symbols
    b         the body in SI units, a `contact.body.Touch`; h: its height at the pole
    omega3    spin about the axis [rad/s]; up: cos(theta) of the pole, 1 or -1
    p         rate of a mode, u_x + i u_y ~ exp(p t) [1/s]; u: the axis
    slip      the coefficient k of friction at rest [s/m]
"""

import math
from typing import Any

import numpy as np

from ..contact.body import Touch, touching_ball
from ..friction import slip_coefficient, takes_nothing


def linear_modes(omega3: float, b: Touch, *, inverted: bool = False) -> np.ndarray:
    """Return the three rates p of u_x + i u_y ~ exp(pt) near a spinning state of a gliding body.

    [Friedl 1997]

    Parameters
    ----------
    omega3
        Spin about the axis [rad/s].
    b
        The body, SI. Any friction law counts by its slip coefficient at rest.
    inverted
        Near theta = pi rather than theta = 0.

    Returns
    -------
    ndarray
        Complex rates [1/s], (3,), fastest growth first, then fastest turning: the state is unstable
        iff the first has a positive real part; NaN where a number of the linear motion exceeds the
        doubles.
    """
    up = -1 if inverted else 1
    b = touching_ball(up, 0.0, b)
    Lz = up * b.I3 * omega3
    h = b.R - up * b.c
    with np.errstate(all="ignore"):
        slip = _slip(omega3, up, b.friction)
        n = 1j * Lz / b.I1, -1j * up / b.I1, 0
        momentum = -1j * b.m * b.g * b.c, 0, 1j * h * slip * b.m * b.g
        twist = h * (1 / b.I3 - 1 / b.I1) * up * Lz + Lz / b.I3 * b.c
        lever = 1j * h / b.I1
        v0, v1, v2 = (lever * M + 1j * twist * N for M, N in zip(momentum, n, strict=True))
        # rates of u, L and v_A, each x + i y, by these three
        matrix = np.array([n, momentum, (v0, v1, v2 - slip * b.g)])
    if not np.isfinite(matrix).all():
        return np.full(3, complex(np.nan, np.nan))
    return _fastest_first(np.linalg.eigvals(matrix))


def _slip(omega3: Any, up: int, law: Any) -> Any:
    """Return the slip coefficient k at rest [s/m]: a number, or (n,) for many laws or spins.

    For a disc that drills at omega3 it is the limit of small sliding, 3 pi mu/(8 patch |omega3|),
    without rolling resistance: mu k of `disc_friction.inside` at w = 0; a change of one is a change
    of both.
    """
    if not law.regions:
        return slip_coefficient(0.0, float(up), law)
    drilling = np.asarray(8 * law.patch * np.abs(omega3))
    return np.where(np.asarray(law.mu) == 0, 0.0, 3 * np.pi * law.mu / drilling)


def is_nowhere_linear(omega3: float, law: Any, *, inverted: bool = False) -> bool:
    """Return whether a friction law has no finite slope at rest.

    Such laws are Coulomb's law itself, and a disc that does not drill.
    """
    with np.errstate(all="ignore"):
        return not np.isfinite(_slip(omega3, -1 if inverted else 1, law)).all()


SLIDES = 1e-3  # of sqrt(gR): what a motion that has settled may slide at most


def shows_sliding(b: Touch, z: Any) -> Any:
    """Return whether friction at z = cos(theta) is so strong that sliding shows as a loss.

    A slide of 1e-3 sqrt(gR) loses more than 1e-12 of the unit of k |v_A|^2, below which a motion
    counts as settled: 1e-12 here must be the bound of the event `gliding.SETTLED`. Of one body, or
    of many, (n,).
    """
    law = b.friction
    if law.coefficient is None or law.set_valued:  # drilling takes without sliding; or it sticks
        return True
    b = touching_ball(z, (1 - z) * (1 + z), b)
    strength = slip_coefficient(0.0, z, law) * np.sqrt(b.g * (b.R + np.abs(b.c)))
    return np.asarray(strength) * SLIDES**2 > 1e-12


ROUNDED = 1e-12  # of a rate, a length or a moment of inertia: zero to rounding
LINEAR = 1e-2  # rad from a pole within which the modes tell what becomes of a motion


def will_leave(theta: float, omega3: float, b: Touch) -> bool:
    """Return whether a gliding body at theta [rad] with spin omega3 [rad/s] will leave the pole.

    It is so near that its motion is linear, and a mode grows there. Such a motion is not settled,
    even if nothing slides.
    """
    inverted = theta > math.pi / 2
    near = min(theta, math.pi - theta) < LINEAR
    return near and bool(is_unstable(omega3, b, inverted=inverted))


def is_unstable(omega3: Any, b: Touch, *, inverted: bool = False, gliding: bool = True) -> Any:
    """Return whether a spinning state is unstable; of one body, or of many, (n,).

    Parameters
    ----------
    omega3
        Spin about the axis [rad/s].
    b
        The body, SI.
    inverted
        Near theta = pi rather than theta = 0.
    gliding
        Whether the contact glides; it is at rest otherwise: rolling, or a fixed tip.

    Notes
    -----
    A contact that a law without a slope at rest may hold is not said to be unstable.
    """
    up = -1 if inverted else 1
    with np.errstate(all="ignore"):  # a disc has no ball at its poles
        free = takes_nothing(b.friction) if gliding else False
        steadies, topples = stability(up, b, rolls=not gliding, free=free)
        glides = np.isfinite(_slip(omega3, up, b.friction)) if gliding else True
        return (omega3**2 * steadies < topples) & glides


def stability(z: int, b: Touch, *, rolls: bool, free: Any = False) -> tuple[Any, Any]:
    """Return p and q of a spin at the pole z: it is stable if p omega_3^2 > q, unstable if less.

    Of one body, or of many, (n,); a number that is 0 to rounding is exactly 0.

    The contact rolls, or glides: `free` of friction, or under friction, which decides however weak
    it is. It takes energy, whose least value at this Jellett's integral does not depend on it.
    """
    b = touching_ball(z, 0.0, b)
    h = b.R - z * b.c
    rise = -z * b.c  # of the centre of mass above that of the ball
    weight = b.m * b.g * rise * (np.abs(rise) > ROUNDED * h)
    if rolls:  # discriminant of the polynomial of `rolling_modes`: a change of one is one of both
        return (b.I3 + b.m * h * b.R) ** 2 * (weight != 0), 4 * weight * (b.I1 + b.m * h**2)
    lever = b.I3 * h - b.I1 * b.R
    lever = lever * (np.abs(lever) > ROUNDED * b.I3 * h)
    steadies = np.where(free, b.I3**2, lever * b.R)
    return steadies, weight * np.where(free, 4 * b.I1, h**2)


def _fastest_first(p: np.ndarray) -> np.ndarray:
    """Return complex rates (n,) sorted by their growth.

    Rates of equal growth, to rounding, are sorted by how fast they turn, positive first.
    """
    unit = ROUNDED * np.abs(p).max() or 1.0
    growth = np.round(p.real / unit)
    turn = np.round(np.abs(p.imag) / unit)
    return p[np.lexsort((-p.imag, -turn, -growth))]


def rolling_modes(omega3: float, b: Touch, *, inverted: bool = False) -> np.ndarray:
    """Return the two rates p near a spinning state of a body whose contact is at rest.

    It rolls, or its tip is fixed.

    Parameters
    ----------
    omega3
        Spin about the axis [rad/s].
    b
        The body, SI; its friction law plays no part.
    inverted
        Near theta = pi rather than theta = 0.

    Returns
    -------
    ndarray
        Complex rates [1/s], (2,), fastest growth first, then fastest turning.
    """
    up = -1 if inverted else 1
    b = touching_ball(up, 0.0, b)
    h = b.R - up * b.c
    p = np.roots(
        [b.I1 + b.m * h**2, -1j * omega3 * up * (b.I3 + b.m * h * b.R), up * b.m * b.g * b.c]
    )
    return _fastest_first(p)
