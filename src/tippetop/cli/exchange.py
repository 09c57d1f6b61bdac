"""`tippetop compare, fit`: measurements and motions of other programs, and the exact motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import InputError
from .streams import print_json, visible
from .values import Place, Whole


Lengths = Annotated[str | None, Parameter(allow_leading_hyphen=True)]


# the fields are keywords of `library.exchanging.compare` and `fit`
@Parameter(name="*")
@dataclass(frozen=True)
class Frames:
    """How a table is read.

    Parameters
    ----------
    quaternion
        The order of columns q_0, q_1, q_2, q_3: wxyz or xyzw.
    up
        The letter of the vertical in its frames, and of the body's axis of symmetry: z or
        y. With y their z, x, y are x, y, z here.
    track
        The object whose columns are read, where a file has several: its name in the line before
        the header.
    chip
        Where the accelerometer is in the body: x,y,z [m] in body axes from the centre of mass.
    """

    quaternion: str | None = None
    up: str = "z"
    track: str | None = None
    chip: Lengths = None


SAME = Frames()


def compare(
    *files: str,
    set_: list[str] | None = None,
    frames: Frames = SAME,
    figure: Place | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Compare the motion of another program with the reference.

    Usage: tippetop compare OTHER.csv ... REFERENCE.

    Parameters
    ----------
    files
        CSV or Parquet files of the other program, then the reference: a scenario, a preset, or the
        store of a run. Headers name columns and units, such as t [s], theta [deg]: see tippetop
        help measurements. Every column is compared; one that the reference lacks is refused. A
        name such as dt=1e-3.csv contains the time step: of several steps
        the order of convergence is printed.
    set_
        Change a value of the reference: table.key=value. May be repeated.
    frames
        How the files are read.
    figure
        Draw both motions, the differences and the drifts to this PNG, SVG or PDF.
    overwrite
        Replace an existing picture.
    as_json
        Print the result as one JSON object.
    """
    from ..library.exchanging import compare as compared
    from ..runs.starting import load_any
    from .targets import check_picture

    if len(files) < 2:
        raise InputError(
            "a file and a reference must be given: tippetop compare OTHER.csv SCENARIO."
        )
    check_picture(figure, overwrite)
    result = compared([*files[:-1]], load_any(files[-1], set_), **vars(frames))
    return _print(result, figure, overwrite, as_json)


def fit(
    data: str,
    scenario: str,
    *,
    free: str,
    set_: list[str] | None = None,
    loss: str = "linear",
    starts: Whole = 12,
    within: float = 0.4,
    no_systematic: bool = False,
    laws: str = "",
    marker: Lengths = None,
    frames: Frames = SAME,
    noise: str | None = None,
    figure: Place | None = None,
    out: Place | None = None,
    overwrite: bool = False,
    as_json: bool = False,
) -> int:
    """Fit numbers of a scenario to a measured motion, by least squares.

    Usage: tippetop fit DATA SCENARIO --free friction.mu,initial.omega3.

    Parameters
    ----------
    data
        CSV or Parquet. The header names columns and units, such as t [s], theta [deg], omega3
        [rpm]: see tippetop help measurements. Empty cells are gaps.
    scenario
        TOML file, preset, or the store of a run: its numbers are kept, or are the first guess of
        those that are free.
    free
        The numbers that are fitted: dotted names separated by commas, time.offset [s] and
        time.scale of the table's clock among them: the motion's time is scale t + offset, so that
        a clock that was started before the motion has a negative offset.
    set_
        Change a value: table.key=value. May be repeated.
    loss
        linear, or soft_l1, huber, cauchy, which outliers hardly move.
    starts
        Independent searches at most, until three of them have ended in the best minimum. Each
        begins at eight points about the scenario.
    within
        How far the numbers may plausibly be from those of the scenario, relative: 0.01 is faster.
    no_systematic
        Do not estimate by how much the numbers would move if the table were tilted by 0.1 degrees,
        by the air on a sphere of its size, and for a contact disc of 0.1 mm.
    laws
        Friction laws separated by commas, such as viscous,coulomb,contensou: the film is fitted
        under each; the one that explains it best is printed, and which do equally well.
    marker
        Where the marker is on the body: x,y,z [m] in body axes from the centre of mass; with
        columns marker_x ...
    frames
        How the table is read.
    noise
        Standard deviation of measured angles and directions, such as "1.5 deg": theta may lie
        beyond 0 and 180 degrees by five of these, and larger residuals are reported.
    figure
        Draw data, fit and residuals to this PNG, SVG or PDF; must not exist yet (or use
        --overwrite).
    out
        Write the scenario with the fitted numbers to this TOML file; must not exist yet (or use
        --overwrite).
    overwrite
        Replace files that exist.
    as_json
        Print the result as one JSON object.
    """
    from ..library.exchanging import fit as fitted
    from ..runs.starting import load_any
    from ..store import files
    from .targets import check_picture

    check_picture(figure, overwrite)
    if out and out.suffix != ".toml":
        raise InputError(f"--out must end with .toml, but is `{out}`.")
    if out:  # now rather than after the fit
        files.refuse_existing(out, overwrite)
    result = fitted(
        data,
        load_any(scenario, set_),
        free,
        loss=loss,
        starts=starts,
        within=within,
        systematic=not no_systematic,
        laws=laws,
        marker=marker,
        **vars(frames),
        noise=noise,
    )
    if out is not None:
        files.write_text(out, result.to_toml(), overwrite=overwrite)
    return _print(result, figure, overwrite, as_json)


def _print(result: Any, figure: Path | None, overwrite: bool, as_json: bool) -> int:
    """Draw and print a `Comparison` or a `Fitted`; return the exit code."""
    if figure is not None:
        result.plot(figure, overwrite=overwrite)
    if as_json:
        return print_json(result.to_dict())
    print(visible(str(result)))
    return 0
