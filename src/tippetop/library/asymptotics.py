"""The states in which a tippe top may end, and their energy."""

import math

import numpy as np

from ..arguments import measured, measured_values, within
from ..errors import InputError
from ..mechanics.systems.tippe_top import TippeTop
from ..mechanics.theory import least_energy as least
from ..mechanics.theory.least_energy import AsymptoticState
from ..mechanics.units import JELLETT, RADIAN
from ..problem import Problem
from .finished_run import Run
from .sources import top_of


def asymptotic_states(
    top: TippeTop | Run | Problem | str, lam: float | str
) -> list[AsymptoticState]:
    """Compute the spinning and tumbling states of a tippe top for a value of Jellett's integral.

    Parameters
    ----------
    top : TippeTop, Run, Problem or str
        A body, or a run, a problem, the name of a preset or a TOML file.
    lam : float or str
        Jellett's integral lambda [kg m^3/s]; a text has a unit: "7e-6 kg m^3/s".

    Returns
    -------
    list of AsymptoticState
        From theta = 0 to pi, each with kind (upright, tumbling, inverted), theta [rad], phi_dot and
        omega3 [rad/s], energy [J], and whether it is stable where the contact glides.

    Raises
    ------
    InputError
        If the body is another one.

    Notes
    -----
    They are the critical points of `least_energy`, and stable where it has a minimum. Rutstam
    (2010), theorems 3.3.1 and 3.3.2, corrected.
    """
    number, body = measured("lam", lam, JELLETT), top_of(top, TippeTop).body()
    states = least.asymptotic_states(number, body)
    if not all(math.isfinite(state.energy) for state in states):
        raise InputError(
            f"`lam` must give energies in the range of a double, but {number:g} does not."
        )
    return states


def least_energy(
    top: TippeTop | Run | Problem | str,
    theta: float | str | np.ndarray,
    lam: float | str | np.ndarray,
) -> float | np.ndarray:
    """Compute the least energy E_lambda of a tippe top for a value of Jellett's integral.

    Parameters
    ----------
    top : TippeTop, Run, Problem or str
        The body, or what has one, as for `asymptotic_states`.
    theta : float, text with a unit, or array
        Inclination [rad], in [0, pi].
    lam : float, text with a unit, or array
        Jellett's integral lambda [kg m^3/s].

    Returns
    -------
    float or ndarray
        E_lambda [J], of the broadcast shape.

    Raises
    ------
    InputError
        If the body is another one, or these are no numbers.

    Notes
    -----
    E = E_lambda + m|s'|^2/2 + (omega - omega_lambda).I(omega - omega_lambda)/2 with omega_lambda =
    -lambda a/(a.I a). Rutstam (2010), eqs. 3.43 and 3.44, corrected.
    """
    theta = measured_values("theta", theta, RADIAN)
    lam = measured_values("lam", lam, JELLETT)
    within("theta", theta, 0, math.pi, "[0, pi]")
    try:
        np.broadcast_shapes(np.shape(theta), np.shape(lam))
    except ValueError:
        shapes = f"{np.shape(theta)} and {np.shape(lam)}"
        raise InputError(
            f"`theta` and `lam` must have shapes that broadcast, but have {shapes}."
        ) from None
    return least.least_energy(np.cos(theta), lam, top_of(top, TippeTop).body())
