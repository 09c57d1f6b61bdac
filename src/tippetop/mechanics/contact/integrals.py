"""Integrals of a body on the plane: place, angles, work and impulse of the contact.

NAMED contains the unit and the meaning of each; forms make them with their own rates. They are
integrated together with the state, and are rows and columns of a run.

Symbols
    q         the state of a form; carried: the record of all integrals; b: the body
"""

from collections.abc import Callable

from ..system import Integral
from ..units import JELLETT, JOULE, METRE, NEWTON_SECOND, RADIAN


NAMED = {
    "theta": (RADIAN, "angle theta of the axis of eccentricity, not wrapped"),
    "phi": (RADIAN, "azimuth phi of the horizontal projection of the axis"),
    "x": (METRE, "x of the centre of mass"),
    "y": (METRE, "y of the centre of mass"),
    "work": (JOULE, "energy taken by friction since the start"),
    "impulse": (NEWTON_SECOND, "integral of the normal force since the start"),
    "jellett_lost": (
        JELLETT,
        "Jellett's integral taken by the torque of the contact since the start",
    ),
    "jellett_reference": (JELLETT, "Jellett's integral when its ball first touched"),
}


def integral(name: str, rate: Callable | None) -> Integral:
    """Return the integral of this name, one of NAMED, which has its unit and meaning.

    `rate` is rate(q, carried, b), or None in a form of rows only.
    """
    unit, long_name = NAMED[name]
    return Integral(name, unit, long_name, rate, of="normal_force" if name == "impulse" else "")


def place(velocity: Callable) -> tuple[Integral, ...]:
    """Return the integrals x and y of the centre of mass.

    velocity(q, carried, b) returns its horizontal velocity, (2,) [m/s].
    """
    return tuple(
        integral(name, lambda q, carried, b, k=k: velocity(q, carried, b)[k])
        for k, name in enumerate("xy")
    )
