"""A finished run as an object: tables, summary, figures, representations."""

from __future__ import annotations

import html
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import flag, in_python, path_of, seconds
from ..errors import InputError, StoreError, warn
from ..mechanics.caching import cached_property
from ..problem import Problem
from ..runs import attributes, results
from ..runs.certificate import broken_promises, certificate, certificate_violations
from ..runs.phases import DIMENSIONS, tables_of
from ..runs.results import Certificate, Record, Summary
from ..runs.run import Solution
from ..runs.summary import lines
from ..scenario.doubts import doubts
from ..store import root
from . import plots


if TYPE_CHECKING:
    import xarray as xr

    from ..views.pages import Page


Window = tuple[float | None, float | None]


SHOWN = 20_000  # rows of a run whose page a notebook keeps with its table: some 3 MB


class Run:
    """A finished run: the result of `tippetop.run`, or of `tippetop.open` for a stored one.

    Attributes
    ----------
    trajectory : xarray.Dataset
        The rows along `time` [s]: angles, quantities, vectors; SI units.
    events : xarray.Dataset
        The event log along `event`: time [s], kind, theta [rad], amplitude [rad], whether it is
        significant.
    phases, impacts : xarray.Dataset
        Only if the contact may change its phase. Of each phase: start and end [s], the ball, and
        the reason why it began. Of each impact: time [s], velocities before and after [m/s],
        impulses [N s], work [J].
    summary : Summary
        The summary of the run, as `tippetop info --json` prints it.
    drift : Record
        Of each invariant, the largest relative deviation from its start.
    warnings : list of str
        Doubts about the scenario, and promises that the run broke: `run` warns of each.
    problem : Problem
        The problem.
    attributes : dict
        The root attributes of its store.
    solution : Solution
        The rows and events as the integrator returned them, in internal units.

    Examples
    --------
    >>> import tippetop as tt
    >>> run = tt.run("inverting", until=8.0)
    >>> run.trajectory.theta.plot()
    >>> run.save("inverting.zarr")
    """

    def __init__(self, solution: Solution):
        self.solution = solution

    @property
    def problem(self) -> Problem:
        """Return the problem."""
        return self.solution.problem

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Return the root attributes of its store: scenario, report, provenance."""
        return attributes.attributes(self.solution.progress)

    @cached_property
    def _datasets(self) -> dict[str, xr.Dataset]:
        """Return the tables of the run by name, made once.

        `StoredRun` overrides this: it opens them from its store. Other methods read tables only
        from here.
        """
        return attributes.datasets(self.solution, self.attributes)

    @property
    def trajectory(self) -> xr.Dataset:
        """Return a copy of the rows along `time` [s], in SI units."""
        return self._datasets["trajectory"].copy()

    @property
    def events(self) -> xr.Dataset:
        """Return the event log along `event`, in SI units."""
        return self._datasets["events"]

    @property
    def phases(self) -> xr.Dataset:
        """Return the phases of the contact along `interval`: start and end [s], ball, reason."""
        return self._table("phases")

    @property
    def impacts(self) -> xr.Dataset:
        """Return the impacts along `impact`, in SI units."""
        return self._table("impacts")

    def _table(self, name: str) -> xr.Dataset:
        """Return a table, not a copy. Raises AttributeError if the run has none of this name."""
        if name not in self._names:
            raise AttributeError(name)  # `__getattr__` explains it
        return self._datasets[name]

    if not TYPE_CHECKING:  # otherwise a type checker would take any name

        def __getattr__(self, name: str) -> Any:
            """Raise AttributeError that names the table of a column."""
            hint = ""
            if name in DIMENSIONS:
                hint = ": the contact of this run does not change its phase"
            elif not name.startswith("_") and name in self._datasets["trajectory"]:
                hint = f": see run.trajectory.{name}"
            raise AttributeError(f"a {type(self).__name__} has no attribute `{name}`{hint}")

    @property
    def _names(self) -> tuple[str, ...]:
        """Return the names of the tables that this run has, from its attributes."""
        return ("trajectory", "events", *tables_of(self.attributes))

    def datasets(self) -> dict[str, xr.Dataset]:
        """Return the tables of the run by name.

        Returns
        -------
        dict of xarray.Dataset
            `trajectory` and `events`; `phases` and `impacts` where the contact may change its
            phase.
        """
        return {name: getattr(self, name) for name in self._names}

    @cached_property
    def summary(self) -> Summary:
        """Return the summary, as `tippetop info --json` prints it."""
        return results.summary_of(self.attributes, lambda: self.problem)

    @property
    def drift(self) -> Record:
        """Return the largest relative deviation of each invariant from its start."""
        return self.summary.drift

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the run as a store: the files that `tippetop run --out` would have written.

        Parameters
        ----------
        path : path-like
            The store; usually its name ends with `.zarr`.
        overwrite : bool
            Whether an existing store of tippetop is replaced.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        StoreError
            If the path exists already, or cannot be written.
        """
        from ..runs import recording

        place = path_of("path", path)
        with in_python():
            recording.save(self.solution, self.attributes, place, overwrite=overwrite)
        return place

    def export(
        self, path: str | Path, *, group: str | None = None, overwrite: bool = False
    ) -> Path:
        """Write the run as netCDF, CSV or Parquet: the file of `tippetop export`.

        Parameters
        ----------
        path : path-like
            The file; its ending names the format: .nc, .csv, .parquet or .pq.
        group : str, optional
            The only table to write: trajectory, events, phases or impacts. By default netCDF has
            all of them as groups, other formats have the trajectory.
        overwrite : bool
            Whether an existing file is replaced.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        InputError
            If the ending or the group is unknown.
        StoreError
            If the path exists already, or cannot be written.
        """
        from ..store.export import ENDINGS, export

        place = path_of("path", path)
        if place.suffix not in ENDINGS:
            endings = ", ".join(ENDINGS)
            raise InputError(f"`path` must end with one of {endings}, but is {str(path)!r:.60}.")
        flag("overwrite", overwrite)
        of = f"`{getattr(self, 'path', 'the run')}`"
        to = ENDINGS[place.suffix]
        with in_python():
            export(self.datasets(), self.attributes, of, to, place, group, overwrite=overwrite)
        return place

    plot = plots.plot

    def _for_figures(self, kind: str, window: Window) -> dict[str, Any]:
        """Return the tables for a figure of this kind, over the part (start, end) [s] of the run.

        Here they are all tables, whole; `StoredRun` overrides this to read the rows it needs only.
        """
        return self._datasets

    def view(self, start: float | str | None = None, until: float | str | None = None) -> Page:
        """Return an HTML page in which the top moves; a notebook shows it, also without a network.

        Parameters
        ----------
        start, until : float or str, optional
            The part that is shown [s], or texts with a unit; by default the whole run, if its rows
            fit into one page.

        Returns
        -------
        Page
            `.save("RUN.html")` writes it.

        Raises
        ------
        InputError
            If the run has no rows, or no orientation.
        StoreError
            If it is not finished, or cannot be read.
        """
        from ..views.pages import Page

        with in_python():
            return Page(self._page(seconds("start", start), seconds("until", until)))

    def _page(self, start: float | None, until: float | None) -> str:
        """Return the page of the motion between two times [s], as HTML."""
        from ..views.run_page import page, refuse
        from ..views.samples import needed

        refuse(self.attributes, "the run")
        trajectory = self.trajectory
        rows = {
            name: trajectory[name].values for name in needed(self.attributes) if name in trajectory
        }
        return page(iter([rows]), self._datasets, self.attributes, start, until)

    def certify(self, window: float | str | None = None) -> Certificate:
        """Repeat the run in this and in a higher precision, and compare the two.

        Parameters
        ----------
        window : float, optional
            Compare these first seconds only, [s] or "1 ms".

        Returns
        -------
        Certificate
            `against` (the wider precision; None if there is no wider one), `window` [s], the
            largest difference of `theta` [rad] if the system has it, whether both end the same way,
            the largest differences of every column (`columns`), of the times of `turnings` [s], and
            of `phases` and `impacts`, in SI units; only their `counts` where the two runs have
            different numbers of them. `thresholds` of the contact have an effect that no wider
            precision shows. It joins the summary.
        """
        result = certificate(self.problem, seconds("window", window))
        self.attributes["certificate"] = root.finite(result)
        self.__dict__.pop("summary", None)  # the cached one has no certificate
        warn(certificate_violations(result), 2)
        return Certificate(self.summary.certificate)

    def __repr__(self) -> str:
        attrs = self.attributes
        return (
            f"<{type(self).__name__} of {attrs['system']}: {attrs['reason']}, "
            f"{attrs['report']['steps']} steps>"
        )

    @property
    def _headline(self) -> str:
        """Return the first line of the text and of the HTML representation."""
        return attributes.headline_of(self.attributes)

    @property
    def warnings(self) -> list[str]:
        """Return doubts about the scenario, and the promises that the run broke, in sentences."""
        try:
            doubtful = doubts(self.problem)
        except InputError:  # of a system, law or event that this process does not know
            doubtful = []
        return [*doubtful, *broken_promises(self.attributes)]

    def _lines(self) -> list[tuple[str, str]]:
        """Return the summary as pairs of a word and a text, then the warnings, for `__str__`."""
        return lines(self.summary, self._seconds) + [("warning", each) for each in self.warnings]

    @property
    def _seconds(self) -> dict[str, float] | None:
        """Return the times that compiling and integrating took [s]; None for a stored run."""
        return self.solution.seconds

    def __str__(self) -> str:
        return "\n".join([self._headline, *(f"{name:16}{text}" for name, text in self._lines())])

    def _repr_html_(self) -> str:
        """Return a table for notebooks with the run in motion, folded, below it."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
            f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
            for name, text in self._lines()
        )
        return f"<b>{html.escape(self._headline)}</b><table>{rows}</table>{self._closed_page()}"

    def _closed_page(self) -> str:
        """Return the page as a folded part of a notebook, or the reason why it cannot be shown."""
        try:
            if (rows := self.trajectory.sizes.get("time", 0)) > SHOWN:
                return f"<p>In motion: .view() makes the page of its {rows} rows.</p>"
            page = self.view()
        # it keeps no rows or no orientation, or is not finished
        except (InputError, StoreError) as error:
            return f"<p>Not shown in motion: {html.escape(str(error))}</p>"
        return f"<details><summary>See it turn</summary>{page._repr_html_()}</details>"
