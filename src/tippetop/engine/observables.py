"""Integrated states become named columns: Euler angles, quantities and their drift, in SI units."""

import contextlib
from typing import Any

import numpy as np

from ..columns import Column, column
from ..mechanics.moment import Moment, moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import Form, System
from ..mechanics.units import ONE, RADIAN, SECOND, Unit
from ..problem import ORIENTATION, PSI, TURN, Problem, Problems
from .expressions import (
    compile_observables,
    compile_orientation,
    component,
    near_poles,
    observed,
    orientation_of,
)
from .orientation import quaternion


class Observables:
    """Reads rows of internal states (n, variables) of a problem; computes in internal units,
    answers in SI.
    """

    def __init__(self, problem: Problem):
        self.problem, self.form, self.system = problem, problem.form, problem.system
        self._wide = np.float64 if problem.precision == "double" else np.longdouble
        body = problem.internal_body
        self.body = refill(
            body, (_widened(np.array(leaf), self._wide)[()] for leaf in leaves(body))
        )
        self._pars = np.array(leaves(self.body), dtype=float)[:, None]
        self._last: tuple[bytes, dict[str, np.ndarray]] = (
            b"",
            {},
        )  # the row that was read last, and its values

    def __reduce__(self) -> tuple:
        """Pickle the problem alone: formulas of a form have no names."""
        return Observables, (self.problem,)

    def state(self, rows: np.ndarray) -> tuple[Any, Any]:
        """The state record of the rows and the record of their integrals, in internal units."""
        return self.problem.variables.split(_widened(np.asarray(rows), self._wide).T)

    def moment(self, rows: np.ndarray) -> Moment:
        """Return what formulas read of the rows, or of one row, in internal units."""
        return moment(self.system, self.form, *self.state(rows), self.body)

    def evaluate(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """All that the rows say, by name, in internal units; NaN where an angle is undefined,
        exactly at a pole. Not to be changed: a single row, the start or the end of a run, is read
        several times, and kept.
        """
        if len(rows) != 1:
            return self._evaluated(rows)
        row = np.asarray(rows).tobytes()
        last = self._last  # at once: another thread may read rows too
        if row != last[0]:
            self._last = last = row, self._evaluated(rows)
        return dict(last[1])

    def _evaluated(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        if self._wide is np.float64:
            return _values(self.problem, self.problem.orientation, rows.T, self._pars)
        with np.errstate(invalid="ignore", divide="ignore"):
            q, carried = self.state(rows)
            by_name = observed(self.system, self.form, q, carried, self.body)
            polar = np.array(
                near_poles(self.form, q, self.body) if self.system.undefined_at_poles else []
            )
        values = {
            name: np.broadcast_to(value, (len(rows),)).copy() for name, value in by_name.items()
        }
        return _at_poles(self.system, values, polar)

    def orientation(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """The unit quaternions (n, 4) that turn body axes into space axes, and psi (n,) [rad], NaN
        exactly at a pole; None where the motion is planar. Only of a problem with orientation.
        """
        if self._wide is np.float64:
            return _orientation(self.problem, rows.T, self._pars)
        with np.errstate(invalid="ignore", divide="ignore"):
            axes = orientation_of(self.form, *self.state(rows), self.body)
        return _turned(
            self.form, np.array([np.broadcast_to(value, (len(rows),)) for value in axes])
        )

    def theta(self, row: np.ndarray) -> float:
        """theta of one row, (1, variables) [rad]."""
        return float(self.evaluate(row)["theta"][0])

    def domains(self, rows: np.ndarray) -> dict[str, float]:
        """Smallest value of each function that must stay positive, by its meaning."""
        state = self.moment(rows)
        return {h.meaning: float(np.min(h.formula(state, self.body))) for h in self.form.domains}

    def columns(self, times: np.ndarray, rows: np.ndarray) -> dict[str, Column]:
        """The rows as columns of the store's group `trajectory`, SI; times [s] as they were asked
        for.
        """
        names, values, kept = (
            self.system.long_names,
            self.evaluate(rows),
            set(self.problem.kept_columns),
        )

        def scale(unit: Unit) -> Any:
            return _widened(np.array(self.problem.scales.of(unit)), self._wide)

        columns = {"time": column(times, SECOND, "time")}
        for name, unit in self.system.angles._asdict().items():
            if name not in kept:
                continue
            columns |= self._split(name, values[name] * scale(unit), unit, names[name])
        for name, variables in self.system.vectors.items():
            if name not in kept:
                continue
            unit = getattr(self.system.forms["vector"].units, variables[0])
            stacked = np.stack([values[component(v)] for v in variables], axis=1) * scale(unit)
            columns |= self._split(name, stacked, unit, names[name], ("time", "xyz"))
        if self.problem.orientation and self.form.orientation and not kept.isdisjoint(TURN):
            turns, psi = self.orientation(rows)
            if psi is not None and "psi" in kept:
                columns |= self._split("psi", psi, RADIAN, PSI)
            if "orientation" in kept:
                columns |= self._split("orientation", turns, ONE, ORIENTATION, ("time", "wxyz"))
        for q in self.system.quantities:
            if q.name not in kept:
                continue
            if q.meanings:
                flags = {
                    "flag_values": list(range(len(q.meanings))),
                    "flag_meanings": " ".join(q.meanings),
                }
                attributes = {"units": "1", "long_name": q.long_name, **flags}
                columns[q.name] = Column(
                    ("time",), np.rint(values[q.name]).astype(np.int8), attributes
                )
                continue
            si = values[q.name] * scale(q.unit)
            columns |= self._split(q.name, si, q.unit, q.long_name, symbol=q.symbol)
        if (
            self.problem.precision == "quad"
        ):  # the quantities are computed in 80 bits: the state itself goes in whole
            units = self.problem.variables.units.items()
            for (name, unit), variable, weight in zip(
                units, rows.T, self.problem.weights(), strict=True
            ):
                if f"state_{name}" not in kept:
                    continue
                columns |= self._split(
                    f"state_{name}",
                    variable * np.array([weight]),
                    unit,
                    f"integrated variable {name}",
                )
        return columns

    def _split(
        self, name: str, values: np.ndarray, unit: Unit, long_name: str, *dims: Any, **extra: Any
    ) -> dict:
        """A column of doubles; in wider precisions a second one, `name_lo`, to be added to it."""
        high = values.astype(np.float64)
        columns = {name: column(high, unit, long_name, *dims, **extra)}
        if self.problem.precision != "double":
            low = (values - high).astype(np.float64)
            columns[f"{name}_lo"] = column(low, unit, f"{long_name}: low part, to be added", *dims)
        return columns


def values_of(problems: Problems, states: np.ndarray, which: np.ndarray) -> dict[str, np.ndarray]:
    """All that states (variables, k) of the runs `which` (k,) say, by name, in internal units; (k,)
    each, doubles.

    Parameters
    ----------
    problems
        The runs.
    states
        (variables, k), internal units.
    which
        Numbers of the runs, (k,).

    Returns
    -------
    dict
        Quantities and angles by name, (k,) each.
    """
    return _values(problems.base, problems.orientation, states, problems.pars[:, which])


def _values(
    base: Problem, orientation: bool, states: np.ndarray, pars: np.ndarray
) -> dict[str, np.ndarray]:
    names, function = compile_observables(
        base.system, base.form.name, base.friction.__class__, orientation
    )
    outputs = _outputs(function, states, pars)
    return _at_poles(base.system, dict(zip(names, outputs, strict=False)), outputs[len(names) :])


def _at_poles(
    system: System, values: dict[str, np.ndarray], polar: np.ndarray
) -> dict[str, np.ndarray]:
    """Return values as they are exactly at a pole: it is left at full speed, along no azimuth."""
    if len(polar) and (pole := polar[0] == 0).any():
        values["theta_dot"][pole] = np.sqrt(polar[1][pole])
        for name in system.undefined_at_poles:
            values[name][pole] = np.nan
    return values


def orientations_of(
    problems: Problems, states: np.ndarray, which: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """The orientation in states (variables, k) of the runs `which` (k,), as
    `Observables.orientation` has it.

    Parameters
    ----------
    problems
        The runs, with orientation.
    states
        (variables, k), internal units.
    which
        Numbers of the runs, (k,).

    Returns
    -------
    quaternions
        (k, 4): w, x, y, z, w >= 0.
    psi
        (k,) [rad], NaN exactly at a pole; None of a planar motion.
    """
    return _orientation(problems.base, states, problems.pars[:, which])


def _orientation(
    base: Problem, states: np.ndarray, pars: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    function = compile_orientation(base.system, base.form.name, base.friction.__class__)
    return _turned(base.form, _outputs(function, states, pars))


# states that are evaluated at a time: from some 300 on, heyoka shares them among threads unasked
BLOCK = 128


def _outputs(function: Any, states: np.ndarray, pars: np.ndarray) -> np.ndarray:
    """Return the outputs of a compiled function, (outputs, n), of states (variables, n) of bodies
    (leaves, n or 1).
    """
    outputs, numbers = [], pars[: function.nparams]
    for first in range(0, states.shape[1] or 1, BLOCK):
        block = states[:, first : first + BLOCK]
        inputs = _whole_batches(block, function.batch_size)
        if pars.shape[1] == 1:
            bodies = np.repeat(numbers, inputs.shape[1], axis=1)
        else:
            bodies = _whole_batches(numbers[:, first : first + BLOCK], function.batch_size)
        outputs.append(function(inputs, pars=bodies)[:, : block.shape[1]])
    return np.concatenate(outputs, axis=1)


def _whole_batches(columns: np.ndarray, size: int) -> np.ndarray:
    """Return columns (rows, k), of which the last is repeated to fill whole SIMD batches: so the
    bits of a column do not depend on its neighbours.
    """
    n = columns.shape[1]
    whole = np.empty((columns.shape[0], n + -n % size))
    whole[:, :n], whole[:, n:] = columns, columns[:, -1:]
    return whole


def _turned(form: Form, values: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return quaternions (n, 4), and psi (n,) if the form has it, of outputs of `orientation_of`,
    (6 or 7, n).
    """
    assert form.orientation is not None
    if form.orientation.psi:
        values[6, (values[3] == 0) & (values[4] == 0)] = np.nan
    return quaternion(values[:3], values[3:6]), values[6] if form.orientation.psi else None


def _widened(values: np.ndarray, number: Any) -> np.ndarray:
    """Any precision as `number`; quadruple in two halves, since numpy knows no direct way to 80
    bits.
    """
    high = values.astype(np.float64)
    if number is np.float64 or values.dtype == number:
        return values.astype(number)
    return high.astype(number) + (values - high).astype(np.float64).astype(number)


def event_functions(problems: Problems) -> np.ndarray:
    """Return the event functions of every run at its start, (n, events), internal units."""
    start, pars = problems.start.astype(float), problems.pars.astype(float)
    if (
        problems.n == 1
    ):  # numbers take a fifth of the time of arrays, but raise where those have infinities
        with contextlib.suppress(ArithmeticError, ValueError):
            return _event_functions(problems, start[:, 0].tolist(), pars[:, 0].tolist())
    return _event_functions(problems, start, pars)


def _event_functions(problems: Problems, start: Any, pars: Any) -> np.ndarray:
    body = problems.body_of_pars(pars)
    moment = problems.moment(start, body)
    functions = np.empty((problems.n, len(problems.base.system.events)))
    for e, event in enumerate(problems.base.system.events):
        functions[:, e] = (
            1.0 if event.formula is None else np.asarray(event.formula(moment, body), float)
        )
    return functions
