"""Tumbling states of a tippe top, and every asymptotic state as curves over lambda.

Symbols
    b         the body in SI units, a `contact.body.Touch`; alpha, gamma, beta: see `Shape`
    z         cos(theta); lam, lambda: Jellett's integral [kg m^3/s]

Theorem 3.3.2 of the source is used as corrected: below gamma_+ some tumbling states near the
upright are unstable, and below gamma_c the upright spin outlives the inverted one.
"""

import itertools
from typing import Any, NamedTuple

import numpy as np

from ..contact.body import Touch
from .thresholds import SPINS, lambda_s, lambda_u, sense, shape, spins_by_height


def tumbling_limits(b: Touch) -> tuple[float, float]:
    """Return the open interval of z = cos(theta) in which tumbling states exist. [T 3.62, 3.63]

    There the root in `tumbling_jellett` is real: a change of one is a change of both.
    """
    alpha, gamma, *_ = shape(b)
    low = max(-1.0, -alpha / (gamma - 1)) if gamma > 1 else -1.0
    high = min(1.0, alpha / (1 - gamma)) if gamma < 1 else 1.0
    return (low, high) if sense(b) > 0 else (-high, -low)


def tumbling(z: Any, b: Touch) -> tuple[Any, Any]:
    """Return phi' and omega_3 [rad/s] of the tumbling state at z, for phi' > 0.

    Both are NaN if there is no such state.

    [T 3.62]
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        phi_dot = np.sqrt(b.m * b.g * b.c / (b.I3 * (b.c / b.R - z) + b.I1 * z))
    return phi_dot, -(b.c / b.R - z) * phi_dot


def tumbling_jellett(z: Any, b: Touch) -> Any:
    """Return lambda of the tumbling state at z, for phi' > 0 [kg m^3/s], or NaN.

    [T 3.42, 3.66]
    """
    alpha, gamma, _, beta = shape(b)
    z = sense(b) * z
    with np.errstate(invalid="ignore", divide="ignore"):
        return beta * ((alpha - z) ** 2 + gamma * (1 - z**2)) / np.sqrt(alpha + (gamma - 1) * z)


def lambda_t(b: Touch) -> Any:
    """Return the least lambda of a tumbling state [kg m^3/s].

    For gamma < gamma_plus it is less than lambda_u and lambda_s; between it and the lesser of these
    two, upright spin and tumbling are both stable. Its relative error is about 1e-5. Of one body,
    or of many, (n,).
    """
    # (401, 1) for many bodies, so that both broadcast
    z = np.linspace(-1, 1, 401).reshape(-1, *(1,) * np.ndim(b.I1 + b.I3 + b.c))
    return np.nanmin(tumbling_jellett(z, b), axis=0)


def tumbling_is_stable(z: Any, b: Touch) -> Any:
    """Return whether the tumbling state at z is stable, which is d|lambda|/dz < 0.

    [T Theorem 3.3.2, corrected]
    """
    alpha, gamma, *_ = shape(b)
    rising = ((1 - gamma) * (sense(b) * z) - alpha) ** 2 > gamma * (1 - alpha**2 - gamma) / 3
    return rising & np.isfinite(tumbling_jellett(z, b))


def tumbling_states(lam: float, b: Touch) -> np.ndarray:
    """Return every z at which a tumbling state has Jellett's integral lam, ascending.

    They are roots of a quartic, the square of `tumbling_jellett`(z) = lam without denominator: a
    change of one is a change of both.

    Terms that rounding hides for every z in [-1, 1] are left out: their roots lie far beyond, but
    `np.roots` would place them anywhere.
    """
    alpha, gamma, _, beta = shape(b)
    h = np.array([1 - gamma, -2 * alpha, alpha**2 + gamma])
    unit = max(abs(lam), beta)
    rest = np.polysub(
        (beta / unit) ** 2 * np.polymul(h, h), (lam / unit) ** 2 * np.array([gamma - 1, alpha])
    )
    roots = np.roots(np.where(np.abs(rest) < 1e-20 * np.abs(rest).max(), 0, rest))
    z = np.sort(sense(b) * roots[np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots))].real)
    low, high = tumbling_limits(b)
    return z[(z > low) & (z < high)]


class Branch(NamedTuple):
    """A curve of asymptotic states, lambda [kg m^3/s] and z = cos(theta), all stable or all not."""

    kind: str
    stable: bool
    z: np.ndarray
    lam: np.ndarray


def branches(b: Touch, most: float) -> list[Branch]:
    """Return every asymptotic state of a tippe top, as curves cut where stability changes.

    [T figure 3.3]

    Parameters
    ----------
    b
        The body, SI.
    most
        The spinning states are given for 0 <= lambda <= most [kg m^3/s]; the tumbling ones wherever
        they are.

    Notes
    -----
    The lowest spin is stable below lambda_u, the highest one above lambda_s.
    """
    result = []
    for kind, limit, inside in zip(
        spins_by_height(b), (lambda_u(b), lambda_s(b)), (True, False), strict=True
    ):
        for ends, calm in (
            ((0.0, min(limit, most)), inside),
            ((min(limit, most), most), not inside),
        ):
            if ends[0] < ends[1]:
                result.append(Branch(kind, calm, np.full(2, float(SPINS[kind])), np.array(ends)))
    low, high = tumbling_limits(b)
    z = low + (high - low) * (1 - np.cos(np.linspace(0, np.pi, 2001)[1:-1])) / 2
    lam: Any = tumbling_jellett(z, b)
    stable: Any = tumbling_is_stable(z, b)
    cuts = [0, *(np.flatnonzero(np.diff(stable)) + 1), len(z)]
    for first, last in itertools.pairwise(cuts):
        piece = slice(first, min(last + 1, len(z)))  # one point on, so that the curve has no gap
        result.append(Branch("tumbling", bool(stable[first]), z[piece], lam[piece]))
    return result
