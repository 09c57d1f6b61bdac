"""The predictions of a scenario for a table of measurements, and their derivatives.

A measured motion and a problem go in; `predictions` returns residuals by group at any values of the
free numbers. A group is a kind of measurement, such as `theta`, `axis` or `accelerometer`.
`observed` reads a file of them, for `fitting` and `likelihood`.
"""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import PlainData, dotted_keys, measured, path_of, takes
from ..columns import Arrays
from ..errors import InputError, suggestion
from ..mechanics.number import Number
from ..mechanics.units import ONE, RADIAN, SECOND
from ..problem import Problem
from ..scenario import build
from .headers import CAMERA, UNITS
from .motion import angle_in_picture, convention_of, motion, place_of, theta_of, turned
from .motion_table import read as read_table
from .predictions import ACCELEROMETER, TOLERANCE, at_chip, columns_at, followed
from .residuals import residuals
from .scales import FAR, Space, scale_of


OFFSET = "time.offset"
CLOCK = "time.scale"
TIMES = {
    OFFSET: Number(SECOND, "time of the motion where the table's clock shows 0"),
    CLOCK: Number(ONE, "seconds of the motion per second of the table's clock", above=0),
}
"""Numbers of the clock of a table: the motion's time is scale t + offset."""
# Times of a curve: fifteen in a period of the canonical top filmed for ten seconds
DRAWN = 4001
# Fraction of the duration within which the time of a clock is searched
REACH = 1 / 8
# Internal units of time of the longest motion of a fit: half an hour of computing
LONGEST = 3e4
# Rows of a table at most
MOST_ROWS = 100_000
NAMES = {
    "place": ("x", "y"),
    "marker": ("x", "y", "z", "orientation"),
    "accelerometer": ACCELEROMETER,
}
"""Columns of a motion for each kind of measurement, unless they have its name."""


class Observation:
    """Measurements, and their predictions by a problem.

    `observed` makes it.

    Parameters
    ----------
    problem
        The scenario.
    free
        Dotted names of the free numbers, which may include `time.offset` and `time.scale`.
    seen
        The measured motion, as `motion` returns it.
    marker
        The place of the marker in body axes, from the centre of mass [m].
    noise
        Standard deviation of measured angles and directions [rad]; None: unknown.
    chip
        The place of the accelerometer in body axes, from the centre of mass [m].

    Attributes
    ----------
    groups
        Name of each kind of measurement -> (rows, parts); NaN in gaps.
    stated
        Standard deviation of the noise of each kind for which it is stated [rad].
    given
        Which residuals of each kind are numbers, (rows, parts) of `residuals`.
    columns
        Names of the columns of a motion from which the groups are predicted.
    own
        The free numbers of the scenario: `free` without those of the clock.
    exact, predicted
        The scenario with its own tolerance, and that by which predictions are computed.

    All dicts by kind have the order of `groups`, in which `Misfit` joins residuals.
    """

    def __init__(
        self,
        problem: Problem,
        free: Sequence[str],
        seen: Arrays,
        marker: tuple[float, float, float] | None = None,
        noise: float | None = None,
        chip: Sequence[float] = (0.0, 0.0, 0.0),
    ):
        """Check times and free numbers, and sort the measurements into groups.

        A missing measurement (NaN) is not compared.
        """
        self.free = tuple(free)
        self.t = seen["t"]
        longest = LONGEST * problem.unit(SECOND)
        # [s] Within which the time of the table's clock is searched
        self.reach = REACH * float(self.t[-1] - self.t[0])
        if self.t[-1] > longest:
            raise InputError(
                f"the last time must be at most {longest:.3g} s in a fit, but is {self.t[-1]:.6g} "
                f"s ({self.t[-1] / 3600:.2g} hours): is `t` in ms?"
            )
        faults = [
            f"`{name}` must be {' or '.join(TIMES)}, but is not.{suggestion(name, TIMES)}"
            for name in free
            if name.startswith("time.") and name not in TIMES
        ]
        if faults:
            raise InputError(faults)
        self.marker = marker
        self.chip = chip
        self.groups = _groups(problem, seen)
        if not self.groups:
            raise InputError(
                "the table must have theta, an axis, a quaternion, a camera, omega3, omega, a "
                "gyroscope, an accelerometer, a place or a marker."
            )
        self.stated = {g: noise for g in self.groups if noise is not None and g not in UNITS}
        self.given = {
            group: np.isfinite(residuals(group, rows, rows)) for group, rows in self.groups.items()
        }
        self.columns = {name for group in self.groups for name in _names(group)}
        self._predict(problem, [name for name in free if name not in TIMES])

    @property
    def count(self) -> int:
        """The number of measured numbers; a direction counts as two, as its noise has two."""
        return sum(int(given.sum()) for given in self.given.values())

    @property
    def used(self) -> dict[str, int]:
        """The number of rows in which each kind of measurement is used."""
        return {
            kind: int(np.isfinite(rows).any(axis=1).sum()) for kind, rows in self.groups.items()
        }

    def under(self, problem: Problem) -> Observation:
        """Return the same measurements under another scenario, whose numbers are not free.

        Those of the clock still are. Raises InputError for a scenario that cannot be fitted, on
        which `influences.changes` relies.
        """
        other = copy.copy(self)
        other._predict(problem, ())
        other.refine()
        return other

    def tables(self, values: Mapping[str, float]) -> PlainData:
        """Return the tables of the scenario with these values of the free numbers, SI.

        They are those of `build.resolved`; values of the clock are not used.
        """
        tables = build.resolved(self.problem)
        for name in self.own:
            table, _, key = name.partition(".")
            tables[table][key] = values[name]
        return tables

    def _predict(self, problem: Problem, own: Sequence[str]) -> None:
        """Set the problem by which predictions are computed, whose numbers `own` are free.

        Raises InputError for an accelerometer where the contact may change, and for a problem or
        a name that `followed` refuses.
        """
        if "accelerometer" in self.columns and problem.system.is_hybrid:
            raise InputError(
                "an accelerometer is fitted only where the contact never changes: leave it out, or "
                "give a smooth law without [contact], [stem], [air] and [plane]."
            )
        self.problem = problem
        self.own = tuple(own)
        self.exact = followed(problem, own)
        self.predicted = dataclasses.replace(
            self.exact, tolerance=max(TOLERANCE, problem.tolerance)
        )

    def refine(self) -> None:
        """Predict with the tolerance of the scenario from now on, rather than a coarser one."""
        self.predicted = self.exact

    def rule(self, name: str) -> Number:
        """Return the `Number` of a free number: its unit and interval."""
        return TIMES.get(name) or self.problem.rules[name]

    @property
    def units(self) -> list[float]:
        """The SI values of the internal units of the free numbers, in their order."""
        return [self.problem.unit(self.rule(name).unit) for name in self.free]

    def start(self) -> dict[str, float]:
        """Return the values of the free numbers in the scenario, SI, by name."""
        first = float(self.t[0])
        apart = first < 0 or first > self.reach  # then the motion starts with the first row
        values = {OFFSET: -first if apart else 0.0, CLOCK: 1.0}
        for table, numbers in self.problem.tables.items():
            values |= {f"{table}.{name}": value for name, value in numbers.items()}
        return {name: float(values.get(name, 0.0)) for name in self.free}

    def space(self, within: float = FAR) -> Space:
        """Return the space of the free numbers, which are known `within` a relative distance."""
        begin = self.start()
        rules = map(self.rule, begin)
        return Space(begin, [*map(scale_of, rules, begin.values(), self.units)], within)

    def predictions(self, points: Mapping[str, Any], rows: slice = slice(None)) -> Arrays:
        """Compute the residuals of each group, (points, rows, parts), SI.

        They are NaN in gaps, and where the motion cannot be computed. `points` are values of the
        free numbers, SI, (points,) by name, or one of each.
        """
        read = self._read(points, self.t[rows])
        return {
            group: residuals(group, seen[rows], self._predicted_rows(group, read))
            for group, seen in self.groups.items()
        }

    def dots(self) -> Arrays:
        """Return the measurements as a figure shows them, by group, (rows, parts).

        An orientation is shown as its theta.
        """
        return _drawn(self.groups)

    def curves(self, values: Mapping[str, float]) -> tuple[np.ndarray, Arrays]:
        """Return predictions as a figure shows them: times [s], and curves by group.

        The times are evenly spread over those of the measurements, which `dots` returns.
        """
        t = np.linspace(self.t[0], self.t[-1], DRAWN)
        read = self._read(values, t)
        return t, _drawn({group: self._predicted_rows(group, read)[0] for group in self.groups})

    def _read(self, points: Mapping[str, Any], t: np.ndarray) -> Arrays:
        """Return columns (points, rows, ...) by name, SI, at times t (rows,) of the table [s]."""
        own = {name: np.atleast_1d(points[name]) for name in self.own}
        scale, offset = np.atleast_1d(points.get(CLOCK, 1.0), points.get(OFFSET, 0.0))
        clock = scale[:, None] * t + offset[:, None]
        return columns_at(self.predicted, own, clock, self.columns)

    def _predicted_rows(self, group: str, read: Arrays) -> np.ndarray:
        """Return the predictions of a group, (points, rows, parts), from columns `read`."""
        if group == "accelerometer":
            return at_chip(read, self.chip)
        if group in ("place", "marker"):
            place = np.stack([read[name] for name in _names(group) if name in "xyz"], axis=-1)
            own = turned(read["orientation"], np.array(self.marker)) if group == "marker" else 0.0
            return place + own
        model = angle_in_picture(read["axis"], group) if CAMERA.fullmatch(group) else read[group]
        return model if model.ndim > 2 else model[..., None]


def _groups(problem: Problem, seen: Arrays) -> Arrays:
    """Return the measurements by kind, (rows, parts), each quantity once.

    `seen` is the result of `motion.motion`. In each row only the first kind of an attitude, and of
    a spin, is kept that is complete there: the others follow from it, and would count twice.
    """
    groups: Arrays = {}
    attitudes = ["theta"]
    if "axis" in problem.system.vectors:
        attitudes = ["orientation", "axis", "theta", "phi"]
    spins = ["gyroscope", "omega"]
    if "omega3" in problem.system.angles._fields:
        spins.append("omega3")
    for kinds in (attitudes, spins):
        left = np.ones(len(seen["t"]), bool)
        for kind in filter(seen.__contains__, kinds):
            rows = np.where(left[:, None], seen[kind].reshape(len(left), -1), np.nan)
            full = np.isfinite(rows).all(axis=1)
            left &= ~full
            if kinds is attitudes:  # an axis needs both angles
                rows[~full] = np.nan
            if np.isfinite(rows).any():
                groups[kind] = rows
    groups |= {name: rows[:, None] for name, rows in seen.items() if CAMERA.fullmatch(name)}
    has_place = {"x", "y"} <= set(problem.system.angles._fields)
    if has_place and "place" in seen and np.isfinite(seen["place"][:, :2]).any():
        groups["place"] = seen["place"][:, :2]
    return groups | {kind: seen[kind] for kind in ("accelerometer", "marker") if kind in seen}


def _drawn(rows: Arrays) -> Arrays:
    """Return measurements or predictions by group, (rows, parts), an orientation as its theta."""
    theta = {name: theta_of(q)[:, None] for name, q in rows.items() if name == "orientation"}
    return rows | theta


def _names(group: str) -> tuple[str, ...]:
    """Return the names of the columns of a motion that a kind of measurement is predicted from."""
    return ("axis",) if CAMERA.fullmatch(group) else NAMES.get(group, (group,))


@takes(convention_of)
def observed(
    data: str | Path,
    problem: Problem,
    free: Sequence[str],
    *,
    marker: Sequence[float] | str | None = None,
    noise: float | str | None = None,
    **frames: Any,
) -> Observation:
    """Return measurements and the prediction of a scenario for them.

    `library.exchanging.fit` has the same keywords from here, and its docstring explains them to
    users: change both together.

    Parameters
    ----------
    data
        A CSV or Parquet file, as for `motion_table.read`.
    problem
        The scenario.
    free
        Dotted names of the free numbers.
    marker
        The place of the marker in body axes, from the centre of mass [m], or a text with commas.
    noise
        The standard deviation of measured angles [rad], or a text such as "1 deg".
    **frames
        As for `motion.convention_of`.

    Raises
    ------
    InputError
        If the table, the names or the conventions are wrong.
    """
    data = path_of("data", data)
    convention = convention_of(**frames)
    at = place_of("marker", marker)
    noise = None if noise is None else measured("noise", noise, RADIAN)
    if noise is not None and not 0 < noise < np.pi:
        raise InputError(f"`noise` must be an angle between 0 and pi, but is {noise} rad.")
    table = read_table(
        data,
        wrapped=bool(problem.system.vectors),
        noise=noise or 0.0,
        track=convention.track,
    )
    if len(table.t) > MOST_ROWS:
        raise InputError(
            f"`{data}` must have at most {MOST_ROWS:,} rows to be fitted, but has {len(table.t):,}."
        )
    columns = [f"marker_{c}" for c in "xyz"]
    if len({at is not None, *map(table.has, columns)}) > 1:
        raise InputError(
            f"a marker must have the columns {', '.join(columns)} in `{data}` and a place on "
            "the body (--marker x,y,z, metres in body axes), but one of them is missing."
        )
    names = dotted_keys(free, problem.rules)
    seen = motion(table, convention)
    return Observation(problem, names, seen, at, noise, convention.chip)
