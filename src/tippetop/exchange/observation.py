"""What a scenario predicts for a table of measurements, and how that moves with the numbers that are free."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..engine.derivatives.numbers import Numbers
from ..engine.expressions import component
from ..engine.tangent import Tangents
from ..errors import InputError, suggestion
from ..mechanics import rotation
from ..mechanics.parameter import Parameter
from ..mechanics.rotation import Quaternion
from ..mechanics.units import METRE, ONE, SECOND
from ..problem import Problem
from .motion import Motion


OFFSET, CLOCK = "time.offset", "time.scale"
TIMES = {
    OFFSET: Parameter(SECOND, "time of the motion where the table's clock shows 0"),
    CLOCK: Parameter(ONE, "seconds of the motion per second of the table's clock", above=0),
}
"""Numbers of the clock of a table: the motion's time is scale t + offset."""
TOLERANCE = 1e-11  # of the integrator: data are never better
MOST_STEPS = 25.0  # per internal unit of time: a canonical inversion takes 9
CENTRE = ("x", "y", "height")
AXES = tuple(f"{axis}_{c}" for axis in ("first", "third") for c in "xyz")


class Observation:
    """Measurements beside what the numbers of a problem predict.

    Parameters
    ----------
    problem
        The scenario: what is not free is as it stands there.
    free
        Dotted names of what is free, `time.offset` and `time.scale` among them.
    seen
        The motion that was measured.
    marker
        Where the marker is on the body, body axes, from the centre of mass [m], (3,); with columns `marker_`.
    places
        Where the marker was, space frame, (rows, 3).

    Attributes
    ----------
    groups
        Name of each kind of measurement -> (rows, parts) of what was measured; NaN in gaps.
    """

    def __init__(
        self,
        problem: Problem,
        free: Sequence[str],
        seen: Motion,
        marker: np.ndarray | None = None,
        places: np.ndarray | None = None,
    ):
        self.free, self.t = tuple(free), seen.t
        faults = [
            f"`{name}` must be {' or '.join(TIMES)}, but is not.{suggestion(name, TIMES)}"
            for name in free
            if name.startswith("time.") and name not in TIMES
        ]
        if faults:
            raise InputError(faults)
        self.own = tuple(name for name in free if name not in TIMES)
        self.numbers = Numbers(problem, self.own)
        self.second = float(problem.scales.of(SECOND))
        self.marker, self.places = marker, places
        self.metre = float(problem.scales.of(METRE))
        self.groups = _groups(problem, seen, places)
        if not self.groups:
            raise InputError(["the table must have theta, an axis, a quaternion, omega3, a place or a marker."])
        turning = bool({"orientation", "marker"} & self.groups.keys())
        self.tangents = Tangents(self.numbers.kind(1, orientation=turning), TOLERANCE, MOST_STEPS)
        self.names = self._names()
        self.ways = self.numbers.directions(self.own)

    def _names(self) -> tuple[str, ...]:
        """What is read of states."""
        reads = {
            "theta": ("theta",),
            "phi": ("phi",),
            "axis": tuple(component(f"u{c}") for c in "xyz"),
            "omega3": ("omega3",),
            "place": ("x", "y"),
            "orientation": AXES,
            "marker": (*AXES, *CENTRE),
        }
        return tuple(dict.fromkeys(name for group in self.groups for name in reads[group]))

    def rule(self, name: str) -> Parameter:
        """Unit and interval of a number that is free."""
        return TIMES.get(name) or self.numbers.rule(name)

    def start(self) -> dict[str, float]:
        """The values of the free numbers in the scenario."""
        return {name: {OFFSET: 0.0, CLOCK: 1.0}.get(name, self.numbers.values.get(name, 0.0)) for name in self.free}

    def predicted(
        self, values: dict[str, float], rows: slice = slice(None)
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """For each group: what was measured less what is predicted, (rows, parts), and how the prediction moves with
        each free number, (rows, parts, free), SI. NaN where nothing was measured, or the motion cannot be computed."""
        t = self.t[rows]
        scale, offset = values.get(CLOCK, 1.0), values.get(OFFSET, 0.0)
        clock = (scale * t + offset) / self.second
        own = {name: value for name, value in values.items() if name not in TIMES}
        lanes = max(1, len(self.own))
        point = np.repeat(self.numbers.internal(own)[:, None], lanes, axis=1)
        ways = self.ways if len(self.own) else np.zeros_like(point)
        timed = self.names if len(self.own) < len(self.free) else ()
        needs = self.tangents.needs(self.names, timed)
        states = self.tangents.states(point, ways, clock, needs)
        read, rates = self.tangents.read(point, ways, states, self.names, timed)
        value = {name: read[name][0][:, 0] for name in self.names}
        slope = {name: self._slopes(name, read, rates, t) for name in self.names}
        return {group: self._residual(group, seen[rows], value, slope) for group, seen in self.groups.items()}

    def residuals(self, points: Sequence[dict[str, float]], rows: int) -> list[dict[str, np.ndarray]]:
        """For each set of values: what was measured less what is predicted, by group, of the first rows; many in lanes,
        without derivatives."""
        own = [{name: v for name, v in values.items() if name not in TIMES} for values in points]
        columns = np.stack([self.numbers.internal(values) for values in own], axis=1)
        t = self.t[:rows]
        clock = np.stack([v.get(CLOCK, 1.0) * t + v.get(OFFSET, 0.0) for v in points], axis=1) / self.second
        ways = np.zeros_like(columns)
        states = self.tangents.states(columns, ways, clock, self.tangents.needs(self.names, ()))
        read, _ = self.tangents.read(columns, ways, states, self.names, ())
        none = {name: np.zeros((len(t), 1)) for name in self.names}
        return [
            {
                group: self._residual(group, seen[:rows], {n: read[n][0][:, k] for n in self.names}, none)[0]
                for group, seen in self.groups.items()
            }
            for k in range(len(points))
        ]

    def _slopes(self, name: str, read: Any, rates: Any, t: np.ndarray) -> np.ndarray:
        """Of a reading, by each free number in its SI unit, (rows, free); the reading in internal units."""
        by, lane = [], 0
        for free in self.free:
            if free == OFFSET:
                by.append(rates[name][:, 0] / self.second)
            elif free == CLOCK:
                by.append(rates[name][:, 0] * t / self.second)
            else:
                by.append(read[name][1][:, lane] / self.numbers.scale(free))
                lane += 1
        return np.stack(by, axis=1)

    def _residual(
        self, group: str, seen: np.ndarray, value: dict[str, np.ndarray], slope: dict[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        if group in ("orientation", "marker"):
            first, third = (np.stack([value[f"{a}_{c}"] for c in "xyz"], axis=1) for a in ("first", "third"))
            moved = [np.stack([slope[f"{a}_{c}"] for c in "xyz"], axis=1) for a in ("first", "third")]
            axes = np.stack([first, np.cross(third, first), third], axis=2)  # (rows, space, axes)
            turn = _turn(first, third, *moved)
            if group == "orientation":
                return _rotation_between(seen, axes), turn
            arm = axes @ self.marker
            place = np.stack([value[name] for name in CENTRE], axis=1) * self.metre
            own = np.stack([slope[name] for name in CENTRE], axis=1) * self.metre
            swung = np.cross(turn, arm[:, :, None], axis=1)
            return seen - place - arm, own + swung
        names = {"place": ("x", "y"), "axis": tuple(component(f"u{c}") for c in "xyz")}.get(group, (group,))
        size = self.metre if group == "place" else 1 / self.second if group == "omega3" else 1.0
        model = np.stack([value[name] for name in names], axis=1) * size
        moves = np.stack([slope[name] for name in names], axis=1) * size
        off = seen - model
        return (np.remainder(off + np.pi, 2 * np.pi) - np.pi if group == "phi" else off), moves


def _groups(problem: Problem, seen: Motion, places: np.ndarray | None) -> dict[str, np.ndarray]:
    """What was measured, by kind, (rows, parts); what says the same in another way is taken once."""
    groups: dict[str, np.ndarray] = {}
    top = "axis" in problem.system.vectors
    if seen.orientation is not None and top:
        groups["orientation"] = seen.orientation
    elif seen.axis is not None and top:
        groups["axis"] = seen.axis
    elif seen.theta is not None:
        groups["theta"] = seen.theta[:, None]
    if seen.omega3 is not None and "omega3" in problem.system.angles._fields:
        groups["omega3"] = seen.omega3[:, None]
    flat = {"x", "y"} <= set(problem.system.angles._fields)
    if flat and seen.place is not None and np.isfinite(seen.place[:, :2]).any():
        groups["place"] = seen.place[:, :2]
    if places is not None:
        groups["marker"] = places
    return groups


def _turn(first: np.ndarray, third: np.ndarray, first_moves: np.ndarray, third_moves: np.ndarray) -> np.ndarray:
    """The rotation vector by which the body turns per unit of each free number, (rows, 3, free)."""
    second = np.cross(third, first)
    free = range(first_moves.shape[2])
    turns = []
    for k in free:
        a, c = first_moves[:, :, k], third_moves[:, :, k]
        b = np.cross(c, first) + np.cross(third, a)
        turns.append((np.cross(first, a) + np.cross(second, b) + np.cross(third, c)) / 2)
    return np.stack(turns, axis=2)


def _rotation_between(seen: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """The rotation vector from predicted axes (rows, 3, 3) to measured quaternions (rows, 4), (rows, 3)."""
    there = np.array(rotation.axes(Quaternion(*seen.T)))  # (axes, space, rows)
    between = there.transpose(2, 1, 0) @ axes.transpose(0, 2, 1)
    sine = (
        np.stack(
            [
                between[:, 2, 1] - between[:, 1, 2],
                between[:, 0, 2] - between[:, 2, 0],
                between[:, 1, 0] - between[:, 0, 1],
            ],
            axis=1,
        )
        / 2
    )
    size = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(size, (np.trace(between, axis1=1, axis2=2) - 1) / 2)
    return sine * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 1.0)[:, None]
