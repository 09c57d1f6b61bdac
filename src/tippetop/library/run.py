"""A finished run as an object: tables, summary, figures, representations."""

import html
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import in_python, path_of, seconds
from ..errors import InputError, StoreError
from ..mechanics.caching import cached_property
from ..mechanics.variables import LONG_NAMES, Variables
from ..problem import Problem
from ..runs import attributes, results, sensitivities
from ..runs.certificate import certificate
from ..runs.phases import tables_of
from ..runs.results import Record, Summary
from ..runs.run import Solution
from ..runs.summary import lines
from ..store import root


if TYPE_CHECKING:
    import xarray as xr

    from ..mechanics.system import System
    from ..views.pages import Page
    from .plots import Plots


Window = tuple[float | None, float | None]


SHOWN = 20_000  # rows of a run whose page a notebook keeps with its table: some 3 MB


class Run:
    """A finished run. `tippetop.run` makes one, `tippetop.open` opens one that was stored.

    Attributes
    ----------
    trajectory : xarray.Dataset
        The rows along `time` [s]: angles, quantities, vectors; SI units.
    events : xarray.Dataset
        The event log along `event`: time [s], kind, theta [rad], amplitude [rad], whether it is
        significant.
    phases, impacts : xarray.Dataset
        Of a run whose contact may change its phase: each phase's start and end [s], the ball, why
        it began; each impact's time [s], velocities before and after [m/s], impulses [N s], work
        [J].
    sensitivities, event_sensitivities : xarray.Dataset
        Of a run whose scenario has `run.sensitivities`: the derivative of every column along `time`
        and `parameter`, of the time of every event, and of theta there, along `event` and
        `parameter`; SI units per SI unit.
    summary : Summary
        The summary of the run, as `tippetop info --json` prints it.
    drift : Record
        Of each invariant, the largest relative deviation from its start.
    final : xarray.Dataset
        The integrated variables at the end, SI units.
    problem : Problem
        What was integrated.
    attributes : dict
        The root attributes of its store.
    solution : Solution
        The rows and events as the integrator gave them, in internal units.

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
        """What was integrated."""
        return self.solution.problem

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """The root attributes of its store: scenario, what was measured, provenance."""
        return root.finite(attributes.attributes(self.solution.progress))

    @cached_property
    def _datasets(self) -> "dict[str, xr.Dataset]":
        return {
            name: dataset.assign_attrs(self.attributes)
            for name, dataset in attributes.datasets(self.solution).items()
        }

    @property
    def trajectory(self) -> "xr.Dataset":
        """The rows along `time` [s], in SI units: what is set in this Dataset leaves the run as it
        is.
        """
        return self._datasets["trajectory"].copy()

    @property
    def events(self) -> "xr.Dataset":
        """The event log along `event`, in SI units."""
        return self._datasets["events"]

    @property
    def phases(self) -> "xr.Dataset":
        """The phases of the contact along `interval`: start and end [s], phase, ball, reason."""
        return self._of_contact("phases")

    @property
    def impacts(self) -> "xr.Dataset":
        """The impacts along `impact`, in SI units."""
        return self._of_contact("impacts")

    @cached_property
    def _derived(self) -> "dict[str, xr.Dataset]":
        derived = self.solution.sensitivities
        return {
            name: attributes.dataset(columns, self.attributes) for name, columns in derived.items()
        }

    @property
    def sensitivities(self) -> "xr.Dataset":
        """The derivatives of the columns along `time` and `parameter`, SI per SI."""
        return self._of_derivatives("sensitivities")

    @property
    def event_sensitivities(self) -> "xr.Dataset":
        """The derivatives of the times of events, and of theta there, along `event` and
        `parameter`, SI per SI.
        """
        return self._of_derivatives("event_sensitivities")

    def _of_derivatives(self, name: str) -> "xr.Dataset":
        """A table that only a run has whose scenario asks for it. Raises AttributeError."""
        if not self._derivatives:
            raise AttributeError(
                f"there is no table `{name}`: the scenario has no `run.sensitivities`"
            )
        return self._derived[name]

    def _of_contact(self, name: str) -> "xr.Dataset":
        """A table that only a run has whose contact may change its phase. Raises AttributeError."""
        if name not in tables_of(self.attributes):
            raise AttributeError(
                f"there is no table `{name}`: the contact of this run does not change its phase"
            )
        return self._datasets[name]

    def datasets(self) -> "dict[str, xr.Dataset]":
        """Return the tables of the run by name.

        Returns
        -------
        dict of xarray.Dataset
            `trajectory` and `events`; `phases` and `impacts` where the contact may change its
            phase.
        """
        names = ("trajectory", "events", *tables_of(self.attributes))
        return {name: getattr(self, name) for name in (*names, *self._derivatives)}

    @property
    def _derivatives(self) -> tuple[str, ...]:
        """The names of the tables of derivatives."""
        attrs = self.attributes
        return (
            sensitivities.NAMES
            if attrs["run"].get("sensitivities") and "replay" not in attrs
            else ()
        )

    @cached_property
    def summary(self) -> Summary:
        """What the run amounts to, as `tippetop info --json` prints it."""
        return results.summary_of(self.attributes, self._problem())

    def _problem(self) -> Problem | None:
        """The problem, where it is at hand without being built again."""
        return self.solution.problem

    @property
    def drift(self) -> Record:
        """Of each invariant, the largest relative deviation from its start."""
        return Record(self.attributes["report"]["drift"], "drift")

    @cached_property
    def final(self) -> "xr.Dataset":
        """The integrated variables at the end, in SI units; they are without dimension in the sense
        of xarray.
        """
        import xarray as xr

        system = self._system()
        known = Variables(system.forms[self.attributes["form"]]) if system else None
        return xr.Dataset(
            {
                name: (
                    (),
                    value,
                    _meaning(name, system, known)
                    if system and known and name in known.units
                    else {},
                )
                for name, value in self.attributes["final_state"].items()
            },
            {"time": ((), self.attributes["report"]["t_end"], {"units": "s", "long_name": "time"})},
        )

    def _system(self) -> "System | None":
        return self.problem.system

    def to_datatree(self) -> "xr.DataTree":
        """The tables as the groups of one tree.

        Returns
        -------
        xarray.DataTree
            With the children `trajectory` and `events`, `phases` and `impacts` where there are any,
            and the root attributes of the store.
        """
        import xarray as xr

        tables = self.datasets()
        return xr.DataTree.from_dict(
            {
                "/": xr.Dataset(attrs=self.attributes),
                **{name: t.drop_attrs(deep=False) for name, t in tables.items()},
            }
        )

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Writes the run as a store: the files that `tippetop run --out` would have written.

        Parameters
        ----------
        path : path-like
            Where the store shall be; usually it ends with `.zarr`.
        overwrite : bool
            Whether a store of tippetop that is there is replaced.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        StoreError
            If something is there already, or cannot be written.
        """
        from ..runs import saving

        place = path_of("path", path)
        with in_python():
            saving.save(self.solution, self.attributes, place, overwrite=overwrite)
        return place

    @property
    def plot(self) -> "Plots":
        """The figures of the run: `run.plot("theta")` is a Figure, `run.plot.theta(ax=ax)` draws
        into Axes.

        `help(run.plot)` has its options, `dir(run.plot)` the kinds of figures.
        """
        from .plots import Plots

        return Plots(self)

    def _for_figures(self, kind: str, window: Window = (None, None)) -> dict[str, Any]:
        """Return the tables for a kind of figure; of a store the first row and those in
        the window.
        """
        return self._datasets

    def view(self, start: float | str | None = None, until: float | str | None = None) -> "Page":
        """The run in motion: an HTML file that needs no network, which a notebook shows.

        Parameters
        ----------
        start, until : float or str, optional
            The part that is shown [s], or texts with a unit; by default all of it, as far as one
            file can hold it.

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
        from ..views.run_page import page, refuse
        from ..views.samples import needed

        refuse(self.attributes, "the run")
        trajectory = self.trajectory
        rows = {
            name: trajectory[name].values for name in needed(self.attributes) if name in trajectory
        }
        return page(iter([rows]), self._datasets, self.attributes, start, until)

    def certify(self, window: float | str | None = None) -> Record:
        """Repeats the run in this and in wider numbers, and compares the two.

        Parameters
        ----------
        window : float, optional
            Compare the first so many seconds only; "1 ms" is fine. Of a stored run that is not
            finished at most what is stored of it is compared.

        Returns
        -------
        Record
            `against` (the wider precision), `window` [s], the largest difference of `theta` [rad]
            and of its end, whether both end the same way, of the times of shared turnings [s], of
            every column (`columns`), and of shared `phases` and `impacts`, in SI units. It joins
            the summary.
        """
        span = seconds("window", window)
        if span is not None and span <= 0:
            raise InputError(f"`window` must be greater than 0, but is {window!r:.60}.")
        stored = self._so_far()
        if stored is not None:
            span = stored if span is None else min(span, stored)
        result = root.finite(certificate(self.problem, span))
        self.attributes["certificate"] = result
        self.__dict__.pop("summary", None)
        return Record(result, "certificate")

    def _so_far(self) -> float | None:
        """How far a run that is not finished has come [s]; None where it has come to its end.

        Raises InputError where it has not begun.
        """
        return None

    def __repr__(self) -> str:
        attrs = self.attributes
        return (
            f"<{type(self).__name__} of {attrs['system']}: {attrs['reason']}, "
            f"{attrs['report']['steps']} steps>"
        )

    @property
    def _headline(self) -> str:
        return attributes.headline_of(self.attributes)

    def _lines(self) -> list[tuple[str, str]]:
        return lines(self.summary, self.solution.seconds)

    def __str__(self) -> str:
        return "\n".join([self._headline, *(f"{name:16}{text}" for name, text in self._lines())])

    def _repr_html_(self) -> str:
        """The run as a table and, to be opened below it, in motion: for notebooks."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
            f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
            for name, text in self._lines()
        )
        return f"<b>{html.escape(self._headline)}</b><table>{rows}</table>{self._closed_page()}"

    def _closed_page(self) -> str:
        try:
            if (rows := self.trajectory.sizes.get("time", 0)) > SHOWN:
                return f"<p>In motion: .view() makes the page of its {rows} rows.</p>"
            page = self.view()
        except (
            InputError,
            StoreError,
        ) as error:  # it keeps no rows or no orientation, or is not finished
            return f"<p>Not shown in motion: {html.escape(str(error))}</p>"
        return f"<details><summary>See it turn</summary>{page._repr_html_()}</details>"


def _meaning(name: str, system: "System", variables: Variables) -> dict[str, str]:
    """Unit and long name of an integrated variable."""
    words = (
        LONG_NAMES
        | {integral.name: integral.long_name for integral in variables.integrals}
        | system.long_names
    )
    for vector, parts in (
        system.vectors.items() if variables.form is system.forms.get("vector") else ()
    ):
        words |= {
            part: f"{words[vector]}, {axis} component"
            for part, axis in zip(parts, "xyz", strict=True)
        }
    return {"units": variables.units[name].symbol, "long_name": words.get(name, "")}
