"""The states in which a tippe top may end, their energy, and the general system."""

import math
from typing import NamedTuple

import numpy as np

from ..arguments import measured, measured_values, numbers, within
from ..errors import InputError
from ..mechanics.contact.rolling.rolling_euler import EulerState, general_accelerations
from ..mechanics.systems.tippe_top import TippeTop
from ..mechanics.theory import least_energy as least
from ..mechanics.theory.least_energy import AsymptoticState
from ..mechanics.units import JELLETT, METRE_PER_SECOND2, RADIAN, RADIAN_PER_SECOND
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
        The body, or what has one: a run, a problem, the name of a preset, a TOML file.
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
    theta = numbers("theta", measured_values("theta", theta, RADIAN))[()]
    lam = numbers("lam", measured_values("lam", lam, JELLETT))[()]
    within("theta", theta, 0, math.pi, "[0, pi]")
    try:
        np.broadcast_shapes(np.shape(theta), np.shape(lam))
    except ValueError:
        shapes = f"{np.shape(theta)} and {np.shape(lam)}"
        raise InputError(
            f"`theta` and `lam` must have shapes that broadcast, but have {shapes}."
        ) from None
    return least.least_energy(np.cos(theta), lam, top_of(top, TippeTop).body())


class Accelerations(NamedTuple):
    """theta'', phi'' and omega_3' [rad/s^2]."""

    theta_ddot: float
    phi_ddot: float
    omega3_dot: float


def accelerations(
    top: TippeTop | Run | Problem | str,
    *,
    theta: float | str,
    theta_dot: float | str = 0.0,
    phi_dot: float | str = 0.0,
    omega3: float | str = 0.0,
    w_x: float | str = 0.0,
    w_y: float | str = 0.0,
) -> Accelerations:
    """Compute the accelerations of a tippe top from that of its contact point.

    Parameters
    ----------
    top : TippeTop, Run, Problem or str
        The body, or what has one, as for `asymptotic_states`.
    theta : float or str
        Inclination [rad], in (0, pi); each number may be a text with a unit: "30 deg".
    theta_dot, phi_dot, omega3 : float or str
        Rates [rad/s].
    w_x, w_y : float or str
        Acceleration of the contact point [m/s^2], dv_A/dt = w_x e + w_y 2hat; none is pure rolling.
        Under friction it is w_x = nu_x' - phi' nu_y, w_y = nu_y' + phi' nu_x.

    Returns
    -------
    Accelerations
        theta_ddot, phi_ddot, omega3_dot [rad/s^2].

    Raises
    ------
    InputError
        If the body is another one, or theta is not in (0, pi).

    Notes
    -----
    Whatever friction does, F = m s'' + m g zhat follows from the motion. Rutstam (2010), eqs. 3.36,
    4.2-4.4.
    """
    body, angle = top_of(top, TippeTop).body(), measured("theta", theta, RADIAN)
    if not 0 < angle < math.pi:
        raise InputError(f"`theta` must lie in (0, pi), but is {theta}.")
    rates = (("theta_dot", theta_dot), ("phi_dot", phi_dot), ("omega3", omega3))
    state = EulerState(angle, *(measured(name, value, RADIAN_PER_SECOND) for name, value in rates))
    pushes = measured("w_x", w_x, METRE_PER_SECOND2), measured("w_y", w_y, METRE_PER_SECOND2)
    return Accelerations(
        *general_accelerations(state, math.sin(angle), math.cos(angle), *pushes, body)
    )
