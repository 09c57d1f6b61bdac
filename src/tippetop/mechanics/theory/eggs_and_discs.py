"""Rest, spins at the poles and steady rolling of a body of revolution with an outline.

A body in SI units goes in; out come limits by name, as `Threshold`s with their meaning, which
`systems.outlook` reports. At a pole the body moves as the ball by which it touches there.

Symbols
    b         the body, a `contact.body.Touch`; z: cos(theta), 1 or -1 at the poles
    high      height of the centre of mass on the plane [m]
    rolls     whether the contact is at rest, or slides under friction
"""

import math

import numpy as np

from ..contact.body import Touch, touching_ball
from ..contact.uniqueness import THETA, painleve_bound
from ..units import METRE, ONE, RADIAN_PER_SECOND
from .modes import stability
from .thresholds import SPINS, Threshold


@np.errstate(all="ignore")  # a disc has no ball at its poles
def spins(b: Touch, *, rolls: bool = False) -> tuple[list[str], dict[str, Threshold]]:
    """Return which spins at the poles are stable, in words, and the limits of their speed.

    The words are clauses of a sentence of `outlook.revolution`; the limits are `Threshold`s by
    name, "spin_upright", "spin_inverted". A pole at which no ball touches, as of a disc, is left
    out.
    """
    words = []
    found = {}
    for name, z in SPINS.items():
        if not np.isfinite(touching_ball(z, 0.0, b).R):
            continue
        steadies, topples = stability(z, b, rolls=rolls)
        how = ("neutral", "stable", "unstable")[int(np.sign(steadies - topples))]
        if steadies * topples > 0:
            limit = math.sqrt(topples / steadies)
            how = "above" if topples > 0 else "below"
            text = f"{name} spin stable {how}"
            found[f"spin_{name}"] = Threshold(limit, RADIAN_PER_SECOND, text)
            how = f"stable {how} {limit:.6g} rad/s"
        words.append(f"the {name} spin is {how}")
    return words, found


@np.errstate(all="ignore")  # a disc has no ball at its poles
def limits(b: Touch) -> dict[str, Threshold]:
    """Return the heights at rest, the balls at the poles, and Painleve's bound, by name.

    A tilted rest is where c = 0 of the touching ball, between two inclinations of the grid THETA.
    """
    found = {}

    def rest(name: str, theta: float, more: str = "") -> None:
        """Add the height of the centre of mass at rest at theta, if the body can rest there."""
        high = touching_ball(math.cos(theta), math.sin(theta) ** 2, b).height
        words = f"height of the centre of mass at rest at theta = {theta:.6g} rad{more}"
        if high > 0:  # a thick disc touches with its other edge there
            found[name] = Threshold(high, METRE, words)

    for name, z in SPINS.items():
        rest(f"height_{name}", math.acos(z))
        if np.isfinite(R := touching_ball(z, 0.0, b).R):
            found[f"radius_{name}"] = Threshold(R, METRE, "radius of the ball that touches there")
    ball = touching_ball(np.cos(THETA), np.sin(THETA) ** 2, b)
    c = ball.c
    for k, i in enumerate(np.flatnonzero(np.sign(c[:-1]) * np.sign(c[1:]) < 0)):
        theta = THETA[i] + (THETA[i + 1] - THETA[i]) * c[i] / (c[i] - c[i + 1])
        kind = "least" if ball.bend[i] < 0 else "greatest"
        rest(f"height_tilted_{k}" if k else "height_tilted", theta, f", where it is {kind}")
    found["mu_unique"] = Threshold(
        painleve_bound(b), ONE, "Coulomb friction with one contact force below"
    )
    return found


def steady_rolling(theta: float, phi_dot: float, b: Touch) -> dict[str, Threshold]:
    """Return omega_3 of steady rolling at theta and phi', and the friction that it needs.

    Angles in rad, rates in rad/s. They are NaN or infinite where the body cannot roll so.
    """
    s = math.sin(theta)
    z = math.cos(theta)
    ball = touching_ball(z, s * s, b)
    high = ball.height
    q = ball.c - ball.R * z
    # z'' = 0, as of `rolling.z_dot2` with z' = 0, is linear in omega_3; solved by hand it loses no
    # digits where phi' is small or large
    drive = b.I1 * z * phi_dot**2 - b.m * (ball.c * b.g + high * q * phi_dot**2)
    omega3 = drive / ((b.I3 + b.m * high * ball.R) * phi_dot)
    mu = abs(phi_dot * s * (ball.R * omega3 + q * phi_dot)) / b.g
    words = "steady rolling at theta and phi_dot of the start"
    return {
        "spin_steady": Threshold(omega3, RADIAN_PER_SECOND, f"omega3 of {words}"),
        "mu_steady": Threshold(mu, ONE, f"Coulomb friction that {words} needs"),
    }
