"""Which asymptotic states are stable for a value of Jellett's integral."""

from typing import NamedTuple

import numpy as np

from ..contact.body import Touch
from .thresholds import lambda_s, lambda_u, poles
from .tumbling import tumbling_is_stable, tumbling_states


class Regime(NamedTuple):
    """Which asymptotic states are stable for a value of Jellett's integral."""

    upright: bool
    inverted: bool
    tumbling: tuple[float, ...]  # theta of the stable tumbling states [rad], descending z
    unstable: tuple[float, ...]  # theta of the unstable ones

    @property
    def attractors(self) -> list[str]:
        """The stable states in words."""
        words = ["the upright spin"] if self.upright else []
        words += [f"tumbling at theta = {theta:.6g} rad" for theta in self.tumbling]
        return words + (["the inverted spin"] if self.inverted else [])

    def sentence(self) -> str:
        """What is stable."""
        states = self.attractors
        if not states:
            return "no spinning or tumbling state is stable"
        if len(states) == 1:
            return f"only {states[0]} is stable"
        word = "both" if len(states) == 2 else "all"
        return f"{', '.join(states[:-1])} and {states[-1]} are {word} stable"


def regime(lam: float, b: Touch) -> Regime:
    """Which asymptotic states of a tippe top are stable. [T Theorem 3.3.2, corrected]

    Parameters
    ----------
    lam
        Jellett's integral [kg m^3/s]; its sign plays no part.
    b
        The body, SI.
    """
    states = tumbling_states(lam, b)[::-1] if lam else np.zeros(0)
    stable = [bool(tumbling_is_stable(z, b)) for z in states]
    angles = np.arccos(states)
    spins = dict(zip(poles(b), (abs(lam) < lambda_u(b), abs(lam) > lambda_s(b)), strict=True))
    return Regime(
        upright=bool(spins["upright"]),
        inverted=bool(spins["inverted"]),
        tumbling=tuple(float(t) for t, s in zip(angles, stable, strict=True) if s),
        unstable=tuple(float(t) for t, s in zip(angles, stable, strict=True) if not s),
    )
