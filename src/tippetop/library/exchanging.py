"""The calls that hold another program's motion against ours."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import path_of
from ..errors import InputError
from ..exchange.motion import Convention
from ..exchange.verdict import Verdict, judged
from .sources import problem_behind


if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Comparison(Verdict):
    """Motions of another program beside the exact one. `tippetop.compare` makes it; it prints its verdict.

    Attributes
    ----------
    motions : tuple of Compared
        Of each file: `t`, `curves` of differences by name, and `numbers`.
    orders : list of dict
        Orders of convergence between files of different steps.
    title : str
        What the reference is.
    """

    def plot(self, path: str | Path | None = None, *, overwrite: bool = False) -> "Figure":
        """theta of both, the differences, and what must be conserved, as a figure; saved where a path is given, over a
        file that is there if it may be overwritten."""
        from ..figures import catalogue

        figure = catalogue.comparison(self.motions, self.title)
        if path is not None:
            catalogue.check_format(path_of("path", path))
            catalogue.write(figure, path_of("path", path), overwrite=overwrite)
        return figure


def compare(
    others: str | Path | Sequence[str | Path], reference: Any, *, quaternion: str | None = None, up: str = "z"
) -> Comparison:
    """How far another program's motion is from the exact one, and from when on.

    Parameters
    ----------
    others : path or list of paths
        CSV or Parquet files whose headers name columns and units: `t [s], theta [deg]`, `axis_x, axis_y, axis_z`,
        `q_w, q_x, q_y, q_z` (body to space), `x [m]`, `vx [m/s]`, `omega_x [rad/s]` (space), `omega_body_x [rad/s]`. A
        name such as `dt=1e-3.csv` says the time step.
    reference : str, path, Run, Problem or mapping
        A scenario, or a run: the exact motion is computed at the other's own times.
    quaternion : str, optional
        The order of columns q_0 ... q_3: "wxyz" or "xyzw".
    up : str
        The letter of the vertical in the other's frames, and of the body's axis of symmetry: "z" or "y".

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If a file, a convention or the scenario is wrong.

    Examples
    --------
    >>> import tippetop as tt
    >>> print(tt.compare("mine.csv", "inverting"))
    """
    files = [others] if isinstance(others, str | Path) else list(others)
    if not files:
        raise InputError(["`others` must name at least one file, but is empty."])
    problem = _reference(reference)
    convention = Convention(quaternion, up)
    return Comparison(*judged(problem, [path_of("others", file) for file in files], convention))


def _reference(source: Any) -> Any:
    """The problem of a scenario, a run, or the store of one. Raises InputError."""
    if isinstance(source, str | Path) and Path(source).is_dir():
        from .stored_run import StoredRun

        return StoredRun(source).problem
    problem = problem_behind(source)
    if problem is None:
        raise InputError([f"`reference` must be a scenario or a run, but is {source!r:.60}."])
    return problem
