"""The predictions of a scenario for a table of measurements, and their derivatives."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from ..columns import Arrays
from ..engine.expressions import AXES, component
from ..engine.tangent import Tangents
from ..engine.variational import CHIP
from ..errors import InputError, suggestion
from ..mechanics.number import Number
from ..mechanics.units import METRE, ONE, SECOND
from ..problem import Problem
from . import residuals
from .headers import CAMERA
from .motion import Motion, picture, theta_of


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
# Tolerance of the integrator while numbers are searched: three fifths of the time
TOLERANCE = 1e-9
# Internal units of time of the longest motion of a fit: half an hour of computing
LONGEST = 3e4
UNSUPPORTED = (
    "fits under drilling friction, exact Coulomb friction, stems and hops are not supported "
    "yet: give a smooth law (a "
    'Coulomb law with `eps`), and no [contact], no [stem], no `on_liftoff = "fly"`.'
)
MOST_STEPS = 25.0  # per internal unit of time: a canonical inversion takes 9
AXIS = tuple(component(f"u{c}") for c in "xyz")
IN_BODY = dict.fromkeys(("gyroscope", "omega", "accelerometer"), CHIP)
NAMES = {
    **IN_BODY,
    "axis": AXIS,
    "place": ("x", "y"),
    "marker": ("x", "y", "height"),
    "orientation": (),
}
"""Columns of a motion for each kind of measurement, unless they have its name."""


class Observation:
    """Measurements, and their predictions by a problem.

    Parameters
    ----------
    problem
        The scenario.
    free
        Dotted names of the free numbers, which may include `time.offset` and `time.scale`.
    seen
        The measured motion.
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
    """

    def __init__(
        self,
        problem: Problem,
        free: Sequence[str],
        seen: Motion,
        marker: tuple[float, float, float] | None = None,
        noise: float | None = None,
        chip: Sequence[float] = (0.0, 0.0, 0.0),
    ):
        self.free = tuple(free)
        self.t = seen.t
        self.noise = noise
        if problem.contact is not None:
            raise InputError(UNSUPPORTED)
        self.second, self.metre = map(problem.unit, (SECOND, METRE))
        longest = LONGEST * self.second
        # [s] Within which the time of the table's clock is searched
        self.reach = REACH * float(self.t[-1] - self.t[0])
        if self.t[-1] > longest:
            raise InputError(
                f"the last time must be at most {longest:.3g} s in a fit, but is "
                f"{self.t[-1]:.6g} s "
                f"({self.t[-1] / 3600:.2g} hours): is `t` in ms?"
            )
        faults = [
            f"`{name}` must be {' or '.join(TIMES)}, but is not.{suggestion(name, TIMES)}"
            for name in free
            if name.startswith("time.") and name not in TIMES
        ]
        if faults:
            raise InputError(faults)
        self.own = tuple(name for name in free if name not in TIMES)
        self.marker = marker
        self.chip = np.reshape(chip, (1, 3, 1))
        self.groups = _groups(problem, seen)
        if not self.groups:
            raise InputError(
                "the table must have theta, an axis, a quaternion, a camera, omega3, omega, a "
                "gyroscope, an accelerometer, a place or a marker."
            )
        self.turning = bool({"orientation", "marker", *IN_BODY} & self.groups.keys())
        self.exact = dataclasses.replace(problem, orientation=self.turning)
        coarse = dataclasses.replace(self.exact, tolerance=TOLERANCE)
        self.tangents = Tangents(coarse, self.own, MOST_STEPS)
        turning = AXES if self.turning else ()
        self.names = tuple(
            dict.fromkeys([*turning, *(name for group in self.groups for name in _names(group))])
        )

    @property
    def used(self) -> dict[str, int]:
        """In how many rows each kind of measurement is used."""
        return {
            kind: int(np.isfinite(rows).any(axis=1).sum()) for kind, rows in self.groups.items()
        }

    def refine(self) -> None:
        """Predict with the tolerance of the scenario from now on."""
        self.tangents.problem = self.exact

    def rule(self, name: str) -> Number:
        """Return unit and interval of a free number."""
        return TIMES.get(name) or self.tangents.problem.rules[name]

    def start(self) -> dict[str, float]:
        """Return the values of the free numbers in the scenario."""
        first = float(self.t[0])
        apart = first < 0 or first > self.reach  # then the motion starts with the first row
        clock = {OFFSET: -first if apart else 0.0, CLOCK: 1.0}
        return {name: clock.get(name, self.tangents.values.get(name, 0.0)) for name in self.free}

    def predictions(
        self, points: Sequence[dict[str, float]], rows: slice = slice(None), *, slopes: bool = True
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Compute residuals and the derivatives of the predictions, for each group.

        The residuals are (points, rows, parts), the derivatives (points, rows, parts, free), SI;
        without `slopes` free is 0. NaN in gaps, and where the motion cannot be computed.
        """
        t = self.t[rows]
        k = len(points)
        jets = self._read(points, t, slopes=slopes)
        parts = {}
        for group, seen in self.groups.items():
            off, moves = self._residual(group, np.tile(seen[rows], (k, 1)), jets)
            parts[group] = off.reshape(k, len(t), -1), moves.reshape(k, len(t), *moves.shape[1:])
        return parts

    def dots(self) -> Arrays:
        """Return the measurements for a figure, by group, (rows, parts); theta for orientations."""
        rows = dict(self.groups)
        if "orientation" in rows:
            rows["orientation"] = theta_of(rows["orientation"])[:, None]
        return rows

    def curves(
        self, values: dict[str, float], t: np.ndarray | None = None
    ) -> tuple[np.ndarray, Arrays]:
        """Return the predictions of `dots` at times [s], by default also between them, and curves
        by group.
        """
        t = np.linspace(self.t[0], self.t[-1], DRAWN) if t is None else t
        jets = self._read([values], t, slopes=False)
        curves = {
            group: self._model(group, jets)[..., 0]
            for group in self.groups
            if group != "orientation"
        }
        if "orientation" in self.groups:
            x, y, z = (jets[name] for name in AXES[3:])
            curves["orientation"] = np.arctan2(np.hypot(x, y), z)
        return t, curves

    def _read(self, points: Sequence[dict[str, float]], t: np.ndarray, *, slopes: bool) -> Arrays:
        """Read the motions of sets of values, by name, (points rows, 1 + free), internal units.

        The first column is the value, the others its derivatives by the free numbers in SI units.
        """
        k = len(points)
        tangents = self.tangents
        lanes = max(1, len(self.own)) if slopes else 1
        own = {name: np.repeat([values[name] for values in points], lanes) for name in self.own}
        one = tangents.directions if slopes and self.own else np.zeros((len(tangents.values), 1))
        pars = tangents.parameters(np.tile(one, k), own)
        clock = np.stack([v.get(CLOCK, 1.0) * t + v.get(OFFSET, 0.0) for v in points], axis=1)
        times = np.repeat(clock, lanes, axis=1)
        read = tangents.read(int(slopes), pars, times, self.names)
        jets = {}
        for name in self.names:
            parts = [read[name][0][:, ::lanes]]
            if slopes:
                along = read[name][1].reshape(len(t), k, lanes)
                by = {
                    free: along[:, :, i] / tangents.scale(free) for i, free in enumerate(self.own)
                }
                rate = read[name][-1][:, ::lanes]
                by |= {OFFSET: rate, CLOCK: rate * t[:, None]}
                parts += [by[free] for free in self.free]
            jets[name] = np.stack([part.T.ravel() for part in parts], axis=1)
        return jets

    def _residual(
        self, group: str, seen: np.ndarray, jets: Arrays
    ) -> tuple[np.ndarray, np.ndarray]:
        if group == "orientation":
            axes, turn = self._axes(jets)
            return residuals.of_orientation(seen, axes), turn
        jet = self._model(group, jets)
        model = jet[..., 0]
        moves = jet[..., 1:]
        if group == "axis":
            return residuals.of_axis(seen, model, moves)
        off = seen - model
        if group == "phi" or CAMERA.fullmatch(group):
            off = np.remainder(off + np.pi, 2 * np.pi) - np.pi
        return off, moves

    def _model(self, group: str, jets: Arrays) -> np.ndarray:
        """Return the predictions of a group and their derivatives, (rows, parts, 1 + free)."""
        sizes = {"place": self.metre, "marker": self.metre, "omega3": 1 / self.second}
        model = np.stack([jets[name] for name in _names(group)], axis=1) * sizes.get(group, 1.0)
        if CAMERA.fullmatch(group):
            x, y = np.moveaxis(picture(group) @ model, 1, 0)
            lean = (y[:, :1] * x - x[:, :1] * y) / (x**2 + y**2)[:, :1]
            lean[:, 0] = np.arctan2(x[:, 0], y[:, 0])
            return lean[:, None]
        if group in IN_BODY:
            model = self._in_body_axes(group, model)
        if group == "omega":
            model = self._turned(model, jets)
        if group == "marker":
            arm = np.zeros(model.shape[1:])
            arm[:, 0] = self.marker
            model += self._turned(arm, jets)
        return model

    def _in_body_axes(self, group: str, chip: np.ndarray) -> np.ndarray:
        """Return the reading of a gyroscope or an accelerometer; `chip`: jets of CHIP."""
        chip = chip * self.metre ** np.repeat([0, 0, 1], 3)[:, None]
        chip = chip / self.second ** np.repeat([1, 2, 2], 3)[:, None]
        spin, turning, force = np.split(chip, 3, axis=1)
        if group != "accelerometer":
            return spin
        w = spin[..., :1]
        swing = np.cross(w, np.cross(spin, self.chip, axis=1), axis=1)
        swing[..., 1:] += np.cross(spin[..., 1:], np.cross(w, self.chip, axis=1), axis=1)
        return force + np.cross(turning, self.chip, axis=1) + swing

    def _turned(self, v: np.ndarray, jets: Arrays) -> np.ndarray:
        """Return jets of a vector in space, of those in body axes."""
        axes, turn = self._axes(jets)
        found = axes @ v
        found[..., 1:] += np.cross(turn, found[..., :1], axis=1)
        return found

    def _axes(self, jets: Arrays) -> tuple[np.ndarray, np.ndarray]:
        """Return the axes of the body (rows, space, axes), and their rotation vectors."""
        first, third = (
            np.stack([jets[name] for name in names], axis=1) for names in (AXES[:3], AXES[3:])
        )
        a = first[..., 0]
        c = third[..., 0]
        axes = np.stack([a, np.cross(c, a), c], axis=2)
        return axes, residuals.turning(a, c, first[..., 1:], third[..., 1:])


def _groups(problem: Problem, seen: Motion) -> Arrays:
    """Return the measurements by kind, (rows, parts), each quantity once."""
    groups: Arrays = {}
    attitudes = {"theta": seen.theta}
    if "axis" in problem.system.vectors:
        attitudes = {"orientation": seen.orientation, "axis": seen.axis} | attitudes
        attitudes["phi"] = seen.phi
    spins = {"gyroscope": seen.gyroscope, "omega": seen.omega}
    if "omega3" in problem.system.angles._fields and seen.omega3 is not None:
        own = np.nan if seen.gyroscope is None else seen.gyroscope[:, 2]
        spins["omega3"] = np.where(np.isfinite(own), np.nan, seen.omega3)
    for kinds in (attitudes, spins):
        left = np.ones(len(seen.t), bool)
        for kind, values in kinds.items():  # the first that a row has contains the others
            if values is not None:
                rows = np.where(left[:, None], values.reshape(len(left), -1), np.nan)
                full = np.isfinite(rows).all(axis=1)
                left &= ~full
                if kinds is attitudes:  # an axis needs both angles
                    rows[~full] = np.nan
                if np.isfinite(rows).any():
                    groups[kind] = rows
    groups |= {name: rows[:, None] for name, rows in seen.leans.items()}
    flat = {"x", "y"} <= set(problem.system.angles._fields)
    if flat and seen.place is not None and np.isfinite(seen.place[:, :2]).any():
        groups["place"] = seen.place[:, :2]
    for kind in ("accelerometer", "marker"):
        if (values := getattr(seen, kind)) is not None:
            groups[kind] = values
    return groups


def _names(group: str) -> tuple[str, ...]:
    """Return the readings of a motion for a kind of measurement."""
    return AXIS if CAMERA.fullmatch(group) else NAMES.get(group, (group,))
