"""A run in a store as an object: the interface of `Run`, read when it is needed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import measured, path_of
from ..errors import InputError
from ..mechanics.caching import cached_property
from ..mechanics.units import SECOND
from ..problem import Problem
from ..runs import attributes, keyframes
from ..sampling import EvenTimes
from ..scenario import build
from ..store import chunks, root
from .finished_run import Run, Window


if TYPE_CHECKING:
    import xarray as xr

    from ..mechanics.system import System


class StoredRun(Run):
    """A run in a store, finished or not: a `Run` whose tables are read when needed.

    `tippetop.open` returns it.

    Attributes
    ----------
    path : Path
        The store.
    trajectory, events, phases, impacts, summary, problem
        As of a `Run`; there is no `solution`.
    """

    def __init__(self, path: str | Path, own: System | None = None):
        self._own = own  # its system, where that has user-defined events or columns
        self.path = path_of("path", path).absolute()  # the process may go elsewhere
        self.attributes  # noqa: B018 - raises StoreError if there is none

    @cached_property
    def problem(self) -> Problem:
        """Return the problem of the stored scenario, made once.

        Raises InputError if user-defined events or columns of the run were not given to `open`, or
        are others than those it was made with.
        """
        return build.stored(self.attributes, known=self._own)

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Return the root attributes of the store, read once: those of an unfinished run age.

        Raises StoreError.
        """
        return root.attributes(self.path)

    @cached_property
    def _datasets(self) -> dict[str, xr.Dataset]:
        """Return the lazy tables of the store by name, instead of those in memory of a `Run`.

        `_names` lists the tables that a run with these attributes has. They are opened at the first
        access and then kept: rows that are written later do not appear.
        """
        return {name: root.open_group(self.path, name) for name in self._names}

    def replay(
        self,
        start: float | str,
        until: float | str,
        step: float | str,
        *,
        accept_other_version: bool = False,
    ) -> xr.Dataset:
        """Integrate a part of the run again, from the nearest keyframe.

        Parameters
        ----------
        start, until : float
            Times of the first and the last row [s]; each number may be a text with a unit: "10 ms".
        step : float
            Time between two rows [s].
        accept_other_version : bool
            Whether to replay a run of other versions or another processor: bits may differ.

        Returns
        -------
        xarray.Dataset
            As `trajectory`: the rows that the run would have stored at these times, bit by bit.

        Raises
        ------
        InputError
            If the times are not within the run, or too many for the memory.
        StoreError
            If the run is not finished, has no keyframes and a start too far away, or is of other
            versions.

        Examples
        --------
        >>> import tippetop as tt
        >>> run = tt.run("inverting", until=1e5, output="keyframes", out="RUN.zarr")
        >>> run.replay(5e4, 5e4 + 1.0, 1e-3).theta.plot()
        """
        from ..runs import replay

        times = EvenTimes(
            measured("step", step, SECOND),
            measured("until", until, SECOND),
            measured("start", start, SECOND),
        )
        columns = replay.columns(
            self.path, times, accept_other_version=accept_other_version, known=self._own
        )
        return attributes.dataset(columns, self.attributes)

    def _for_figures(self, kind: str, window: Window) -> dict[str, Any]:
        """Return the tables for a figure of this kind, thinned to the rows that it can draw.

        `growth` of a run with keyframes is drawn from all of these.

        `window` is the part that is shown, (start, end) [s]. This overrides `Run._for_figures`, so
        that a long run is never read whole.
        """
        groups = chunks.for_figures(self.path, window)
        if kind == "growth" and root.has_keyframes(self.attributes):
            rows = keyframes.rows(self.path, self.problem)
            groups["trajectory"] = attributes.dataset(rows, self.attributes)
        return groups

    def _page(self, start: float | None, until: float | None) -> str:
        """Return the page of the motion between two times [s], as HTML; rows are read in pieces."""
        from ..views.run_page import page_of_store

        return page_of_store(self.path, self.attributes, start, until)

    @property
    def _seconds(self) -> None:
        """Return None: a store has no times of work."""
        return None

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Raise InputError: a stored run is saved already."""
        raise InputError(f"the run is in the store `{self.path}` already: copy that.")
