"""Potential and minimal surface from Python: first the body, then the momenta by their letters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..arguments import flag, instance, measured_values, positive_integer, within
from ..columns import require
from ..errors import InputError
from ..landscape import landscape_body, surface, turning
from ..landscape import marked_lines as lines_of
from ..landscape import potential as potential_of
from ..mechanics.contact.body import Top
from ..mechanics.contact.surroundings import require_still
from ..mechanics.units import JELLETT, JOULE, ONE, RADIAN
from ..problem import Problem
from .finished_run import Run
from .sources import problem_behind


if TYPE_CHECKING:
    import xarray as xr

Body = Top | Run | Problem | str | Mapping[str, Any]


def minimal_surface(
    top: Body,
    *,
    gradient: bool = True,
    threads: int | None = None,
    **momenta: Any,
) -> xr.Dataset:
    """Compute the minimal surface F = inf V over a grid of the two momenta.

    Parameters
    ----------
    top : TippeTop, HeavyTop, Run, Problem, str or mapping
        The body, or the name of a preset, a TOML file or the tables of a scenario.
    D, lam : float or array, ascending
        Of a tippe top: Routh's function D [kg m^2/s] and Jellett's integral lambda [kg m^3/s].
    L3, Lz : float or array, ascending
        Of a heavy top: the angular momenta [kg m^2/s] about the axis and, at the tip, about the
        vertical.
    gradient : bool
        Whether the derivatives of F by both momenta are computed.
    threads : int, optional
        How many threads compute; by default as many as cores. The result does not depend on it.

    Returns
    -------
    xarray.Dataset
        F [J], z = cos(theta), theta [rad] of the minimum, status, and the gradient: F_D [1/s] and
        F_lambda [1/(m s)], or F_L3 and F_Lz [1/s]; each over D and lambda, or L3 and Lz; a number,
        not an array, is no dimension.

    Raises
    ------
    InputError
        If an axis is empty or does not ascend, a momentum is missing, or the body has no landscape.

    Notes
    -----
    F is good to 4 units of rounding. Rutstam (2010), eq. 4.13. `status`: attained; at_lower_end,
    at_upper_end: an infimum that is approached at theta = 0, pi (exchanged for heavy tops and
    pegs), the momenta being on a marked line; lower_of_two; unsettled; undefined (an argument is
    not finite: F is NaN).
    """
    t, x, y = _body_and_momenta(top, momenta)
    flag("gradient", gradient)
    threads = None if threads is None else positive_integer("threads", threads)
    return surface.minimal_surface(t, x, y, gradient=gradient, threads=threads)


def potential(
    top: Body,
    z: Any,
    **momenta: Any,
) -> xr.Dataset:
    """Compute the effective potential V(z) [J] and its derivatives by z, over a grid.

    Parameters
    ----------
    top : TippeTop, HeavyTop, Run, Problem, str or mapping
        The body, or the name of a preset, a TOML file or the tables of a scenario.
    z : float or array, ascending
        cos(theta), in [-1, 1].
    **momenta
        D and lam, or L3 and Lz, as for `minimal_surface`.

    Returns
    -------
    xarray.Dataset
        V, V_z, V_zz [J], each over z, D and lambda, or z, L3 and Lz; a number, not an array, is no
        dimension. NaN for infinite momenta, and at z = -1 and 1: there V is infinite, except for
        the momenta of a spin about the vertical (see `marked_lines`).

    Raises
    ------
    InputError
        If an axis is empty or does not ascend, z is outside [-1, 1], a momentum is missing, or the
        body has no landscape.

    Notes
    -----
    Rutstam (2010), eqs. 4.12, 2.38, 5.26. No digits are lost near the poles.
    """
    t, x, y = _body_and_momenta(top, momenta)
    z = measured_values("z", z, ONE)
    within("z", z, -1, 1, "[-1, 1]")
    return potential_of.potential(t, z, x, y)


def turning_angles(
    top: Body,
    energy: Any = None,
    *,
    theta: Any = None,
    **momenta: Any,
) -> xr.Dataset:
    """Compute the angles where V = E~ and the periods of this and of small nutations.

    Parameters
    ----------
    top : TippeTop, HeavyTop, Run, Problem, str or mapping
        The body, or the name of a preset, a TOML file or the tables of a scenario.
    **momenta
        D and lam, or L3 and Lz, as for `minimal_surface`, but of any shape: they are broadcast
        against one another and against the energy.
    energy : float or array
        The modified energy E~ [J].
    theta : float or array, optional
        An angle [rad] of the motion, broadcast too: it selects one of two wells; by default, and
        for NaN, the deeper one.

    Returns
    -------
    xarray.Dataset
        Of the broadcast shape: theta_min <= theta_star <= theta_max [rad], theta_star where V is
        least in this band; F [J] there; other_theta_min, other_theta_max [rad] of the band in the
        other well, NaN without one; `period` [s] of nutation, NaN where it does not settle to 11
        digits (nutations of some 1e-5 rad or less, and next to a separatrix); `small_period` [s],
        exact for vanishing amplitude; `level`: above; touching: E~ is the minimum to 1e-12, both
        angles are theta_star; below; undefined.

    Raises
    ------
    InputError
        If a momentum or the energy is missing, shapes do not broadcast, theta is outside [0, pi],
        or the body has no landscape.

    Notes
    -----
    Rutstam (2010), eqs. 4.12 and 4.21.
    """
    t, x, y = _body_and_momenta(top, momenta)
    if energy is None:
        raise InputError("`energy` must be given, but is missing.")
    energy = measured_values("energy", energy, JOULE)
    if theta is not None:
        theta = measured_values("theta", theta, RADIAN)
        within("theta", theta, 0, math.pi, "[0, pi]")
    return turning.turning_angles(t, x, y, energy, theta=theta)


def band(run: Run) -> xr.Dataset:
    """Compute the predicted band along a run, V <= E~, from its momenta and E~; NaN in flight.

    Parameters
    ----------
    run : Run
        Of a tippe top or heavy top.

    Returns
    -------
    xarray.Dataset
        As `turning_angles`, along `time`, with the momenta, modified_energy [J] and theta [rad] of
        the run; theta, if the run has it, selects one of two wells.

    Raises
    ------
    InputError
        If the system has no such landscape, or the run lacks one of these columns.

    Notes
    -----
    Rutstam (2010), eqs. 4.21 and 5.26.
    """
    instance("run", run, Run, "a Run")
    t = _body(run)
    trajectory = run.trajectory
    phase = ("phase",) if "contact" in run.attributes else ()
    require(("theta", *phase), trajectory, "the band along a run")
    return turning.band(t, trajectory)


def marked_lines(top: Body, lam: Any) -> xr.Dataset:
    """Compute the spinning states theta = 0, pi of a tippe top, as lines on the minimal surface.

    Parameters
    ----------
    top : TippeTop, Run, Problem, str or mapping
        The body, as for `minimal_surface`.
    lam : float or array, ascending
        Jellett's integral [kg m^3/s].

    Returns
    -------
    xarray.Dataset
        Over `end` (theta = 0, theta = pi) and `lambda`: D [kg m^2/s], E, the modified energy E~
        [J], omega3 [rad/s], and `on_surface`, whether E~ = F there: theta = 0 always, theta = pi
        iff |lambda| >= lambda_pi, which is an attribute [kg m^3/s]. Of a peg (alpha < 0) it is
        theta = pi always, and theta = 0 from lambda_pi on.

    Raises
    ------
    InputError
        If the axis is empty or does not ascend, the body is no tippe top, or its plane is not at
        rest and level or its air not still.

    Notes
    -----
    Rutstam (2010), eqs. 4.23-4.28.
    """
    return lines_of.marked_lines(_body(top), measured_values("lam", lam, JELLETT))


def _body(top: Body) -> landscape_body.Top:
    """Return the body behind the argument `top`.

    Raises InputError if it has no landscape, or a plane or air that changes the potential.
    """
    if isinstance(top, Top):
        return landscape_body.top(top._asdict(), top.gliding)
    problem = problem_behind(top)
    assert problem is not None  # a body was looked for above
    require_still(problem.tables, "a top in a landscape")
    return landscape_body.top(problem.parameters, problem.system)


def _body_and_momenta(top: Body, momenta: Mapping[str, Any]) -> tuple[landscape_body.Top, Any, Any]:
    """Return the body and its two momenta in SI units, each a number or an array.

    `momenta` has exactly the keys D and lam, or L3 and Lz; otherwise raises InputError.
    """
    t = _body(top)
    names = ["lam" if symbol == "lambda" else symbol for symbol in t.momenta]
    sentences = [
        f"`{letter}` is no momentum of {t.system.name}: it has {' and '.join(names)}."
        for letter in momenta
        if letter not in names
    ]
    missing = [name for name in names if name not in momenta]
    sentences += [f"`{name}` must be given, but is missing." for name in missing]
    if sentences:
        raise InputError(sentences)
    x, y = (
        measured_values(name, momenta[name], momentum.unit)
        for name, momentum in zip(names, t.landscape.momenta, strict=True)
    )
    return t, x, y
