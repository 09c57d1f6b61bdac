"""The score of an engine: how far its results are from the references.

Files of results go in; a `Score` comes out, one `Result` for each file.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..arguments import path_of
from ..errors import InputError, suggestion
from ..exchange.comparison import ROUNDING, Compared, shown, size_of
from ..exchange.motion import angle_between, in_body_axes, motion, theta_of, turned
from ..exchange.motion_table import Table, read
from ..exchange.simulators import gravity
from ..mechanics.contact.body import size
from ..problem import Problem
from ..runs.shape import moments, surface_of
from .case_files import CONTENT
from .named_cases import Case, case, names
from .outcome import RISES, outcome, rise
from .truth import OF_EXCHANGE, VECTORS, Truth, differences, truth


QUANTITIES = ("attitude", "theta", "position", "spin", "energy", "force")
"""Units of the errors: rad, rad, m, rad/s, relative to the first value, and in units of m g.

HEAD and the table of `case_files.README` have this order: a change of one is a change of all."""

WRONG_START = 0.1
"""Difference of the first row above which a file is not a result of its case.

In rad, and in the units of the length of the body and gravity."""

NOTICED = 1e-4
"""Least difference, in the same units, for which another reading of a file is considered."""

BETTER = 10.0
"""Ratio of the differences of a file as it is and as another reading, which is then the right one.
"""

TURNED = 0.5
"""Angle [rad] after which the sense of rotation of a file is compared."""

WORDS = {"largest": "max", "at": "at", "rms": "rms", "mean": "mean"}  # of `comparison.size_of`
"""Plain data of each quantity -> the number of the comparison."""

SATURATED = 1.0
"""Error of an attitude [rad] from which it no longer grows with the step."""

GAP = 0.01
"""Longest time between rows of a result whose outcome is judged, by the length of the case."""

SINGLE = 1e-6
"""Relative excess of the last time over the end of a case, as of numbers in single precision."""

HEAD = (
    "case",
    "engine",
    "setting",
    "step [s]",
    "attitude [rad]",
    "theta [rad]",
    "position [m]",
    "spin [rad/s]",
    "energy",
    "force [m g]",
    "mean",
    "attitude rms",
    "worst at [s]",
    "leaves 1e-3, 1e-2, 1e-1 rad at [s]",
    "order",
    "outcome",
)


class Result(NamedTuple):
    """One result and its reference.

    `_result` makes it.

    Attributes
    ----------
    case, engine, setting
        Names, of its path.
    compared
        Times up to the horizon, errors by quantity, theta of both, and the numbers of the score.
    outcome, expected
        The outcome of the result, and that of the reference.
    heights
        Height of the centre of mass of both, up to the horizon [m]; NaN where it is missing.
    unseen
        The longest time without a row (start, end) [s] if it is too long to judge the outcome.
    """

    case: str
    engine: str
    setting: str
    compared: Compared
    outcome: dict[str, bool]
    expected: dict[str, bool]
    heights: tuple[np.ndarray, np.ndarray]
    unseen: tuple[float, float] | None

    @property
    def wrong(self) -> list[str]:
        """Return the outcomes that differ from those of the reference."""
        return [name for name, seen in self.outcome.items() if seen != self.expected[name]]

    @property
    def judgement(self) -> str:
        """Return whether the outcome is right, wrong or not judged, and the reason."""
        if self.unseen:
            return "not judged: no rows from {:g} to {:g} s".format(*self.unseen)
        if self.wrong:
            return "wrong: " + ", ".join(self.wrong)
        if missing := [name for name in self.expected if name not in self.outcome]:
            return "not judged, for lack of columns: " + ", ".join(missing)
        return "right"


class Score:
    """The results of engines and their references. `tippetop.benchmark.score` makes it.

    Attributes
    ----------
    results : list of Result
        By case, engine and setting; the largest step first.
    """

    def __init__(self, results: list[Result]):
        self.results = sorted(results, key=lambda r: (*r[:3], -(r.compared.step or 0.0)))

    def to_dict(self) -> list[dict[str, Any]]:
        """Return everything as plain data, a mapping for each result.

        The order of convergence compares a result with the one before, which has the next larger
        step if it is of the same case, engine and setting: `results` are sorted.
        """
        return [
            {
                "case": r.case,
                "engine": r.engine,
                "setting": r.setting,
                "step": r.compared.step,
                "file": str(r.compared.path),
                **{
                    word: {name: r.compared.numbers[name][key] for name in r.compared.curves}
                    for word, key in WORDS.items()
                },
                "leaves": r.compared.numbers["attitude"]["leaves"],
                "order": _order(before.compared, r.compared) if before[:3] == r[:3] else None,
                "outcome": r.outcome,
                "expected": r.expected,
                "outcome_is_right": {"right": True, "wrong": False}.get(r.judgement.split(":")[0]),
                "judgement": r.judgement,
            }
            # the first result is its own predecessor: equal steps have no order
            for before, r in itertools.pairwise([*self.results[:1], *self.results])
        ]

    def failures(self, limits: Mapping[str, float]) -> list[str]:
        """Return a sentence for each way in which a result fails.

        Parameters
        ----------
        limits : mapping of str to float
            Of the largest errors, by quantity: attitude, theta, position, spin, energy or force, in
            the units of the table.

        Returns
        -------
        list of str
            On errors beyond a limit or unknown for lack of columns, and on outcomes that are wrong
            or cannot be judged, for lack of columns or rows.
        """
        sentences = []
        for r in self.results:
            faults = []
            if r.judgement != "right":
                faults.append(f"outcome must be right, but is {r.judgement}")
            for name, limit in limits.items():
                error = r.compared.numbers.get(name)
                if error is None or error["max"] > limit:
                    found = f"is {error['max']:.3g}" if error else "its columns are missing"
                    faults.append(f"error of {name} must be at most {limit:g}, but {found}")
            sentences += [f"`{r.compared.path}`: the {fault}." for fault in faults]
        return sentences

    def to_markdown(self) -> str:
        """Return the table as Markdown."""
        rows = [HEAD, ("---",) * len(HEAD), *self._rows()]
        return "\n".join(f"| {' | '.join(row)} |" for row in rows)

    def __str__(self) -> str:
        rows = [HEAD, *self._rows()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)

    def _rows(self) -> list[tuple[str, ...]]:
        """Return a row of text under HEAD for each result; `-` for what its file lacks."""
        rows = []
        for r, plain in zip(self.results, self.to_dict(), strict=True):
            row = (
                *r[:3],
                shown(plain["step"] or None, "g"),
                *(shown(plain["largest"].get(name)) for name in QUANTITIES),
                shown(plain["mean"].get("force")),
                shown(plain["rms"]["attitude"]),
                shown(plain["at"]["attitude"], ".3g"),
                ", ".join(shown(t, ".3g", "never") for t in plain["leaves"].values()),
                shown(plain["order"] or None, ".2f"),
                r.judgement,
            )
            rows.append(row)
        return rows


def _order(coarse: Compared, fine: Compared) -> float | None:
    """Return the order of the rms attitude between two steps.

    None if the first is not the larger one, or an error is saturated or made by rounding.
    `case_files.README` and the help of `cli.benchmark` describe it: a change of one is a change of
    all.
    """
    sizes = [c.numbers["attitude"] for c in (coarse, fine)]
    ratio = (coarse.step or 0.0) / (fine.step or math.inf)
    if ratio <= 1 or any(s["max"] > SATURATED or s["rms"] < ROUNDING for s in sizes):
        return None
    return math.log(sizes[0]["rms"] / sizes[1]["rms"]) / math.log(ratio)


def score(
    results: str | Path | Iterable[str | Path],
    name: str | Path | None = None,
    *,
    skip: Callable[[InputError], None] | None = None,
) -> Score:
    """Compare results of engines with the references.

    Parameters
    ----------
    results : path or iterable of paths
        CSV or Parquet files ENGINE/SETTING/CASE/dt=STEP.csv, or folders that contain them. The
        columns `t [s]`, `q_w`, `q_x`, `q_y`, `q_z` are required; those of the centre of mass
        (`x [m]` ..., `vx [m/s]` ...), `omega_x [rad/s]` ... and `force_x [N]` ... are optional.
    name : str or path, optional
        The case of all files, or the TOML file of a scenario; by default the name of their folder.
    skip : callable, optional
        Called with the error of each file that cannot be scored; the others are scored. By default
        the first error is raised.

    Returns
    -------
    Score

    Raises
    ------
    InputError
        If a file or its name is wrong.
    """
    given: Any = [results] if isinstance(results, str | Path) else results
    paths = dict.fromkeys(file for each in given for file in _files(path_of("results", each)))
    if not paths:
        raise InputError("at least one result must be given: ENGINE/SETTING/CASE/dt=STEP.csv.")
    known: dict[tuple[str, bytes], Truth] = {}
    chosen = case(name) if name else None
    found = []
    for path in paths:
        try:
            found.append(_result(path, _case_of(path, chosen), known))
        except InputError as error:
            if skip is None:
                raise
            skip(error)
    return Score(found)


def _files(path: Path) -> list[Path]:
    """Return the results in a folder, or the file itself."""
    if not path.is_dir():
        return [path]
    files = sorted(file for file in path.rglob("*") if file.suffix in (".csv", ".parquet"))
    results = [file for file in files if not _is_reference(file)]
    if files and not results:
        raise InputError(f"`{path}` must contain results, but contains exported references.")
    return results


def _is_reference(path: Path) -> bool:
    """Return whether a file belongs to an exported case."""
    return path.name in CONTENT and (path.parent / "case.json").exists()


def _case_of(path: Path, chosen: Case | None) -> Case:
    """Return the case of a file. Raises InputError if it is unknown."""
    if not path.exists():
        raise InputError(f"`{path}`: no such file or folder.")
    folder = path.resolve().parent.name
    if chosen is None and folder not in names():
        raise InputError(
            f"`--case CASE` is required for a file outside ENGINE/SETTING/CASE/, but `{path}` is "
            f"in the folder `{folder}`.{suggestion(folder, names())}"
        )
    return chosen or case(folder)


def _result(path: Path, each: Case, known: dict[tuple[str, bytes], Truth]) -> Result:
    """Return the `Result` of the file at a path, compared with its case `each`.

    `known` are references by case and times, which are computed once; new ones are added. They
    begin at 0 even if the result begins later, as the motion does.
    """
    table = _checked(path, each)
    t = table.t
    key = each.name, t.tobytes()
    if key not in known:
        times, place = np.unique([0.0, *np.minimum(t, each.problem.until)], return_inverse=True)
        whole = truth(each.problem, times)[0]
        known[key] = Truth(*(part[place[1:]] for part in whole))
    exact = known[key]
    there = _motion(table)
    _check_start(path, there, exact, each.problem)
    within = t <= each.horizon * (1 + 1e-12)  # the horizon is rounded
    curves = {n: c[within] for n, c in _errors(there, exact, each).items() if np.isfinite(c).all()}
    thetas = theta_of(there.quaternion)[within], theta_of(exact.quaternion)[within]
    numbers = {name: size_of(t[within], curve) for name, curve in curves.items()}
    compared = Compared(path, t[within], curves, *thetas, numbers)
    seen, expected = (outcome(each.problem, each_motion) for each_motion in (there, exact))
    if expected.get("lifts off") and "lifts off" in seen:
        ratio = rise(each.problem, there) / rise(each.problem, exact)
        seen["rises as high"], expected["rises as high"] = 1 / RISES <= ratio <= RISES, True
    folders = path.resolve().parts[:-1]
    engine = path.stem
    setting = "-"
    if folders[-1] == each.name and not _is_reference(path):
        *_, engine, setting = ("-", "-", *folders[:-1])
    heights = there.position[within, 2], exact.position[within, 2]
    unseen = _unseen(t, each.problem.until)
    return Result(each.name, engine, setting, compared, seen, expected, heights, unseen)


def _unseen(t: np.ndarray, until: float) -> tuple[float, float] | None:
    """Return the longest time without a row [s], or None if it is short enough, but for rounding.

    Times before the first row and after the last one count.
    """
    times = np.array([0.0, *t, until])
    gaps = np.diff(times)
    longest = int(gaps.argmax())
    if gaps[longest] <= GAP * until * (1 + 1e-6):
        return None
    return float(times[longest]), float(times[longest + 1])


def _checked(path: Path, each: Case) -> Table:
    """Return the table of a result of the case `each`. Raises InputError if it cannot be scored."""
    table = read(path, gaps=False)
    needed = VECTORS["quaternion"]
    if missing := [name for name in needed if not table.has(name)]:
        raise InputError(
            f"`{path}` must have the columns {', '.join(needed)}, but lacks {', '.join(missing)}."
        )
    end = each.problem.until
    if table.t[0] < 0 or table.t[-1] > end * (1 + SINGLE):
        raise InputError(
            f"`{path}`: times must be from 0 to {end:g} s, the end of {each.name}, but are from "
            f"{table.t[0]:.12g} to {table.t[-1]:.12g} s."
        )
    return table


def _motion(table: Table) -> Truth:
    """Return the motion of a result; NaN for missing columns."""
    given = motion(table)
    none = np.full((len(table.t), 3), np.nan)
    return Truth(table.t, *(given.get(name, none) for name in OF_EXCHANGE))


def _check_start(path: Path, there: Truth, exact: Truth, problem: Problem) -> None:
    """Raise InputError if a result starts elsewhere, or if another reading of it fits better.

    The first row is compared, and one where the body has turned, so that frames differ. A reading
    is what the numbers would mean by another convention; the hint of one that fits is the message.
    """
    q = there.quaternion
    body = problem.body()
    length = size(body)
    rate = math.sqrt(body.g / length)
    arm = turned(q, surface_of(body).centre)
    units = {
        "attitude [rad]": 1.0,
        "position [m]": length,
        "velocity [m/s]": length * rate,
        "omega [rad/s]": rate,
    }
    readings = {
        "the order of the quaternion is x, y, z, w: name the columns accordingly.": there._replace(
            quaternion=np.roll(q, 1, axis=1)
        ),
        "the quaternion turns space axes into body axes: change the sign of q_x, q_y, q_z.": (
            there._replace(quaternion=q * [1.0, -1.0, -1.0, -1.0])
        ),
        "it is that of the centre of the ball: give those of the centre of mass.": there._replace(
            position=there.position - arm, velocity=there.velocity - np.cross(there.omega, arm)
        ),
        "it is in body axes: name the columns omega_body_x, omega_body_y, omega_body_z.": (
            there._replace(omega=turned(q, there.omega))
        ),
    }
    apart, *others = (differences(motion, exact) for motion in (there, *readings.values()))
    turns = angle_between(exact.quaternion, exact.quaternion[:1]) > TURNED
    for row, (name, unit) in itertools.product({0, int(turns.argmax())}, units.items()):
        off = apart[name][row]
        hints = [h for h, o in zip(readings, others, strict=True) if o[name][row] < off / BETTER]
        begins = row == 0 and (there.t[0] == 0 or name == "attitude [rad]")
        if (hints and off > NOTICED * unit) or (begins and off > WRONG_START * unit):
            hints.append("check the start, the frames, the units and the order of the quaternion.")
            raise InputError(
                f"`{path}`: {name} at {there.t[row]:g} s must be near the reference, but differs "
                f"by {off:.3g}; {hints[0]}"
            )


def _errors(there: Truth, exact: Truth, each: Case) -> dict[str, np.ndarray]:
    """Return the errors of a motion by QUANTITIES, (rows,) each; NaN where columns are missing.

    `there` is the result and `exact` its reference at the same times. Energies are relative to the
    first one of the reference, forces to the weight; attitude and theta are in rad, position in m,
    spin in rad/s.
    """
    body = each.problem.body()
    apart = differences(there, exact)
    spins = []
    energies = []
    for m in (there, exact):
        parts = in_body_axes(m.quaternion, m.omega)
        spins.append(parts[:, 2])
        moving = body.m * (m.velocity**2).sum(axis=1) + parts**2 @ moments(body)
        energies.append(moving / 2 - body.m * m.position @ gravity(body))
    return {
        "attitude": apart["attitude [rad]"],
        "theta": apart["theta [rad]"],
        "position": apart["position [m]"],
        "spin": np.abs(spins[0] - spins[1]),
        "energy": np.abs((energies[0] - energies[1]) / energies[1][0]),
        "force": apart["force [N]"] / (body.m * body.g),
    }
