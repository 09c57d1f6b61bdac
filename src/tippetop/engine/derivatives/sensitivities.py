"""Derivatives of every column, and of the times and angles of events, along a run."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...columns import Column
from ...errors import InputError
from ...mechanics.rotation import Quaternion, after
from ...mechanics.units import ONE, RADIAN, SECOND, Unit
from ...problem import Problem
from ..expressions import component
from ..orientation import quaternion
from ..tangent import Tangents
from .numbers import Numbers


PARAMETER, OTHER = "parameter", "parameter_2"


class Derivatives(NamedTuple):
    """Columns of derivatives by name.

    Parameters
    ----------
    trajectory
        Along time and parameter.
    events
        Along event and parameter: of the time of an event, and of theta there.
    second
        Along time, parameter and a second parameter; none where they were not asked for.
    """

    trajectory: dict[str, Column]
    events: dict[str, Column]
    second: dict[str, Column]


class _Read(NamedTuple):
    """What a column is made of."""

    parts: tuple[str, ...]  # of the tangents
    unit: Unit
    dims: tuple[str, ...]


def _columns_of(problem: Problem) -> dict[str, _Read]:
    """The columns of a run that have derivatives."""
    system = problem.system
    read = {name: _Read((name,), unit, ()) for name, unit in system.angles._asdict().items()}
    for name, variables in system.vectors.items():
        unit = getattr(system.forms["vector"].units, variables[0])
        read[name] = _Read(tuple(component(v) for v in variables), unit, ("xyz",))
    if problem.orientation and problem.form.orientation:
        if problem.form.orientation.psi:
            read["psi"] = _Read(("psi",), RADIAN, ())
        axes = tuple(f"{axis}_{c}" for axis in ("first", "third") for c in "xyz")
        read["orientation"] = _Read(axes, ONE, ("wxyz",))
    read |= {
        q.name: _Read((q.name,), q.unit, ())
        for q in system.quantities
        if q.is_column and not q.meanings
    }
    kept = problem.columns
    return read if kept is None else {name: each for name, each in read.items() if name in kept}


def differentiate(
    problem: Problem, wrt: Sequence[str], times: np.ndarray, events: Any, order: int = 1
) -> Derivatives:
    """The derivatives of the columns and events of a run by some of its numbers.

    Parameters
    ----------
    problem
        The run, in doubles.
    wrt
        Dotted names of numbers.
    times
        Of the rows [s], (n,), ascending, up to the end of the run.
    events
        Those of the run: arrays `time` [s] and `kind`, (n,), and the names `kinds`.
    order
        1, or 2 for second derivatives of the columns too.

    Returns
    -------
    Derivatives
        SI units per SI unit.

    Raises
    ------
    InputError
        If the run has no derivatives, or a name is wrong.
    """
    if not wrt:
        raise InputError(
            ["`sensitivities` must name at least one number, such as friction.mu, but names none."]
        )
    return _Along(problem, Numbers(problem, wrt), tuple(wrt), order, times, events).derivatives()


class _Along:
    """Tangents along a direction for each parameter, and for sums of two where second derivatives
    are wanted.
    """

    def __init__(
        self,
        problem: Problem,
        numbers: Numbers,
        wrt: tuple[str, ...],
        order: int,
        times: np.ndarray,
        events: Any,
    ):
        self.problem, self.numbers, self.wrt, self.times, self.events = (
            problem,
            numbers,
            wrt,
            times,
            events,
        )
        self.order, self.second = order, float(problem.scales.of(SECOND))
        ways = numbers.directions(wrt)
        if order == 2:
            pairs = [ways[:, i] + ways[:, j] for i in range(len(wrt)) for j in range(i)]
            ways = np.stack([*ways.T, *pairs], axis=1)
        self.ways = ways
        self.sizes = np.array([numbers.scale(name) for name in wrt])
        self.point = np.repeat(numbers.internal()[:, None], ways.shape[1], axis=1)
        self.tangents = Tangents(numbers.kind(order), problem.tolerance)
        self.kinds = [e.name for e in problem.system.events]

    def derivatives(self) -> Derivatives:
        times, events = self.times, self.events
        every = np.unique(np.concatenate([[0.0], times, events.time]))
        timed = ("theta", *(f"event {name}" for name in self.kinds))
        states = self.tangents.states(self.point, self.ways, every / self.second)
        values, rates = self.tangents.read(self.point, self.ways, states, None, timed)
        rows, passages = np.searchsorted(every, times), np.searchsorted(every, events.time)
        first, second = {}, {}
        for name, read in _columns_of(self.problem).items():
            scale = float(self.problem.scales.of(read.unit))
            parts = [values[part] for part in read.parts]
            if name == "orientation":
                parts = _quaternions(np.array(parts))
            whole = np.stack(parts, axis=-1)[:, rows] * scale  # (derivative, rows, lanes, parts)
            whole = whole if read.dims else whole[..., 0]
            first[name] = _column(name, read, self._per_unit(whole[1]), (PARAMETER,))
            if self.order == 2:
                second[name] = _column(name, read, self._mixed(whole[2]), (PARAMETER, OTHER))
        of_events = self._of_events(values, rates, passages)
        return Derivatives(
            _timed(times, first), of_events, _timed(times, second) if self.order == 2 else {}
        )

    def _per_unit(self, rows: np.ndarray) -> np.ndarray:
        """First derivatives, (rows, parameters, ...), by SI units of the parameters."""
        first = rows[:, : len(self.wrt)]
        return first / self.sizes.reshape(1, -1, *(1,) * (first.ndim - 2))

    def _mixed(self, along: np.ndarray) -> np.ndarray:
        """Second derivatives, (rows, parameters, parameters, ...), of those along directions and
        sums of two.
        """
        n = len(self.wrt)
        mixed = np.zeros((len(along), n, n, *along.shape[2:]))
        pairs = iter(range(n, along.shape[1]))
        for i in range(n):
            mixed[:, i, i] = along[:, i]
            for j in range(i):
                mixed[:, i, j] = mixed[:, j, i] = (
                    along[:, next(pairs)] - along[:, i] - along[:, j]
                ) / 2
        sizes = self.sizes[:, None] * self.sizes[None, :]
        return mixed / sizes.reshape(1, n, n, *(1,) * (mixed.ndim - 3))

    def _of_events(
        self, values: dict[str, Any], rates: dict[str, Any], where: np.ndarray
    ) -> dict[str, Column]:
        """Of times and angles of events: the event function stays zero (implicit
        function theorem).
        """
        table = self.events
        by_time, by_theta = (np.full((len(where), len(self.wrt)), np.nan) for _ in range(2))
        for name in self.kinds:
            of = np.flatnonzero(table.kind == table.kinds.index(name))
            rows, n = where[of], len(self.wrt)
            with np.errstate(divide="ignore", invalid="ignore"):
                shift = -values[f"event {name}"][1][rows, :n] / rates[f"event {name}"][rows, :n]
            by_time[of] = shift
            by_theta[of] = values["theta"][1][rows, :n] + rates["theta"][rows, :n] * shift
        return _event_columns(
            table.kind, table.kinds, by_time / self.sizes * self.second, by_theta / self.sizes
        )


def _column(name: str, read: _Read, values: np.ndarray, by: tuple[str, ...]) -> Column:
    """A column of derivatives, SI per SI."""
    about = {
        "units": f"{read.unit.symbol} per unit of the parameter",
        "long_name": f"derivative of {name}",
    }
    return Column(("time", *by, *read.dims), values, about)


def _timed(times: np.ndarray, columns: dict[str, Column]) -> dict[str, Column]:
    return {"time": Column(("time",), times, {"units": "s", "long_name": "time"})} | columns


def _event_columns(
    kind: np.ndarray, kinds: tuple[str, ...], by_time: np.ndarray, by_theta: np.ndarray
) -> dict[str, Column]:
    """The derivatives of events, SI per SI."""
    about = "derivative of {} of the event, as the numbers change"
    units = "{} per unit of the parameter"
    dims = ("event", PARAMETER)
    return {
        "kind": Column(
            ("event",),
            kind,
            {
                "units": "1",
                "long_name": "kind of event",
                "flag_values": list(range(len(kinds))),
                "flag_meanings": " ".join(kinds),
            },
        ),
        "time": Column(
            dims, by_time, {"units": units.format("s"), "long_name": about.format("the time")}
        ),
        "theta": Column(
            dims, by_theta, {"units": units.format("rad"), "long_name": about.format("theta")}
        ),
    }


def _quaternions(axes: np.ndarray) -> list[np.ndarray]:
    """Unit quaternions with their derivatives along directions, four parts (derivatives, rows,
    lanes) each, of axes 1 and 3 of the body, (6, derivatives, rows, lanes).

    q' = (0, w) q/2 and q'' = ((0, w') q + (0, w) q')/2, where w is the rotation vector of the
    change.
    """
    orders, shape = axes.shape[1], axes.shape[2:]
    first, third = axes.reshape(2, 3, orders, -1).swapaxes(1, 2)  # (derivative, xyz, k)
    matrix, *changes = (
        np.stack([first[order], _across(first, third, order), third[order]], axis=1)
        for order in range(orders)
    )
    turns = [
        np.cross(matrix, change, axis=0).sum(axis=1) / 2 for change in changes
    ]  # axis' = w x axis
    jets = [quaternion(first[0], third[0]).T]
    if orders > 1:
        jets.append(0.5 * _product(turns[0], jets[0]))
    if orders > 2:
        jets.append(0.5 * (_product(turns[1], jets[0]) + _product(turns[0], jets[1])))
    return [part.reshape(orders, *shape) for part in np.array(jets).swapaxes(0, 1)]


def _across(first: np.ndarray, third: np.ndarray, order: int) -> np.ndarray:
    """Return a derivative of axis 2 = axis 3 x axis 1."""
    if order == 0:
        return np.cross(third[0], first[0], axis=0)
    ends = np.cross(third[order], first[0], axis=0) + np.cross(third[0], first[order], axis=0)
    return ends if order == 1 else ends + 2 * np.cross(third[1], first[1], axis=0)


def _product(w: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The quaternion (0, w) q, (4, k)."""
    return np.array(after(Quaternion(0.0, *w), Quaternion(*q)))
