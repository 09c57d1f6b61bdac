"""Make, open and resume runs.

Bodies, scenarios or paths go in; a `Run`, a `StoredRun` or a table comes out.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..arguments import flag, in_python, instance, path_of, seconds, takes
from ..errors import InputError, Interrupted, warn
from ..mechanics.contact.body import Top
from ..mechanics.event import Event
from ..mechanics.friction import FrictionLaw
from ..mechanics.system import Quantity, System
from ..problem import Problem
from ..problem.options import documentation
from ..runs.certificate import broken_promises
from ..runs.cost import bar_of_run
from ..runs.run import solve
from ..scenario.doubts import doubts
from ..store import root
from .extensions import of_stored
from .finished_run import Run
from .scenarios import problem_of
from .stored_run import StoredRun


@takes(problem_of, documentation)
def run(
    source: Top | str | Path | System | Mapping[str, Any] | Problem,
    friction: FrictionLaw | tuple | Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    overwrite: bool = False,
    progress: bool = True,
    stop: threading.Event | None = None,
    **scenario: Any,
) -> Run:
    """Integrate one top.

    Parameters
    ----------
    source : body, str, path, System, mapping or Problem
        A body; the name of a preset; a TOML file; a System, with `parameters`; or the tables of
        a scenario. A body with a friction law glides. Without a law, a HeavyTop has a fixed tip
        and a Cylinder rolls; a TippeTop requires a law, unless `system="rolling-tippe-top"`.
    friction : law or mapping, optional
        A friction law such as `Viscous(mu=0.3)`, or numbers that replace those of the source:
        `dict(mu=0.2)`.
    start : mapping or path, optional
        Initial values that replace those of the source: theta, phi, psi [rad], theta_dot,
        phi_dot, omega3 [rad/s], nu_x, nu_y [m/s], x, y [m]; by default zero, so that the contact
        point starts at rest. psi_dot [rad/s] can replace omega3, and centre_at_rest (a bool) nu_x
        and nu_y: the contact then slides. psi is the angle of the body about its axis; it affects
        only the columns psi and orientation. A cylinder has
        theta, theta_dot, x and, if it glides, nu_x. With the store of a finished run of the same
        body, the new run starts at t = 0 from the exact final state of that run.
    parameters : mapping, optional
        Numbers of the body in SI units that replace those of the source.
    system : str or System, optional
        A system that replaces that of the source.
    form : str, optional
        Form of the equations: vector, euler, reduced, ... By default "auto", the cheapest form
        that is regular everywhere and keeps every column exact.
    contact : mapping, optional
        Let the body fly, land and bounce: `dict(restitution="energetic", e_n=0.5)`. restitution
        is energetic, poisson or newton. Defaults, also with an empty mapping: energetic and 0.
    stem : mapping, optional
        Stem of a tippe top, `dict(r=0.004, h=0.022)`: radius of its ball [m], and distance of
        its centre from that of the sphere along 3hat [m].
    air : mapping, optional
        Air that brakes the rotation, `dict(c1=1e-9, c2=2e-11)`: its torque about the centre of
        mass is -(c1 + c2 |omega|) omega [N m].
    plane : mapping, optional
        A plane that is not level, `dict(tilt="0.3 deg", azimuth=0)`; that vibrates across itself,
        `dict(amplitude="0.2 mm", frequency="30 Hz", phase=0)`; or that turns about x, y,
        `dict(omega="30 rpm", x=0, y=0)`. All is seen from the plane.
    {options}
    out : path, optional
        A store that is written during the run, for runs that exceed memory. The result is then a
        StoredRun.
    overwrite : bool
        Replace an existing store at `out`.
    progress : bool
        Show a progress bar of a longer run, in a terminal or a notebook.
    stop : threading.Event, optional
        With `out`: set it in a signal handler or another thread to stop the run; `resume`
        continues it.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        With one message for each invalid argument.
    StoreError
        If `out` cannot be written.
    Interrupted
        If `stop` was set.

    Examples
    --------
    >>> import tippetop as tt
    >>> top = tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-6, I3=3.2e-6, g=9.82)
    >>> tt.run(top, tt.friction.Viscous(mu=0.3), start=dict(theta=0.1, omega3=155.0), until=8.0)
    >>> tt.run("inverting", friction=dict(mu=0.2), until=8.0)
    """
    flag("overwrite", overwrite)
    problem = problem_of(source, friction, **scenario)
    instance("stop", stop, threading.Event | None, "a threading.Event")
    place = None if out is None else path_of("out", out)
    if place is None and problem.output == "keyframes":
        raise InputError('`out` must be given where `output` is "keyframes": a store keeps them.')
    warn(doubts(problem), 3)  # from here over the wrapper of `takes` to the user's call
    made: Run
    with _bar(progress) as follow:
        if place is None:
            made = Run(solution := solve(problem, follow))
            # what `broken_promises` reads: the whole report would take a tenth of a short run
            report = {"drift": solution.progress.drift, "t_end": solution.progress.t_end}
            known: Any = {"report": report, "tolerance": problem.tolerance}
        else:
            from ..runs.recording import record

            with in_python(), _resumable(place):
                record(problem, place, overwrite=overwrite, progress=follow, stop=stop)
            made = StoredRun(place, problem.system)
            known = made.attributes
    warn(broken_promises(known), 3)
    return made


def _bar(progress: bool) -> Any:
    """Return a context that provides a progress callback, or None if `progress` is False.

    Raises InputError if `progress` is no flag.
    """
    flag("progress", progress)
    return bar_of_run() if progress else contextlib.nullcontext()


@contextlib.contextmanager
def _resumable(place: Path) -> Iterator[None]:
    """Let an Interrupted of the block contain how the run stored at `place` is continued.

    There is no store if the run was stopped before that began.
    """
    try:
        yield
    except Interrupted:
        kept = (
            f"tippetop.resume({str(place)!r}) continues it."
            if place.exists()
            else "nothing was stored."
        )
        raise Interrupted(f"the run was stopped: {kept}") from None


def open(
    path: str | Path,
    *,
    gridded: bool = False,
    group: str | None = None,
    events: Iterable[Event] | Event | None = None,
    columns: Iterable[Quantity] | Quantity | None = None,
) -> Any:
    """Open a store of any kind lazily.

    Parameters
    ----------
    path : path-like
        The store of a run, a sweep, a minimal surface or a potential.
    gridded : bool
        Make the axes of a sweep the dimensions of its table, which is read into memory.
    group : str, optional
        One table of the store, such as "events" of a sweep that keeps them, as a Dataset.
    events, columns : iterable of Event and of Quantity, optional
        User-defined records of the run. They are required for `problem`, `certify` and
        `replay`, but not for stored rows.

    Returns
    -------
    StoredRun or xarray.Dataset
        A run as a StoredRun; a sweep as a Dataset with a row per top (or per event), a
        surface or potential as a Dataset over its axes. Attributes of a Dataset are those of the
        store; tables among them are JSON texts.

    Raises
    ------
    StoreError
        If `path` is not a store of tippetop, is damaged, or has no such table.
    """
    path = path_of("path", path)
    flag("gridded", gridded)
    attrs = root.attributes(path)
    if group is not None:
        return root.open_group(path, group)
    content = attrs.get("content")
    own = of_stored(attrs, events, columns)
    if content is None:
        return StoredRun(path, own)
    if content == "sweep":
        from ..sweeps import sweep_summary

        table = sweep_summary.open_sweep(path)
        return sweep_summary.gridded(table) if gridded else table
    return root.open_group(path, content)


def resume(
    path: str | Path,
    *,
    until: float | str | None = None,
    progress: bool = True,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    events: Iterable[Event] | Event | None = None,
    columns: Iterable[Quantity] | Quantity | None = None,
) -> StoredRun:
    """Continue an interrupted run of a store to its end, or a finished one to a later end.

    The result equals an uninterrupted run bit by bit.

    Parameters
    ----------
    path : path-like
        The store.
    until : float, optional
        A later end of the run [s].
    progress, stop
        As for `run`.
    accept_other_version : bool
        Continue a run of other versions or another processor: bits may differ, and the store
        names both.
    events, columns : iterable of Event and of Quantity, optional
        User-defined records of the run: a store contains their names, not their formulas.

    Returns
    -------
    StoredRun

    Raises
    ------
    InputError
        If the run already reaches `until`, user-defined events or columns are missing, or the
        scenario in the store is not one of this release.
    StoreError
        If the run is finished and `until` is missing, if it ended before its own `until`, if it is
        of other versions or another processor, or if the store is damaged, cannot be written, or is
        being written by another process.
    Interrupted
        If `stop` was set.
    """
    from ..runs.resuming import resume as resumed

    end = seconds("until", until)
    place = path_of("path", path)
    own = of_stored(root.root_of(place), events, columns)
    instance("stop", stop, threading.Event | None, "a threading.Event")
    with _bar(progress) as follow, in_python(), _resumable(place):
        resumed(
            place,
            follow,
            until=end,
            stop=stop,
            accept_other_version=accept_other_version,
            known=own,
        )
    stored = StoredRun(place, own)
    warn(broken_promises(stored.attributes), 2)
    return stored
