"""Thresholds, regimes, final states and modes of a top, and the main equation along a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import flag, instance, measured, measured_values, seconds, within
from ..errors import InputError
from ..landscape.reconstruction import reconstruction
from ..mechanics.contact.body import Top
from ..mechanics.friction import has_parts
from ..mechanics.systems import SYSTEMS
from ..mechanics.systems.heavy_top import HeavyTop
from ..mechanics.systems.revolution import Disc, Outlined, Spheroid
from ..mechanics.systems.tippe_top import TippeTop
from ..mechanics.theory import eggs_and_discs, modes, regimes
from ..mechanics.theory import least_energy as least
from ..mechanics.theory import thresholds as limits
from ..mechanics.theory.least_energy import AsymptoticState
from ..mechanics.theory.regimes import Regime
from ..mechanics.theory.spinning import rolling_thresholds
from ..mechanics.theory.thresholds import Threshold
from ..mechanics.units import JELLETT, RADIAN, RADIAN_PER_SECOND
from ..problem import Problem
from .finished_run import Run
from .scenarios import record_of
from .sources import problem_behind, top_of


if TYPE_CHECKING:
    import xarray as xr


class Thresholds(dict):
    """Thresholds by name, which print one to a line: name, value with unit, meaning."""

    def __repr__(self) -> str:
        rows = [(name, f"{t.value:.6g} {t.unit.symbol}", t.long_name) for name, t in self.items()]
        name, value = (max(len(row[column]) for row in rows) for column in (0, 1))
        return "\n".join(f"{row[0]:<{name}}  {row[1]:<{value}}  {row[2]}" for row in rows)


def thresholds(top: Top | Run | Problem | str) -> dict[str, Threshold]:
    """Compute the numbers that separate the regimes of a top.

    Parameters
    ----------
    top : TippeTop, HeavyTop, Spheroid, Disc, Run, Problem or str
        A body, or a run, a problem, the name of a preset or a TOML file.

    Returns
    -------
    dict of Threshold
        By name, each with value, unit and long_name. Of a tippe top: lambda_u, lambda_s, lambda_de
        [kg m^3/s], spin_upright, spin_inverted, spin_full [rad/s], gamma, gamma_c, gamma_plus; of
        its surface and of rolling lambda_pi [kg m^3/s] and gamma_star. Of a heavy top:
        spin_sleeping [rad/s]. Of a spheroid or a disc: heights at rest [m], radii at the poles [m],
        mu_unique, and spin_upright, spin_inverted [rad/s] where a limit separates stable from
        unstable spins, under friction or, of a problem in pure rolling, there.

    Raises
    ------
    InputError
        If the body is another one.

    Notes
    -----
    Rutstam (2010), theorem 3.3.2, eqs. 4.29, 4.30, 5.54.
    """
    body = top_of(top, TippeTop, HeavyTop, Spheroid, Disc)
    if isinstance(body, Outlined):
        problem = problem_behind(top)
        rolls = problem is not None and not problem.system.frictional
        _, spins = eggs_and_discs.spins(body.body(), rolls=rolls)
        return Thresholds(eggs_and_discs.limits(body.body()) | spins)
    if isinstance(body, HeavyTop):
        return Thresholds(limits.thresholds_of_sleeping(body.body()))
    return Thresholds(limits.thresholds(body.body()) | rolling_thresholds(body.body()))


def regime(top: TippeTop | Run | Problem | str, lam: float | str) -> Regime:
    """Return which asymptotic states of a gliding tippe top are stable for a Jellett integral.

    Parameters
    ----------
    top : TippeTop, Run, Problem or str
        A body or a source of one, as for `thresholds`.
    lam : float or str
        Jellett's integral lambda [kg m^3/s], whose sign plays no part; a text has a unit: "7e-6 kg
        m^3/s".

    Returns
    -------
    Regime
        upright, inverted: whether that spin is stable; tumbling, unstable: theta [rad] of the
        stable and unstable tumbling states. `sentence()` describes the regime.

    Raises
    ------
    InputError
        If the body is another one.

    Notes
    -----
    Rutstam (2010), section 3.3.
    """
    return regimes.regime(measured("lam", lam, JELLETT), top_of(top, TippeTop).body())


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
        If the body is another one, or an energy overflows.

    Notes
    -----
    They are the critical points of `least_energy`, and stable where it has a minimum. Rutstam
    (2010), theorems 3.3.1 and 3.3.2, corrected.
    """
    number = measured("lam", lam, JELLETT)
    body = top_of(top, TippeTop).body()
    states = least.asymptotic_states(number, body)
    _require_energies(np.array([state.energy for state in states]), number)
    return states


def _require_energies(energies: np.ndarray, lam: Any) -> None:
    """Raise InputError if Jellett's integrals give infinite energies.

    `lam` is broadcast to the shape of `energies`, so that the message has the first one at fault.
    """
    if (beyond := np.broadcast_to(lam, energies.shape)[np.isinf(energies)]).size:
        raise InputError(
            f"`lam` must give energies in the range of a double, but {beyond[0]:g} does not."
        )


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
        If the body is another one, theta is outside [0, pi], these are no numbers, their shapes do
        not broadcast, or an energy overflows.

    Notes
    -----
    E_lambda = lambda^2/(2 a.I a) + m g s_z, with the arm a from the centre of mass to the contact,
    the tensor of inertia I and the height s_z of the centre of mass. The energy of any state is
    E = E_lambda + m|s'|^2/2 + (omega - omega_lambda).I(omega - omega_lambda)/2 with the velocity s'
    of the centre of mass and omega_lambda = -lambda a/(a.I a). Rutstam (2010), eqs. 3.43 and 3.44,
    corrected.
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
    with np.errstate(over="ignore"):
        # the square of a float would raise OverflowError, that of a NumPy number is infinite
        energy = least.least_energy(np.cos(theta), np.float64(lam), top_of(top, TippeTop).body())
    _require_energies(energy, lam)
    return energy


def linear_modes(
    top: Top | Run | Problem | str, law: Any = None, *, omega3: float | str, inverted: bool = False
) -> np.ndarray:
    """Compute the rates p of u_x + i u_y ~ exp(p t) near a spinning state.

    Parameters
    ----------
    top : TippeTop, HeavyTop, Spheroid, Run, Problem or str
        A body or a source of one, as for `thresholds`.
    law : friction law, optional
        A record such as `Viscous(mu=0.3)`. With one, the contact glides; without, it is at rest
        (pure rolling, or a fixed tip) - but a run, a problem or a preset has its own law.
    omega3 : float or str
        Spin about the axis [rad/s], or a text such as "1480 rpm".
    inverted : bool
        Whether the state is theta = pi.

    Returns
    -------
    ndarray of complex
        Rates [1/s], fastest growth first, of equal growth (to rounding) the fastest turning: three
        of a gliding top, two of one whose contact is at rest. The state is unstable iff the first
        has a positive real part. NaN where a number of the linear motion exceeds the doubles.

    Raises
    ------
    InputError
        If the body spins in no such state, the law is not known or has mu_r or mu_d, the motion is
        not linear (dry friction without eps), or a rate overflows.

    Notes
    -----
    The equations of motion, linearised about theta = 0 or pi: a cubic in p where the contact
    glides. Friedl (1997).
    """
    flag("inverted", inverted)
    body = top_of(top, TippeTop, HeavyTop, Spheroid)
    problem = problem_behind(top)
    spin = measured("omega3", omega3, RADIAN_PER_SECOND)
    friction = None
    if law is not None:
        friction = record_of(law, SYSTEMS[body.gliding])
    elif problem is not None and problem.system.frictional:
        friction = problem.friction
    if friction is not None and has_parts(friction):
        raise InputError(
            "the friction law must be without mu_r and mu_d: under them no spin lasts."
        )
    if friction is None:
        rates = modes.rolling_modes(spin, body.body(), inverted=inverted)
    else:
        rates = modes.linear_modes(spin, body.body(friction), inverted=inverted)
    if np.isfinite(rates).all():
        return rates
    if friction is not None and modes.is_nowhere_linear(spin, friction, inverted=inverted):
        raise InputError(
            "the friction law's k = |F|/(g_n |v_A|) must be finite as v_A goes to 0, for the "
            "motion to be linear there, but is not: give Coulomb friction its regularisation "
            "speed eps."
        )
    raise InputError(
        f"`omega3` must give rates in the range of a double, but {spin:g} rad/s does not."
    )


def reconstruct(run: Run, *, period: float | str | None = None) -> xr.Dataset:
    """Compute theta(t) of a run from D(t) and E~(t) alone, by the main equation.

    Parameters
    ----------
    run : Run
        Of a tippe top or heavy top that starts at a turning angle, with some hundred rows per
        nutation.
    period : float or str, optional
        A guess of the period of nutation [s]; by default twice the first turning time of the run.

    Returns
    -------
    xarray.Dataset
        `theta` [rad] along `time`, NaN where it ends early or after the last whole swing; `turning`
        [s], the times of the turnings; the attribute `mismatch`, the worst disagreement of
        cos(theta) where pieces meet or, where it ends early, the error that the next one may have.

    Raises
    ------
    InputError
        If the system has no such equation, the run no turnings, or the period is not positive.

    Warns
    -----
    UserWarning
        If it ends early, because the error of cos(theta) may exceed 1e-7 from there on: where rows
        are too few, or where errors grow by thousands from one turning to the next, as they do when
        the axis has risen (in the canonical inversion after 6.17 s and 312 turnings).

    Notes
    -----
    Rutstam (2010), eqs. 4.40 and 5.26; chapter 4 of the atlas derives what limits its accuracy.
    """
    instance("run", run, Run, "a Run")
    guess = seconds("period", period)
    if guess is not None and guess <= 0:
        raise InputError(f"`period` must be greater than 0, but is {period!r:.60}.")
    return reconstruction(run.problem, run.trajectory, run.events, guess)
