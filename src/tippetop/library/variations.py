"""Ensembles and sweeps from Python: many tops of one scenario."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import dotted_keys, flag, instance, measured_values, takes, whole
from ..ensembles import ensemble as ensembles
from ..errors import InputError
from ..mechanics.contact.body import Top
from ..mechanics.system import System
from ..mechanics.units import ONE, SECOND
from ..problem import Problem
from ..progress import Report
from .scenarios import problem_of


if TYPE_CHECKING:
    import xarray as xr


OF_ROWS = ("columns", "output", "output_step", "output_times", "keyframe_steps")
"""Arguments of `run` that say which rows are kept."""


@takes(problem_of)
def ensemble(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    variations: Mapping[str, Any],
    friction: Any = None,
    *,
    threads: int | None = None,
    progress: Report | bool = True,
    orientation: bool = False,
    lyapunov: bool = False,
    **scenario: Any,
) -> "xr.Dataset":
    """Integrate many tops that differ in numbers only; return one row of results for each.

    Parameters
    ----------
    source, friction
        Common to all tops, as for `run`.
    variations : mapping of str to array, (n,) each
        The varied numbers, in SI units: `dict(omega3=..., mu=...)`; or texts with units,
        `["1000 rpm", "1200 rpm"]`. Write a name that occurs in several tables with its table,
        `"friction.mu"`; `"until"` varies the end of the run.
    threads : int, optional
        Number of threads; by default one per usable core.
    progress : callable or bool
        `progress(done, of)` counts tops; True draws a bar in a terminal or a notebook.
    orientation : bool
        Whether to add the orientation of each body at the end, as columns orientation_w_end,
        orientation_x_end, orientation_y_end, orientation_z_end (the unit quaternion that turns body
        axes into space axes) and psi_end [rad]. It changes no other column.
    lyapunov : bool
        Whether to add the finite-time Lyapunov exponent of each run, a column lyapunov [1/s],
        that of `tippetop.derivatives.lyapunov` at the end. Each takes several times its run.
    {names}
        Common to all tops, as for `run`; ensembles have no options for rows.

    Returns
    -------
    xarray.Dataset
        Along `top`, (n,): status, class, t_end [s], times of passages [s], theta_min, theta_max
        [rad], normal_force_min, normal_force_max [N], drift of the invariants. The varied numbers
        are coordinates. Invalid tops have the status `invalid`; the fault of the first of them is
        in the attributes.

    Raises
    ------
    InputError
        If the scenario, or the name or shape of a varied number, is wrong.

    Examples
    --------
    >>> import numpy as np, tippetop as tt
    >>> tt.ensemble("inverting", {"omega3": np.linspace(100, 200, 64)}, until=8.0)
    """
    if rows := [name for name in OF_ROWS if scenario.get(name) is not None]:
        raise InputError(
            [f"`{name}` must not be given in an ensemble: it keeps no rows." for name in rows]
        )
    base = problem_of(source, friction, **scenario)
    instance("variations", variations, Mapping, "a mapping of names to arrays")
    keys = dotted_keys(variations, base.rules)
    dotted = {}
    for key, (name, values) in zip(keys, variations.items(), strict=True):
        rule = base.rules.get(key)
        unit = rule.unit if rule is not None else SECOND if name == "until" else ONE
        dotted[key] = measured_values(name, values, unit)
    threads = None if threads is None else whole("threads", threads)
    flag("orientation", orientation)
    flag("lyapunov", lyapunov)
    return ensembles.of_problem(
        base,
        dotted,
        threads=threads,
        progress=progress,
        orientation=orientation,
        lyapunov=lyapunov,
    )
