"""Which asymptotic states are stable for a value of Jellett's integral.

A value of lambda and a body b in SI units go in, a `Regime` comes out.
"""

from typing import NamedTuple

from ..contact.body import Touch
from .least_energy import asymptotic_states


class Regime(NamedTuple):
    """Which asymptotic states are stable for a value of Jellett's integral."""

    upright: bool
    inverted: bool
    tumbling: tuple[float, ...]  # theta of the stable tumbling states [rad], descending z
    unstable: tuple[float, ...]  # theta of the unstable ones

    @property
    def attractors(self) -> list[str]:
        """Return the stable states in words, from theta = 0 to pi."""
        words = ["the upright spin"] if self.upright else []
        words += [f"tumbling at theta = {theta:.6g} rad" for theta in self.tumbling]
        return words + (["the inverted spin"] if self.inverted else [])

    def sentence(self) -> str:
        """Return a clause on which states are stable, for `Outlook.regime`."""
        states = self.attractors
        if not states:
            return "no spinning or tumbling state is stable"
        if len(states) == 1:
            return f"only {states[0]} is stable"
        word = "both" if len(states) == 2 else "all"
        return f"{', '.join(states[:-1])} and {states[-1]} are {word} stable"


def regime(lam: float, b: Touch) -> Regime:
    """Return which asymptotic states of a tippe top are stable. [T Theorem 3.3.2, corrected]

    Parameters
    ----------
    lam
        Jellett's integral [kg m^3/s]; its sign plays no part.
    b
        The body, SI.
    """
    upright, *tumbling, inverted = asymptotic_states(lam, b)
    return Regime(
        upright.stable,
        inverted.stable,
        tuple(state.theta for state in tumbling if state.stable),
        tuple(state.theta for state in tumbling if not state.stable),
    )
