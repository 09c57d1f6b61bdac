"""Derivatives of a motion by its numbers, and the growth of small errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import dotted_keys, names_of, positive_integer, takes
from ..columns import column
from ..errors import InputError
from ..mechanics.units import ONE, PER_SECOND, SECOND
from ..runs import attributes
from .finished_run import Run
from .scenarios import problem_of


if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivities:
    """Derivatives of a run by some of its numbers. `tippetop.derivatives.sensitivities` makes it.

    Attributes
    ----------
    run : Run
        The run itself.
    trajectory : xarray.Dataset
        The derivative of every column along `time` and `parameter`, SI units per SI unit.
    events : xarray.Dataset
        Of each event along `event` and `parameter`: the derivative of its `time`, and of `theta`
        there.
    second : xarray.Dataset
        Second derivatives of the columns, along `time`, `parameter` and `parameter_2`; empty unless
        `order=2`.
    phases, impacts : xarray.Dataset
        Of each phase and each impact, the derivative of the time at which it begins; empty where
        the contact cannot change.
    sentences : tuple of str
        Why derivatives are NaN: from when on, by which number, and because of which event.

    Notes
    -----
    Where the contact may change, each table has `valid_within`: the relative change of a number (of
    its unit in the run, if it is 0) up to which the phases follow each other as they do; beyond
    it, the motion is another one. It is an estimate to first order. Derivatives are NaN where it is
    less than 1e-9.
    """

    run: Run
    trajectory: xr.Dataset
    events: xr.Dataset
    second: xr.Dataset
    phases: xr.Dataset
    impacts: xr.Dataset
    sentences: tuple[str, ...] = ()

    def __repr__(self) -> str:
        names = ", ".join(map(str, self.trajectory.parameter.values))
        return (
            f"<Sensitivities of {self.run.attributes['system']} by {names}: "
            f"{self.trajectory.sizes['time']} rows>"
        )


@takes(problem_of)
def sensitivities(
    source: Any, wrt: Sequence[str], friction: Any = None, *, order: int = 1, **arguments: Any
) -> Sensitivities:
    """Compute derivatives of the columns and events of a run by its numbers.

    The numbers are those of the body, the law and the start.

    Parameters
    ----------
    source : body, str, path, System, mapping or Problem
        As for `run`.
    wrt : list of str
        Names of numbers: "alpha", "mu", "omega3", ...; write one that occurs in several
        tables with its table, "friction.mu", as the results do.
    friction : law or mapping, optional
        As for `run`.
    order : int
        1, or 2 for second derivatives too.
    {names}
        As for `run`.

    Returns
    -------
    Sensitivities

    Raises
    ------
    InputError
        If a name is wrong, or the run has no derivatives.

    Notes
    -----
    By the variational equations, along one direction in each SIMD lane: exact to rounding, no
    differences are taken. Units of mass, length and time are those of the run, and fixed. A column
    that is undefined at a pole is NaN there. Where the equations cannot be integrated further along
    one direction, the derivatives along up to eight directions are NaN.

    Examples
    --------
    >>> import tippetop as tt
    >>> s = tt.derivatives.sensitivities("inverting", ["friction.mu", "initial.omega3"], until=4.0)
    >>> s.trajectory.theta.sel(parameter="friction.mu").plot()
    """
    from ..engine.derivatives.sensitivities import differentiate
    from ..problem import refuse
    from ..runs.run import with_phases

    wrt = names_of("wrt", wrt)
    if positive_integer("order", order) > 2:
        raise InputError(f"`order` must be 1 or 2, but is {order!r:.60}.")
    problem = problem_of(source, friction, **arguments)
    if problem.output == "keyframes":
        raise InputError('`output` must keep rows for derivatives, but is "keyframes".')
    wrt = tuple(dotted_keys(wrt, problem.rules))
    refuse(problem, wrt)
    if order == 2 and problem.system.is_hybrid:
        raise InputError("`order` must be 1 where the contact may change, but is 2.")
    solution, driver = with_phases(problem)
    run = Run(solution)
    moments = {}
    if problem.system.tables:
        moments["phases"] = run.phases.start
    if problem.contact is not None:
        moments["impacts"] = run.impacts.time
    derived, sentences = differentiate(
        problem, wrt, solution.times, solution.events, order, moments, driver
    )
    names = "trajectory", "events", "second", "phases", "impacts"  # fields of Sensitivities
    tables = {name: _labelled(problem, wrt, derived.get(name, {}), run) for name in names}
    return Sensitivities(run, **tables, sentences=tuple(sentences))


def _labelled(problem: Any, wrt: Sequence[str], columns: Any, run: Run) -> xr.Dataset:
    """Return columns of derivatives as a Dataset, with names and units of the numbers `wrt`.

    `columns` are those of one table of `differentiate`, none if it is missing there. The Dataset
    has the root attributes of the run, and the numbers as coordinates where a column has their
    dimension `parameter` or `parameter_2`; `unit` is that of each.
    """
    dims = {dim for one in columns.values() for dim in one.dims}
    names = {name: (name, list(wrt)) for name in ("parameter", "parameter_2") if name in dims}
    if names:
        names["unit"] = ("parameter", [problem.rules[name].unit.symbol for name in wrt])
    return attributes.dataset(columns | names, run.attributes).set_coords(names)


@takes(problem_of)
def lyapunov(source: Any, friction: Any = None, *, rows: int = 201, **arguments: Any) -> xr.Dataset:
    """Compute how fast small errors of the start grow, and when a double no longer predicts.

    Parameters
    ----------
    source : body, str, path, System, mapping or Problem
        As for `run`.
    friction : law or mapping, optional
        As for `run`.
    rows : int
        Times from 0 to the end of the run.
    {names}
        As for `run`.

    Returns
    -------
    xarray.Dataset
        `factor` (the largest growth of an error, in the norm of 3hat, L and r' in units of m, R and
        the power of two seconds nearest to sqrt(R/g)) and `exponent` (finite-time Lyapunov
        exponent, s-1) along `time`; attributes `horizon` (when an error of 1e-16 has grown to 1e-3
        [s]; NaN if it does not) and `sentence` (horizon or, without one, the largest error).

    Raises
    ------
    InputError
        If the run has no derivatives.

    Examples
    --------
    >>> import tippetop as tt
    >>> print(tt.derivatives.lyapunov("inverting").sentence)
    """
    from ..problem import refuse
    from ..runs.growth import growth
    from ..runs.run import solve

    if positive_integer("rows", rows) < 2:
        raise InputError(f"`rows` must be at least 2, but is {rows!r:.60}.")
    problem = problem_of(source, friction, **arguments)
    refuse(problem, ())
    result = growth(problem, np.linspace(0.0, float(solve(problem).times[-1]), rows))
    columns = {
        "time": column(result.times, SECOND, "time"),
        "factor": column(result.factor, ONE, "largest growth of a small error of the start"),
        "exponent": column(result.exponents, PER_SECOND, "finite-time Lyapunov exponent"),
    }
    about = {"horizon": result.horizon, "sentence": result.sentence()}
    return attributes.dataset(columns, about)
