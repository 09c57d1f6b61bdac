"""Parameters of a contact that may open: the law of impact, and the stem.

`scenario.contact` makes a `ContactLaw` of the tables [contact] and [stem]; jumps take it as
`world.rules`.
"""

import math
from typing import NamedTuple

import numpy as np

from ..number import Number
from ..units import METRE, ONE


RESTITUTIONS = ("energetic", "poisson", "newton")
"""Laws of impact, the keys of `impact_motion.ENDS`. "energetic" (Stronge): the work of restitution
is e_n^2 times that of compression. "poisson": the normal impulse of restitution is e_n times that
of compression. "newton": the normal velocity after the impact is -e_n times that before, which can
make energy.
"""

# least radius of a stem's ball, and longest stem, by the radius of the sphere; beyond it the number
# is a mistake of the user
LEAST_RADIUS, LONGEST = 1e-9, 1e6


class ContactLaw(NamedTuple):
    """Parameters of impacts and of the stem, SI.

    Parameters
    ----------
    restitution
        The law of impact, one of RESTITUTIONS.
    e_n
        Its coefficient.
    r, h
        Radius of the stem's ball, and how far along 3hat its centre lies from the centre of the
        sphere; NaN: no stem.
    """

    restitution: str = "energetic"
    e_n: float = 0.0
    r: float = math.nan
    h: float = math.nan

    @property
    def stem(self) -> bool:
        """Return whether there is a stem: h, of one top or of many, is not NaN."""
        return bool(np.all(self.h == self.h))


CONTACT = {"e_n": Number(ONE, "coefficient of restitution e_n", least=0, most=1, symbol="e_n")}
STEM = {
    "r": Number(METRE, "radius of the stem's ball", above=0),
    "h": Number(
        METRE,
        "distance from the centre of the sphere to that of the stem's ball, along 3hat",
        above=0,
    ),
}


def stem_faults(R: float, r: float, h: float) -> list[str]:
    """Return [] or a sentence about a stem that does not fit a sphere of radius R.

    r, h of `ContactLaw` [m]. `Problem` is refused by it; `scenario.contact` skips further checks of
    such a stem.
    """
    if not r < R:
        return [f"`stem.r` must be smaller than parameters.R = {R:.6g}, but is {r:.6g}."]
    if not r > LEAST_RADIUS * R:
        return [
            f"`stem.r` must be greater than {LEAST_RADIUS:g} parameters.R = "
            f"{LEAST_RADIUS * R:.6g}, but is {r:.6g}."
        ]
    if not h < LONGEST * R:
        return [
            f"`stem.h` must be less than {LONGEST:g} parameters.R = {LONGEST * R:.6g}, but is "
            f"{h:.6g}."
        ]
    if not h > R - r:
        return [
            f"`stem.h` must exceed R - r = {R - r:.6g}, or the stem never touches the plane, "
            f"but is {h:.6g}."
        ]
    return []
