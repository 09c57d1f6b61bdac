"""What integrated states mean: Euler angles, quantities and their drift, in SI units, as named columns."""

from typing import Any

import numpy as np

from ..columns import Column, column
from ..mechanics.operand import leaves
from ..mechanics.units import SECOND, Unit
from ..problem import Problem, Problems
from .expressions import observed, table


class View:
    """Reads rows of internal states (n, variables) of a problem; computes in internal units, answers in SI."""

    def __init__(self, problem: Problem):
        self.problem, self.form, self.system = problem, problem.form, problem.system
        self._wide = np.float64 if problem.precision == "double" else np.longdouble
        body = problem.internal_body
        self.body = _cast(body, lambda leaf: _widened(np.array(leaf), self._wide)[()])
        self._pars = np.array(leaves(self.body), dtype=float)

    def record(self, rows: np.ndarray) -> Any:
        """The state record of the rows, in internal units."""
        return self.problem.record(_widened(np.asarray(rows), self._wide).T)

    def scalars(self, rows: np.ndarray) -> Any:
        """The scalars of the rows, in internal units."""
        return self.form.scalars(self.record(rows), self.body)

    def values(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """All that the rows say, by name, in internal units; NaN where an angle is undefined, exactly at a pole."""
        if self._wide is np.float64:
            values = self._compiled(np.asarray(rows, dtype=float))
        else:
            with np.errstate(invalid="ignore", divide="ignore"):
                found = observed(self.system, self.form, self.record(rows), self.body)
            values = {name: np.broadcast_to(value, (len(rows),)).copy() for name, value in found.items()}
        if "_s2" in values:
            pole = values.pop("_s2") == 0  # the axis leaves a pole at its full speed, along no particular azimuth
            leaving = np.sqrt(values.pop("_axis_speed2"))
            if pole.any():
                values["theta_dot"][pole] = leaving[pole]
                for name in POLAR & values.keys():
                    values[name][pole] = np.nan
        return values

    def _compiled(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        names, function = table(self.system, self.form.name, self.problem.friction.__class__)
        outputs = np.empty((len(names), len(rows)))
        for start in range(0, len(rows), BLOCK):
            part = rows[start : start + BLOCK].T
            # whole SIMD batches, the last column repeated: so a row's bits do not depend on its neighbours
            padded = np.pad(part, ((0, 0), (0, -part.shape[1] % function.batch_size)), mode="edge")
            block = np.ascontiguousarray(padded)
            pars = np.repeat(self._pars[: function.nparams, None], block.shape[1], axis=1)
            outputs[:, start : start + BLOCK] = function(block, pars=pars)[:, : part.shape[1]]
        return dict(zip(names, outputs, strict=True))

    def theta(self, row: np.ndarray) -> float:
        """theta of one row, (1, variables) [rad]."""
        return float(self.values(row)["theta"][0])

    def hazards(self, rows: np.ndarray) -> dict[str, float]:
        """Smallest value of each function that must stay positive, by its meaning."""
        scalars = self.scalars(rows)
        return {h.meaning: float(np.min(h.formula(scalars, self.body))) for h in self.form.hazards}

    def columns(self, times: np.ndarray, rows: np.ndarray) -> dict[str, Column]:
        """The rows as columns of the store's group `trajectory`, SI; times [s] as they were asked for."""
        names, values = self.system.long_names, self.values(rows)

        def scale(unit: Unit) -> Any:
            return _widened(np.array(self.problem.scales.of(unit)), self._wide)

        columns = {"time": column(times, SECOND, "time")}
        for name, unit in self.system.angles._asdict().items():
            columns |= self._split(name, values[name] * scale(unit), unit, names[name])
        for name, variables in self.system.vectors.items():
            unit = getattr(self.system.forms["vector"].units, variables[0])
            stacked = np.stack([values[v] for v in variables], axis=1) * scale(unit)
            columns |= self._split(name, stacked, unit, names[name], ("time", "xyz"))
        for q in self.system.quantities:
            si = values[q.name] * scale(q.unit)
            columns |= self._split(q.name, si, q.unit, q.long_name, symbol=q.symbol)
        if self.problem.precision == "quad":  # the quantities are computed in 80 bits: the state itself goes in whole
            for name, variable, weight in zip(
                self.form.units._fields, rows.T, self.problem.weights(self.form), strict=True
            ):
                unit = getattr(self.form.units, name)
                columns |= self._split(
                    f"state_{name}", variable * np.array([weight]), unit, f"integrated variable {name}"
                )
        return columns

    def _split(self, name: str, values: np.ndarray, unit: Unit, long_name: str, *dims: Any, **extra: Any) -> dict:
        """A column of doubles; in wider precisions a second one, `name_lo`, to be added to it."""
        high = values.astype(np.float64)
        columns = {name: column(high, unit, long_name, *dims, **extra)}
        if self.problem.precision != "double":
            low = (values - high).astype(np.float64)
            columns[f"{name}_lo"] = column(low, unit, f"{long_name}: low part, to be added", *dims)
        return columns


def values_of(problems: Problems, states: np.ndarray, which: np.ndarray) -> dict[str, np.ndarray]:
    """All that states (variables, k) of the runs `which` (k,) say, by name, in internal units; (k,) each, doubles.

    The last column is repeated to fill whole SIMD batches: so the bits of a column do not depend on its neighbours.
    """
    base, k = problems.base, states.shape[1]
    names, function = table(base.system, base.form.name, base.friction.__class__)
    fill = ((0, 0), (0, -k % function.batch_size))
    padded = np.ascontiguousarray(np.pad(states, fill, mode="edge"))
    pars = np.ascontiguousarray(np.pad(problems.pars[: function.nparams, which], fill, mode="edge"))
    return dict(zip(names, function(padded, pars=pars)[:, :k], strict=True))


BLOCK = 2048  # rows that are evaluated at a time: they stay in the second-level cache
POLAR = {"phi", "phi_dot", "nu_x", "nu_y"}
"""What is undefined exactly at a pole."""


def _widened(values: np.ndarray, number: Any) -> np.ndarray:
    """Any precision as `number`; quadruple in two halves, since numpy knows no direct way to 80 bits."""
    high = values.astype(np.float64)
    if number is np.float64 or values.dtype == number:
        return values.astype(number)
    return high.astype(number) + (values - high).astype(np.float64).astype(number)


def _cast(record: Any, number: Any) -> Any:
    return type(record)(*(_cast(f, number) if isinstance(f, tuple) else number(f) for f in record))
