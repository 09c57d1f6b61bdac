"""Ensembles and sweeps from Python: many tops of one scenario.

A scenario and arrays of numbers, or a plan, go in; tables with a row per top come out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import (
    dotted_keys,
    flag,
    instance,
    measured_values,
    path_of,
    plain,
    positive_integer,
    takes,
)
from ..ensembles import outcomes, top_events
from ..ensembles.ensemble import measure, vary
from ..ensembles.hybrid_tops import problem_of as one_of
from ..errors import InputError, warn
from ..mechanics.contact.body import Top
from ..mechanics.event import Event
from ..mechanics.system import Quantity, System
from ..mechanics.units import ONE, SECOND
from ..problem import Problem
from ..progress import reporting
from ..runs import attributes
from ..runs.certificate import broken_by_tops
from ..scenario.doubts import doubts
from ..sweeps.plan import Plan
from ..sweeps.sweep import sweep as swept
from .extensions import given_records
from .scenarios import problem_of


if TYPE_CHECKING:
    import xarray as xr

OF_ROWS = ("output", "output_step", "output_times", "keyframe_steps")
"""Arguments of `run` that determine which rows are kept."""


@takes(problem_of)
def ensemble(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    variations: Mapping[str, Any],
    friction: Any = None,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | bool = True,
    orientation: bool = False,
    lyapunov: bool = False,
    event_table: bool = False,
    **scenario: Any,
) -> Any:
    """Integrate many tops that differ in numbers only; return one row of results for each.

    Parameters
    ----------
    source, friction
        Common to all tops, as for `run`.
    variations : mapping of str to array, (n,) each
        The varied numbers, in SI units: `dict(omega3=..., mu=...)`; or texts with units,
        `["1000 rpm", "1200 rpm"]`. Write a name that occurs in several tables with its table,
        `"friction.mu"`; `"until"` varies the end of the run. All other numbers are those of the
        source: moments of inertia, default or not, do not follow a length that varies.
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
        that of `tippetop.derivatives.lyapunov` at the end. Each takes several times its run. NaN of
        a top that is invalid, or ends at its start.
    event_table : bool
        Whether to return the events of the tops too, those of the kinds that `events` lists.
    columns : Quantity, or iterable of str and Quantity, optional
        User-defined columns: the value of each at the end is a column NAME_end. With
        `event_table` also names: the columns of that table, if it has user-defined events.
    {names}
        Common to all tops, as for `run`; ensembles have no further options for rows.

    Returns
    -------
    xarray.Dataset, or with `event_table` two of them
        Along `top`, (n,): status, class, t_end [s], times of passages [s], theta_min, theta_max
        [rad], normal_force_min, normal_force_max [N], drift of the invariants. The varied numbers
        are coordinates. Invalid tops have the status `invalid`; the fault of the first of them is
        in the attributes. The table of events has the columns of `run.events`, and the number of
        the `top`, along `event`.

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
    columns = given_records("columns", scenario.get("columns"), Quantity)
    if not event_table and any(isinstance(column, str) for column in columns):
        raise InputError("`columns` must be Quantity records in an ensemble: it keeps no rows.")
    base = problem_of(source, friction, **scenario)
    instance("variations", variations, Mapping, "a mapping of names to arrays")
    keys = dotted_keys(variations, base.rules)
    dotted = {}
    for key, (name, values) in zip(keys, variations.items(), strict=True):
        rule = base.rules.get(key)
        unit = rule.unit if rule is not None else SECOND if name == "until" else ONE
        dotted[key] = measured_values(name, values, unit)
    threads = None if threads is None else positive_integer("threads", threads)
    flag("orientation", orientation)
    flag("lyapunov", lyapunov)
    flag("event_table", event_table)
    tops = vary(base, dotted, orientation=orientation)
    if tops.valid[:1].any():  # doubts on the first top, for all
        warn(doubts(one_of(tops, 0)), 3)
    with reporting(progress, "tops") as report:
        measured = measure(
            tops, threads=threads, progress=report, lyapunov=lyapunov, events=event_table
        )
    found = outcomes.dataset(measured)
    warn(broken_by_tops(found, base.tolerance), 3)
    if not event_table:
        return found
    return found, attributes.dataset(top_events.event_table(measured), found.attrs)


@takes(swept)
def sweep(
    plan: str | Path | Mapping[str, Any] | Plan,
    out: str | Path,
    *,
    events: Iterable[str | Event] | str | Event | None = None,
    columns: Iterable[str | Quantity] | str | Quantity | None = None,
    **options: Any,
) -> xr.Dataset:
    """Run every top of a plan into the store `out`, or continue it, and open it.

    It can be called in any thread.

    Parameters
    ----------
    plan
        A TOML file, or the same tables as a mapping; arrays may be the `values` of an axis.
    out
        The store to make or to continue.
    events, columns
        As for `ensemble`. To continue the sweep, pass the same ones. Other processes compute with
        named functions of modules that they can import, not with those of a notebook or a script.
    workers
        Processes on this machine that compute. One: this process itself; by default as many as
        usable cores, or threads of this process where little is to be done.
    scheduler
        Address of a dask scheduler whose workers compute instead.
    progress
        Called as progress(done, of), which count tops; True draws a bar in a terminal or a
        notebook.
    stop
        Set it in a signal handler or another thread: the sweep then stops after a chunk, or
        before the first. An exception such as KeyboardInterrupt ends it at once and costs the
        chunks that are being computed. Either way the same call without `overwrite`
        continues it.
    overwrite
        Replace a store that exists, finished or not.

    Returns
    -------
    xarray.Dataset
        The table of the sweep, dimension `top`, SI units, read when needed. `open` reads it again,
        and the events of a plan that keeps them.

    Raises
    ------
    InputError
        The plan or an argument is wrong; every fault is listed.
    StoreError
        The store is that of another plan, or cannot be read or written.
    Unfinished
        Some chunks failed.
    Interrupted
        `stop` was set.

    Examples
    --------
    >>> import numpy as np, tippetop as tt
    >>> spins = dict(of="initial.omega3", values=np.linspace(100, 200, 64))
    >>> tt.sweep(dict(scenario="inverting", axis=[spins]), "S.zarr")
    """
    place = path_of("out", out)

    def base(tables: dict[str, Any]) -> Problem:
        """Return the problem of these tables, with the events and columns of the user.

        The plan makes its base by it.
        """
        return problem_of(tables, events=events, columns=columns)

    if isinstance(plan, Mapping):
        plan = Plan.from_tables(plain(plan), made=base)
    elif not isinstance(plan, Plan):
        plan = Plan.from_toml(plan, base)
    return swept(plan, place, **options)
