"""Convert integrated states to named columns: angles, vectors and quantities, in SI units.

Rows of internal states go in; out come values by name in internal units (`values_of`), and columns
in SI units with their attributes (`Observables.columns`), as the store and Datasets have them.

Symbols
    states    (variables, k); rows: the same transposed, (k, variables); internal units
    which     number of the run of each state in a `Problems`, (k,)
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..columns import Arrays, Column, column, flag_attributes
from ..mechanics.moment import Moment, moment
from ..mechanics.operand import refill
from ..mechanics.rotation import outer
from ..mechanics.units import SECOND
from ..problem import TURN, Problem, Problems
from ..problem.row_columns import QUATERNION, Source, every_source
from .expressions import (
    SINE2,
    SPEED2,
    axes_in,
    compile_observables,
    observed,
    orientation_of,
)
from .orientation import quaternion


@dataclass(frozen=True)
class Observables:
    """Compute values and columns from rows of internal states (n, variables) of one problem.

    Integrations and recorders keep one as `view`; others make it where they need it.
    """

    problem: Problem

    @property
    def body(self) -> Any:
        """Return the body that formulas take, in internal units."""
        pars = _widened(self.problem.alone.pars[:, 0], self.problem)
        return refill(self.problem.internal_body, iter(pars))

    def state(self, rows: np.ndarray) -> tuple[Any, Any]:
        """Return the state record of the rows and the record of their integrals, internal units."""
        return self.problem.variables.split(_widened(rows, self.problem).T)

    def moment(self, rows: np.ndarray) -> Moment:
        """Return the arguments of formulas for the rows, or for one row, in internal units."""
        return moment(self.problem.form, *self.state(rows), self.body)

    def evaluate(self, rows: np.ndarray) -> Arrays:
        """Return all values of the rows by name, in internal units, (k,) each.

        An angle is NaN where it is undefined, exactly at a pole.
        """
        return values_of(self.problem.alone, rows.T, ALONE)

    def theta(self, row: np.ndarray) -> float:
        """Return theta of one row, (1, variables) [rad]."""
        return float(self.evaluate(row)["theta"][0])

    def domains(self, rows: np.ndarray) -> dict[str, float]:
        """Return the least value of each of the form's `domains` over the rows, internal units.

        They must stay positive; the keys are their meanings, which messages quote.
        """
        state = self.moment(rows)
        body = self.body
        domains = self.problem.form.domains
        return {h.meaning: float(np.min(h.formula(state, body))) for h in domains}

    def columns(self, times: np.ndarray, rows: np.ndarray) -> dict[str, Column]:
        """Return rows at these times [s] as columns of the store's group `trajectory`, SI."""
        problem = self.problem
        values = self.evaluate(rows)
        if not set(TURN).isdisjoint(problem.kept_columns):
            values |= orientations_of(problem.alone, rows.T, ALONE)
        columns = {"time": column(times, SECOND, "time")}
        for name, source in sources(problem).items():
            if source.flags:
                flags = np.rint(values[name]).astype(np.int8)
                attributes = flag_attributes(source.flags, source.long_name)
                columns[name] = Column(("time",), flags, attributes)
                continue
            parts = [values[part] for part in source.parts]
            whole = np.stack(parts, axis=1) if source.dims else parts[0]
            scale = _widened(np.array(problem.scales.of(source.unit)), problem)
            columns |= self._split(name, whole * scale, source)
        if problem.precision == "quad":
            # the quantities are computed in 80 bits: the state itself goes in whole
            whole = rows * np.array(problem.weights())
            for (name, unit), state in zip(problem.variables.units.items(), whole.T, strict=True):
                if f"state_{name}" in problem.kept_columns:
                    source = Source((), unit, f"integrated variable {name}")
                    columns |= self._split(f"state_{name}", state, source)
        return columns

    def _split(self, name: str, values: np.ndarray, source: "Source") -> dict[str, Column]:
        """Return a column of doubles from values of any precision.

        In wider precisions a second column, `name_lo`, has the rest, to be added.
        """
        high = values.astype(np.float64)
        dims = ("time", *source.dims)
        columns = {name: column(high, source.unit, source.long_name, dims, **source.attributes)}
        if self.problem.precision != "double":
            low = (values - high).astype(np.float64)
            long_name = f"{source.long_name}: low part, to be added"
            columns[f"{name}_lo"] = column(low, source.unit, long_name, dims)
        return columns


def sources(problem: Problem) -> dict[str, Source]:
    """Return the sources of the columns of a run by name, apart from the time and the low parts."""
    kept = problem.kept_columns
    known = every_source(problem.system, problem.form.name)
    return {name: source for name, source in known.items() if name in kept}


def values_of(problems: Problems, states: np.ndarray, which: np.ndarray) -> Arrays:
    """Return the values of states by name, in internal units.

    An angle is NaN exactly at a pole, where it is undefined.

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
    system = problems.base.system
    values = _computed(observed, problems, states, which)
    if SINE2 in values:  # a pole is left at full speed, along no azimuth
        pole = values.pop(SINE2) == 0
        speed2 = values.pop(SPEED2)
        values["theta_dot"][pole] = np.sqrt(speed2[pole])
        for name in system.undefined_at_poles:
            values[name][pole] = np.nan
    return values


def orientations_of(problems: Problems, states: np.ndarray, which: np.ndarray) -> Arrays:
    """Return the unit quaternions that turn body axes into space axes, and `psi`, of states.

    psi [rad] is NaN exactly at a pole, and missing if the motion is planar.

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
    values = _computed(orientation_of, problems, states, which)
    first, third = axes_in(values)
    if "psi" in values:
        values["psi"][(third.x == 0) & (third.y == 0)] = np.nan
    return values | dict(zip(QUATERNION, quaternion(outer(first, third)), strict=True))


# states that are evaluated at a time: from some 300 on, heyoka shares them among threads unasked
BLOCK = 128
ALONE = np.zeros(1, int)
"""The number of a run that is alone."""


def _computed(
    formulas: Callable, problems: Problems, states: np.ndarray, which: np.ndarray
) -> Arrays:
    """Return the values of `formulas`, `observed` or `orientation_of`, by name, (k,) each.

    Doubles are computed by a compiled function, wider numbers by numpy in 80 bits. The value of a
    state has the same bits whatever states are computed with it: stores and ensembles rely on it.
    """
    base = problems.base
    k = states.shape[1]
    if base.precision != "double":
        view = Observables(base)
        with np.errstate(invalid="ignore", divide="ignore"):
            values = formulas(base.system, base.form, *view.state(states.T), view.body)
        return {name: np.broadcast_to(value, k).copy() for name, value in values.items()}
    names, function = compile_observables(formulas, base.system, problems.variables, base.law)
    pars = problems.pars[: function.nparams, which]
    outputs = []
    tables = states, np.broadcast_to(pars, (len(pars), k))
    for first in range(0, k or 1, BLOCK):  # without states, one empty block
        some = [table[:, first : first + BLOCK] for table in tables]
        n = some[0].shape[1]
        # whole batches, the last state again: neighbours change no bit of a column
        whole = np.arange(n + -n % function.batch_size)
        inputs, bodies = (table.take(whole, axis=1, mode="clip") for table in some)
        outputs.append(function(inputs, pars=bodies)[:, :n])
    return dict(zip(names, np.concatenate(outputs, axis=1), strict=True))


def _widened(values: np.ndarray, problem: Problem) -> np.ndarray:
    """Return values in the precision in which columns are computed, doubles or 80 bits.

    Quadruple numbers are converted in two halves, since numpy has no direct way to 80 bits.
    """
    if problem.precision == "quad":
        high = values.astype(np.float64)
        return high.astype(np.longdouble) + (values - high).astype(np.float64)
    return values.astype(problem.number)


def event_functions(problems: Problems) -> np.ndarray:
    """Return the event functions of every run at its start, (n, events), internal units.

    They have the order of the system's events; one without a formula is 1.
    """
    body = problems.body_of_pars(problems.pars.astype(float))
    state = problems.moment(problems.start.astype(float), body)
    events = problems.base.system.events
    functions = np.ones((problems.n, len(events)))
    for e, event in enumerate(events):
        if event.formula is not None:
            functions[:, e] = event.formula(state, body)
    return functions
