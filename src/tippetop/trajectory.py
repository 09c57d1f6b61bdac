"""What integrated states mean: Euler angles, quantities and their drift, in SI units, as named columns."""

from typing import Any, NamedTuple

import numpy as np

from .events import KINDS, EventTable
from .problem import QUADRATURE_SCALE, Problem
from .system import RADIAN, SECOND, Quantity, Unit


class Column(NamedTuple):
    """An array with the names of its dimensions and its attributes (units, long_name, ...), as the store keeps it."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, Any]


class View:
    """Reads rows of internal states (n, variables) of a problem; computes in internal units, answers in SI."""

    def __init__(self, problem: Problem):
        self.problem, self.form, self.system = problem, problem.form, problem.system
        self._state = type(self.form.units)
        self._wide = np.float64 if problem.precision == "double" else np.longdouble
        body = problem.internal_body
        self.body = _cast(body, lambda leaf: _widened(np.array(leaf), self._wide)[()])
        self.quantities = {quantity.name: quantity for quantity in self.system.quantities}

    def record(self, rows: np.ndarray) -> Any:
        """The state record of the rows, in internal units."""
        columns = _widened(np.asarray(rows), self._wide).T
        names = self.form.units._fields
        return self._state(
            *(c / QUADRATURE_SCALE if n in self.form.quadratures else c for n, c in zip(names, columns, strict=True))
        )

    def scalars(self, rows: np.ndarray) -> Any:
        """The scalars of the rows, in internal units."""
        return self.form.scalars(self.record(rows), self.body)

    def angles(self, rows: np.ndarray) -> Any:
        """The Euler record of the rows, in internal units; NaN where an angle is undefined, exactly at a pole."""
        with np.errstate(invalid="ignore", divide="ignore"):
            euler = self.form.to_angles(self.record(rows), self.body)
        scalars = self.scalars(rows)
        if not hasattr(scalars, "axis_speed2"):
            return euler
        pole = scalars.s2 == 0  # the axis leaves a pole at its full speed, along no particular azimuth
        euler = euler._replace(theta_dot=np.where(pole, np.sqrt(scalars.axis_speed2), euler.theta_dot))
        undefined = {n: np.where(pole, np.nan, getattr(euler, n)) for n in POLAR if hasattr(euler, n)}
        return euler._replace(**undefined)

    def internal(self, name: str, scalars: Any) -> np.ndarray:
        """A quantity in internal units, one value per row."""
        return np.broadcast_to(self.quantities[name].formula(scalars, self.body), scalars.z.shape)

    def hazards(self, rows: np.ndarray) -> dict[str, float]:
        """Smallest value of each function that must stay positive, by its meaning."""
        scalars = self.scalars(rows)
        return {h.meaning: float(np.min(h.formula(scalars, self.body))) for h in self.form.hazards}

    def columns(self, times: np.ndarray, rows: np.ndarray) -> dict[str, Column]:
        """The rows as columns of the store's group `trajectory`, SI; times [s] as they were asked for."""
        scales, names = self.problem.scales, self.system.long_names
        scalars, euler = self.scalars(rows), self.angles(rows)
        columns = {"time": _column(times, SECOND, "time")}
        for name, unit in self.system.angles._asdict().items():
            columns[name] = _column(getattr(euler, name) * _float(scales.of(unit)), unit, names[name])
        vectors = self._vectors(rows, euler)
        for name, variables in self.system.vectors.items():
            unit = getattr(self.system.forms["vector"].units, variables[0])
            stacked = np.stack([getattr(vectors, v) for v in variables], axis=1) * _float(scales.of(unit))
            columns[name] = _column(stacked, unit, names[name], ("time", "xyz"))
        for q in self.system.quantities:
            values = self.internal(q.name, scalars) * _float(scales.of(q.unit))
            columns[q.name] = _column(values, q.unit, q.long_name, symbol=q.symbol)
        return columns

    def quantity(self, name: str) -> Quantity:
        """The record of a quantity of this system."""
        return self.quantities[name]

    def _vectors(self, rows: np.ndarray, euler: Any) -> Any:
        record = self.record(rows)
        if self.form.name == "vector" or not self.system.vectors:
            return record
        vector = self.system.forms["vector"]
        return vector.of_angles(euler, np.sin(euler.theta), np.cos(euler.theta), self.body)


POLAR = ("phi", "phi_dot", "nu_x", "nu_y")
"""What is undefined exactly at a pole."""


def event_columns(table: EventTable) -> dict[str, Column]:
    """The event log as columns of the store's group `events`."""
    flags = {"flag_values": list(range(len(KINDS))), "flag_meanings": " ".join(KINDS)}
    about: dict[str, dict[str, Any]] = {
        "kind": {"long_name": "kind of event", **flags},
        "theta_dot_sign": {"long_name": "sign of theta' just after: +1 at a minimum of theta, -1 at a maximum"},
        "significant": {"long_name": "false where rounding could have made the event"},
    }
    measured = {
        "time": (SECOND, "time of the event"),
        "theta": (RADIAN, "theta at the event"),
        "amplitude": (RADIAN, "swing of theta since the turning before (or the start); NaN unless a turning"),
    }
    return {
        name: _column(values, *measured[name], ("event",))
        if name in measured
        else Column(("event",), values, {"units": "1", **about[name]})
        for name, values in table._asdict().items()
    }


def _column(values: np.ndarray, unit: Unit, long_name: str, dims: tuple[str, ...] = ("time",), **extra: str) -> Column:
    return Column(dims, np.asarray(values, dtype=np.float64), {"units": unit.symbol, "long_name": long_name, **extra})


def _float(value: Any) -> float:
    return float(value)


def _widened(values: np.ndarray, number: Any) -> np.ndarray:
    """Any precision as `number`; quadruple in two halves, since numpy knows no direct way to 80 bits."""
    high = values.astype(np.float64)
    if number is np.float64 or values.dtype == number:
        return values.astype(number)
    return high.astype(number) + (values - high).astype(np.float64).astype(number)


def _cast(record: Any, number: Any) -> Any:
    return type(record)(*(_cast(f, number) if isinstance(f, tuple) else number(f) for f in record))
