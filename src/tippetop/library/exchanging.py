"""The calls that hold another program's motion against ours.

`tippetop.compare` and `tippetop.fit`: files and scenarios go in, results with plots come out.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import (
    finite,
    flag,
    instance,
    names_of,
    path_of,
    positive_integer,
    takes,
)
from ..errors import InputError, refuse_without
from ..exchange import fitting, law_choice
from ..exchange.comparison import Verdict
from ..exchange.fit_result import Fit
from ..exchange.motion import convention_of
from ..exchange.motion_table import read
from ..exchange.observation import observed
from ..exchange.scales import FAR
from ..problem import Problem
from ..progress import reporting
from ..runs.starting import load_any
from .finished_run import Run
from .plots import saved
from .sources import problem_behind


if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Comparison(Verdict):
    """Motions of another program, compared with the exact one.

    `tippetop.compare` makes it; it prints its verdict.

    Attributes
    ----------
    motions : tuple of Compared
        Of each file: `t`, `curves` of differences by name, and `numbers`.
    orders : list of dict
        Orders of convergence between files of different steps.
    title : str
        The name of the reference.
    """

    def plot(self, path: str | Path | None = None, *, overwrite: bool = False) -> Figure:
        """Draw the differences as a figure, and save the figure where a path is given.

        With `overwrite` an existing file is replaced.
        """
        refuse_without("matplotlib")
        from ..figures.motions import comparison

        return saved(comparison(self.motions, self.title), path, overwrite)


@takes(convention_of)
def compare(others: str | Path | Sequence[str | Path], reference: Any, **frames: Any) -> Comparison:
    """Compare another program's motion with the exact one.

    Parameters
    ----------
    others : path or list of paths
        CSV or Parquet files whose headers name columns and units, such as `t [s], theta [deg]`:
        `tippetop help measurements` lists them. Every column is compared; one that the reference
        lacks is refused. A name such as `dt=1e-3.csv` gives the time step.
    reference : str, path, Run, Problem or mapping
        A scenario, or a run: the exact motion is computed at the other's own times.
    quaternion : str, optional
        The order of columns q_0 ... q_3: "wxyz" or "xyzw".
    up : str
        The letter of the vertical in the other's frames, and of the body's axis of symmetry: "z" or
        "y". With "y" their z, x, y are our x, y, z.
    track : str, optional
        The object whose columns are read, where a table has several: its name in the line before
        the header.
    chip : three floats, or text with commas, optional
        Where the accelerometer is in the body, from the centre of mass, body axes [m].

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
    files: Any = [others] if isinstance(others, str | os.PathLike) else others
    instance("others", files, list | tuple, "a path or a list of paths")
    if not files:
        raise InputError("`others` must name at least one file, but is empty.")
    problem = _reference("reference", reference)
    paths = [path_of("others", file) for file in files]
    return Comparison(problem, paths, convention_of(**frames))


@dataclass(frozen=True, eq=False, repr=False)
class Fitted(Fit):
    """Numbers of a scenario that fit a measured motion. `tippetop.fit` makes it; it prints itself.

    Attributes
    ----------
    estimates : dict of Estimate
        By dotted name: `value`, `sigma`, `low` and `high` (95 %), SI.
    correlations : ndarray
        (free, free), in the order of `estimates`.
    converged : bool
        Whether enough independent searches ended in the same best minimum.
    trustworthy : bool
        Whether, besides, the residuals are noise, and the data decide every number.
    reason : str
        The warnings of the report, in sentences.
    problem : Problem
        The scenario with the fitted numbers: `tippetop.run` takes it.
    influences : dict
        By what the scenario lacks: how far each number would move [SI], of whose squares
        `systematic` of an estimate is the root of the sum.
    laws : dict of Fitted
        The fit under each law, where several were given.
    residuals : dict of ndarray
        Measurements less predictions, by kind of measurement, (rows, parts), SI; of an
        axis two parts, across it.
    """

    laws: dict[str, Fitted] = field(default_factory=dict)

    def plot(self, path: str | Path | None = None, *, overwrite: bool = False) -> Figure:
        """Draw data, motion and residuals as a figure, and save it where a path is given."""
        refuse_without("matplotlib")
        from ..figures.fit import fit as draw_fit

        figure = draw_fit(
            self.observation.t,
            self.observation.dots(),
            self.observation.curves(self.values),
            self.residuals,
            str(self).splitlines(),
        )
        return saved(figure, path, overwrite)

    def __repr__(self) -> str:
        return (
            f"<Fitted {', '.join(self.estimates)}: "
            f"{'trustworthy' if self.trustworthy else 'to be read with care'}>"
        )


@takes(observed)
def fit(
    data: str | Path,
    scenario: Any,
    free: str | Sequence[str],
    *,
    loss: str = "linear",
    starts: int = fitting.STARTS,
    within: float = FAR,
    systematic: bool = True,
    laws: Sequence[str | Mapping[str, Any]] | str = (),
    progress: Callable[[int, int], None] | bool = True,
    **film: Any,
) -> Fitted:
    """Fit numbers of a scenario to a measured motion, by least squares.

    Parameters
    ----------
    data : path
        CSV or Parquet whose header names columns and units, as for `compare`; gaps are allowed.
    scenario : str, path, Run, Problem or mapping
        Its numbers are fixed or, if they are free, the start of the search.
    free : str or list of str
        Dotted names, such as "friction.mu", "parameters.I1", "initial.omega3"; "time.offset" and
        "time.scale" of the table's clock: the motion's time is scale t + offset, so that a clock
        that was started before the motion has a negative offset.
    loss : str
        "linear", or "soft_l1", "huber", "cauchy", which outliers hardly move.
    starts : int
        Independent searches at most, until three of them have ended in the best minimum. Each
        begins at eight points about the scenario.
    within : float
        How far the numbers may plausibly be from those of the scenario, relative. A motion that
        hops, or is long, is fitted faster where the scenario is better: 0.01 takes one start.
    systematic : bool
        Whether to estimate by how much the numbers would move if the table were tilted by 0.1
        degrees, by the air on a sphere of its size, and for a contact disc of 0.1 mm, unless the
        scenario has `plane.tilt`, a table [air], or a law with a disc. False: of a computed motion.
    laws : list of str or mappings, optional
        Different friction laws, two at least, under which the film is fitted, by name, or as tables
        `friction`: the one that explains it best is returned, and `laws` has all of them. Where one
        explains the film, searches under the others begin there, and end soon. Free numbers that a
        law lacks are left out.
    marker : three floats, or text with commas, optional
        Where the marker of columns `marker_x` ... is on the body, from the centre of mass, body
        axes [m].
    quaternion, up, track, chip
        As for `compare`.
    noise : float or str, optional
        Standard deviation of measured angles and directions: radians, or a text such as "1.5 deg".
        theta may lie beyond 0 and pi by five of these, and larger residuals are reported.
    progress : bool or callable
        True shows a bar in a terminal or a notebook; a callable is called with the numbers of
        windows of the data that are done and that are expected.

    Returns
    -------
    Fitted

    Raises
    ------
    InputError
        If the table, a name or the scenario is wrong, or a free number does not change any
        measurement.

    Examples
    --------
    >>> import tippetop as tt
    >>> print(tt.fit("film.csv", "inverting", ["friction.mu", "initial.omega3"]))
    """
    problem = _reference("scenario", scenario)
    names = names_of("free", free)
    starts = positive_integer("starts", starts)
    within = finite("within", within)
    if not 0 < within <= 1:
        raise InputError(f"`within` must be greater than 0, and at most 1, but is {within}.")
    flag("systematic", systematic)

    def fitted(problem: Problem, names: Sequence[str], rival: Fitted | None = None) -> Fitted:
        """Fit these numbers of a problem, with the other arguments of `fit`.

        `rival` is a fit under another law that explains the film: the problem then has its numbers,
        and the search stays near them.
        """
        near = min(within, law_choice.NEAR) if rival else within
        observation = observed(data, problem, names, **film)
        with reporting(progress, "windows") as report:
            result = fitting.fit(observation, loss, starts, near, systematic, rival, report)
        return Fitted(**vars(result))  # the fields of `Fit`, and no `laws`

    if not laws:
        return fitted(problem, names)
    until = float(read(path_of("data", data), wrapped=False, track=film.get("track")).t[-1])
    fits: dict[str, Fitted] = {}
    every = laws.split(",") if isinstance(laws, str) else laws
    kinds = [law_choice.under(problem, law, until).law for law in every]
    if len({kind.key for kind in kinds}) < max(len(kinds), 2):
        raise InputError(
            "`laws` must be two different laws or more, but are "
            f"{', '.join(kind.key for kind in kinds)}."
        )
    # laws with fast motions first, under which a top neither sticks nor drills, then that of the
    # scenario: if one explains the film, searches under others begin there, and end soon
    order = [(k.set_valued or bool(k.regions), k.key != problem.law.key) for k in kinds]
    for _, law in sorted(zip(order, every, strict=True), key=lambda pair: pair[0]):
        rival = next((other for other in fits.values() if other.is_noise), None)
        one = law_choice.under(rival.problem if rival else problem, law, until)
        known = [n for n in names if n in one.rules or not n.startswith("friction.")]
        fits[one.law.key] = fitted(one, known, rival)
    best, sentence = law_choice.verdict(fits)
    chosen = fits[best]
    return replace(chosen, reasons=[*chosen.reasons, sentence], laws=fits)


def _reference(name: str, source: Any) -> Any:
    """Return the problem of a scenario, a run, or the store of one. Raises InputError.

    `name` is that of the argument in messages. `compare`, `fit` and `log_likelihood` share it.
    """
    kinds = Run | Problem | Mapping | str | os.PathLike
    instance(name, source, kinds, "a scenario or a run")
    if isinstance(source, str | os.PathLike):
        return load_any(path_of(name, source))
    return problem_behind(source)
