"""What the landscape is compared with: V of the published formula [T 4.12] and N(z) of section 5,
in 60 digits.
"""

import math

import mpmath as mp
import numpy as np

from tippetop.mechanics.friction import Frictionless
from tippetop.mechanics.systems import tippe_top
from tippetop.mechanics.theory import spinning


mp.mp.dps = 60
FIGURE = {
    "m": 0.02,
    "R": 0.02,
    "alpha": 0.3,
    "I1": 235 / 625 * 8e-6,
    "I3": 2 / 5 * 8e-6,
    "g": 9.82,
}  # figure 4.1


def body(parameters):
    """The body in 60 digits: alpha*R is not rounded."""
    return tippe_top.TippeTop.body_of(
        {name: mp.mpf(x) for name, x in parameters.items()}, Frictionless()
    )


def parameters(alpha, gamma, sigma):
    """A body by its numbers without dimension."""
    I3 = 8e-6 / sigma
    return {"m": 0.02, "R": 0.02, "alpha": alpha, "I1": gamma * I3, "I3": I3, "g": 9.82}


def potential(z, D, lam, b):
    """V in the longer form of the source, term by term: nothing of ours in it. [T 4.12]"""
    gamma, sigma, alpha = b.I1 / b.I3, b.m * b.R**2 / b.I3, b.c / b.R
    w = 1 - z**2
    d = gamma + sigma * (alpha - z) ** 2 + sigma * gamma * w
    X = lam * mp.sqrt(d) + b.R * (alpha - z) * D
    return b.m * b.g * b.R * (1 - alpha * z) + (
        X**2 * (sigma * (alpha - z) ** 2 + gamma) / (b.R**2 * gamma**2 * w)
        + D**2 * (sigma * w + 1)
        + 2 / (b.R * gamma) * D * sigma * (alpha - z) * X
    ) / (2 * b.I3 * d)


def z_of(q):
    """cos(theta) of tan(theta/2)^2."""
    return (1 - q) / (1 + q)


def critical(z, D, lam, b):
    """N(z), of the sign of dV/dz in (-1, 1); it is regular on [-1, 1], with
    N(-1) <= 0 <= N(1).
    """
    X, w, root = tippe_top.X(z, D, lam, b), (1 - z) * (1 + z), mp.sqrt(tippe_top.d(z, b))
    bend = b.c - b.R * z + b.R * b.I1 / b.I3 * z
    X_rate = -lam * b.m * b.R / b.I3 * bend / root
    return X * ((X_rate - b.R * D) * w + z * X) - b.c * b.m * b.g * b.I1**2 / b.I3 * (b.R * w) ** 2


def minimum(D, lam, b, near):
    """F and q of the minimum of V, from the zero of N(z) next to q = `near`, bracketed and bisected
    by a secant.

    Fails unless N changes sign from plus to minus with q within a factor 1 + 1e-6 of `near`: a
    minimum is there.
    """
    D, lam, near = mp.mpf(D), mp.mpf(lam), mp.mpf(near)

    def N(factor):
        return critical(z_of(near * factor), D, lam, b)

    low, high = 1 / (1 + mp.mpf("1e-6")), 1 + mp.mpf("1e-6")
    f_low, f_high = N(low), N(high)
    assert f_low > 0 > f_high, (
        f"no minimum next to q = {float(near)} for D = {float(D)!r}, lambda = {float(lam)!r}"
    )
    # relative to near and to f_low, so that 50 digits are 50 digits, and it ends after 8 steps
    factor = mp.findroot(
        lambda x: N(x) / f_low, (low, high), solver="anderson", tol=mp.mpf(10) ** -50, verify=False
    )
    assert low < factor < high
    q = near * factor
    return potential(z_of(q), D, lam, b), q


def ulps(found, exact):
    """The error of a double in units of its last place."""
    return float(abs(mp.mpf(found) - exact)) / math.ulp(float(exact))


def scales(parameters):
    """Where D [kg m^2/s] and lambda [kg m^3/s] are of the order of gravity."""
    D = math.sqrt(parameters["m"] * parameters["g"] * parameters["R"] * parameters["I3"])
    return D, parameters["R"] * D


def scattered(parameters, n, seed):
    """n random (D, lambda) over 12 decades each, of either sign."""
    rng, (D, lam) = np.random.default_rng(seed), scales(parameters)
    sign = rng.choice([-1, 1], (2, n))
    return sign[0] * D * 10 ** rng.uniform(-6, 6, n), sign[1] * lam * 10 ** rng.uniform(-6, 6, n)


def boxed(parameters, n, seed):
    """n random (D, lambda), uniform in a box where gravity and spin compete."""
    rng, (D, lam) = np.random.default_rng(seed), scales(parameters)
    return rng.uniform(-6, 6, n) * D, rng.uniform(-6, 6, n) * lam


def marked(parameters, n, seed):
    """n random (D, lambda) within 1e-6 (relative) of the two marked lines, down to a rounding of
    them.
    """
    rng, lam0 = np.random.default_rng(seed), scales(parameters)[1]
    b = body(parameters)
    slopes = [float(spinning.slope(z, b)) for z in (1, -1)]
    lam = lam0 * 10 ** rng.uniform(-2, 2, n)
    away = rng.choice([-1, 1], n) * 10 ** rng.uniform(-15, -6, n)
    return np.resize(slopes, n) * lam * (1 + away), lam
