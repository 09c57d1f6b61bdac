"""Integrated states become named columns: Euler angles, quantities and their drift, in SI units."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..columns import Column, column, flag_attributes
from ..mechanics.moment import Moment, moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.units import ONE, RADIAN, SECOND, Unit
from ..problem import ORIENTATION, PSI, TURN, Problem, Problems
from .expressions import (
    AXES,
    SINE2,
    SPEED2,
    compile_observables,
    component,
    observed,
    orientation_of,
)
from .orientation import quaternion


class Observables:
    """Values and columns of rows of internal states (n, variables) of a problem."""

    def __init__(self, problem: Problem):
        self.problem, self.form, self.system = problem, problem.form, problem.system
        self._wide = np.float64 if problem.precision == "double" else np.longdouble
        body = problem.internal_body
        self.body = refill(
            body, (_widened(np.array(leaf), self._wide)[()] for leaf in leaves(body))
        )

    def __reduce__(self) -> tuple:
        """Pickle the problem alone: formulas of a form have no names."""
        return Observables, (self.problem,)

    def state(self, rows: np.ndarray) -> tuple[Any, Any]:
        """Return the state record of the rows and the record of their integrals, internal units."""
        return self.problem.variables.split(_widened(np.asarray(rows), self._wide).T)

    def moment(self, rows: np.ndarray) -> Moment:
        """Return the arguments of formulas for the rows, or for one row, in internal units."""
        return moment(self.form, *self.state(rows), self.body)

    def evaluate(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return all values of the rows by name, internal units; NaN where an angle is undefined,
        exactly at a pole.
        """
        return _at_poles(self.system, self._computed(observed, rows))

    def _computed(self, formulas: Callable, rows: np.ndarray) -> dict[str, np.ndarray]:
        if self._wide is np.float64:
            return _computed(formulas, self.problem.alone, rows.T, ALONE)
        with np.errstate(invalid="ignore", divide="ignore"):
            values = formulas(self.system, self.form, *self.state(rows), self.body)
        return {name: np.broadcast_to(value, len(rows)).copy() for name, value in values.items()}

    def orientation(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return the unit quaternions that turn body axes into space axes, by QUATERNION, and `psi`
        [rad], NaN exactly at a pole, unless the motion is planar; (n,) each. Only of a problem with
        orientation.
        """
        return _turned(self._computed(orientation_of, rows))

    def theta(self, row: np.ndarray) -> float:
        """Return theta of one row, (1, variables) [rad]."""
        return float(self.evaluate(row)["theta"][0])

    def domains(self, rows: np.ndarray) -> dict[str, float]:
        """Return the least value of each function that must stay positive, by its meaning."""
        state = self.moment(rows)
        return {h.meaning: float(np.min(h.formula(state, self.body))) for h in self.form.domains}

    def columns(self, times: np.ndarray, rows: np.ndarray) -> dict[str, Column]:
        """Return the rows as columns of the store's group `trajectory`, SI; times [s] as they were
        asked for.
        """
        problem, values = self.problem, self.evaluate(rows)
        if not set(TURN).isdisjoint(problem.kept_columns):
            values |= self.orientation(rows)
        columns = {"time": column(times, SECOND, "time")}
        for name, source in sources(problem).items():
            if source.flags:
                flags = np.rint(values[name]).astype(np.int8)
                attributes = flag_attributes(source.flags, source.long_name)
                columns[name] = Column(("time",), flags, attributes)
                continue
            parts = [values[part] for part in source.parts]
            whole = np.stack(parts, axis=1) if source.dims else parts[0]
            scale = _widened(np.array(problem.scales.of(source.unit)), self._wide)
            columns |= self._split(name, whole * scale, source)
        if problem.precision == "quad":
            # the quantities are computed in 80 bits: the state itself goes in whole
            weights = problem.weights()
            for i, (name, unit) in enumerate(problem.variables.units.items()):
                if f"state_{name}" in problem.kept_columns:
                    source = Source((), unit, f"integrated variable {name}")
                    whole = rows.T[i] * np.array([weights[i]])
                    columns |= self._split(f"state_{name}", whole, source)
        return columns

    def _split(self, name: str, values: np.ndarray, source: "Source") -> dict[str, Column]:
        """Return a column of doubles; in wider precisions a second one, `name_lo`, to be added."""
        high, dims = values.astype(np.float64), ("time", *source.dims)
        symbol = {} if source.symbol is None else {"symbol": source.symbol}
        columns = {name: column(high, source.unit, source.long_name, dims, **symbol)}
        if self.problem.precision != "double":
            low = (values - high).astype(np.float64)
            long_name = f"{source.long_name}: low part, to be added"
            columns[f"{name}_lo"] = column(low, source.unit, long_name, dims)
        return columns


class Source(NamedTuple):
    """The source of a column of a run.

    Parameters
    ----------
    parts
        Names of the values that it consists of.
    unit, long_name
        Of the column.
    dims
        Its dimensions beyond the time.
    symbol
        Its symbol in TeX; None: it has none.
    flags
        Meanings of its numbers, where these are flags.
    """

    parts: tuple[str, ...]
    unit: Unit
    long_name: str
    dims: tuple[str, ...] = ()
    symbol: str | None = None
    flags: tuple[str, ...] = ()


QUATERNION = tuple(f"orientation_{part}" for part in "wxyz")
"""Names of the parts of the orientation among the values of a row."""


def sources(problem: Problem) -> dict[str, Source]:
    """Return the sources of the columns of a run by name, apart from the time and the low parts."""
    system, names = problem.system, problem.system.long_names
    found = {
        name: Source((name,), unit, names[name]) for name, unit in system.angles._asdict().items()
    }
    for name, variables in system.vectors.items():
        unit = getattr(system.forms["vector"].units, variables[0])
        found[name] = Source(tuple(map(component, variables)), unit, names[name], ("xyz",))
    found["psi"] = Source(("psi",), RADIAN, PSI)
    found["orientation"] = Source(QUATERNION, ONE, ORIENTATION, ("wxyz",))
    found |= {
        q.name: Source((q.name,), q.unit, q.long_name, (), q.symbol, tuple(q.meanings))
        for q in system.quantities
    }
    return {name: found[name] for name in found if name in problem.kept_columns}


def values_of(problems: Problems, states: np.ndarray, which: np.ndarray) -> dict[str, np.ndarray]:
    """Return all values of states (variables, k) of the runs `which` (k,) by name, in internal
    units; (k,) each, doubles.

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
    return _at_poles(problems.base.system, _computed(observed, problems, states, which))


def _at_poles(system: System, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return values as they are exactly at a pole: it is left at full speed, along no azimuth."""
    sine2, speed2 = values.pop(SINE2, None), values.pop(SPEED2, None)
    if sine2 is not None and speed2 is not None and (pole := sine2 == 0).any():
        values["theta_dot"][pole] = np.sqrt(speed2[pole])
        for name in system.undefined_at_poles:
            values[name][pole] = np.nan
    return values


def orientations_of(
    problems: Problems, states: np.ndarray, which: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the orientation in states (variables, k) of the runs `which` (k,), as
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
    dict
        (k,) each, by name.
    """
    return _turned(_computed(orientation_of, problems, states, which))


# states that are evaluated at a time: from some 300 on, heyoka shares them among threads unasked
BLOCK = 128
ALONE = np.zeros(1, int)
"""The number of a run that is alone."""


def _computed(
    formulas: Callable, problems: Problems, states: np.ndarray, which: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the values of formulas by name, doubles, by their compiled function."""
    base = problems.base
    names, function = compile_observables(
        formulas, base.system, base.form.name, base.friction.__class__, problems.orientation
    )
    pars, outputs = problems.pars[: function.nparams, which], []
    for first in range(0, states.shape[1] or 1, BLOCK):
        some = states[:, first : first + BLOCK]
        bodies = pars if len(which) == 1 else pars[:, first : first + BLOCK]
        k = some.shape[1]
        n = k + -k % function.batch_size  # whole batches: neighbours change no bit of a column
        outputs.append(function(_repeated(some, n), pars=_repeated(bodies, n))[:, :k])
    return dict(zip(names, np.concatenate(outputs, axis=1), strict=True))


def _repeated(columns: np.ndarray, n: int) -> np.ndarray:
    """Return columns (rows, k) and the last one again, up to n."""
    k = columns.shape[1]
    whole = np.empty((len(columns), n))
    whole[:, :k], whole[:, k:] = columns, columns[:, -1:]
    return whole


def _turned(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return quaternions, and psi if the form has it, of values of `orientation_of`."""
    first, third = (np.array([values.pop(name) for name in axis]) for axis in (AXES[:3], AXES[3:]))
    if "psi" in values:
        values["psi"][(third[0] == 0) & (third[1] == 0)] = np.nan
    return values | dict(zip(QUATERNION, quaternion(first, third).T, strict=True))


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
    if problems.n == 1:  # numbers take half the time of arrays
        start, pars = start[:, 0], pars[:, 0]
    body = problems.body_of_pars(pars)
    moment, events = problems.moment(start, body), problems.base.system.events
    functions = np.ones((problems.n, len(events)))
    for e, event in enumerate(events):
        if event.formula is not None:
            functions[:, e] = event.formula(moment, body)
    return functions
