"""Derivatives of states and columns by the numbers of a problem, for motions of one phase."""

import threading
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..awaiting import awaited
from ..mechanics.contact.surroundings import by_table
from ..mechanics.units import SECOND
from ..problem import Problem, refuse
from .integrator import awaited_once
from .variational import Kind, compiled_motion, compiled_readings


MOST_LANES = 4
_one_at_a_time = threading.Lock()  # integrators are shared, and have a state


class Tangents:
    """Integrate motions together with their derivatives by the numbers of a problem.

    Parameters
    ----------
    problem
        The run; the derivatives of its orientation are computed if it has one.
    wrt
        Dotted names; an initial number among them that is not given is 0.
    most
        Steps per internal unit of time beyond which a motion counts as one that cannot be
        integrated; 0: any number.

    Raises
    ------
    InputError
        If the problem has no number of a name, or the run has no derivatives.

    Attributes
    ----------
    values
        All numbers by name, SI.
    directions
        One internal unit of each of `wrt`, (numbers, directions).
    """

    def __init__(self, problem: Problem, wrt: Sequence[str], most: float = 0.0):
        refuse(problem, wrt)
        self.problem = problem
        self.most = most
        given = dict.fromkeys(sorted(wrt), 0.0)
        for table in ("parameters", "friction", "initial", *by_table(problem.surroundings)):
            given |= {f"{table}.{name}": value for name, value in problem.tables[table].items()}
        self.flags = tuple(name for name, value in given.items() if value is True)
        self.values = {
            name: float(value) for name, value in given.items() if not isinstance(value, bool)
        }
        self.directions = np.array([[float(name == one) for one in wrt] for name in self.values])
        self.second = problem.unit(SECOND)

    def scale(self, name: str) -> float:
        """Return how many SI units are one internal unit of a number."""
        return self.problem.unit(self.problem.rules[name].unit)

    def parameters(self, ways: np.ndarray, values: Mapping[str, Any] | None = None) -> np.ndarray:
        """Return the parameters of compiled functions: numbers in internal units, then directions.

        Parameters
        ----------
        ways
            The directions, (numbers, lanes).
        values
            Numbers that replace those of the problem, SI, (lanes,) each.
        """
        numbers = {**self.values, **(values or {})}
        rows = [
            np.broadcast_to(value / self.scale(name), ways.shape[1])
            for name, value in numbers.items()
        ]
        return np.concatenate([rows, ways])

    def _kind(self, order: int) -> Kind:
        """Return the key of the compiled functions."""
        problem = self.problem
        names = tuple(self.values)
        return Kind(problem.system, problem.variables, problem.law, names, self.flags, order)

    def states(self, order: int, pars: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return states with derivatives at given times.

        Parameters
        ----------
        order
            0, 1 or 2: the highest derivative.
        pars
            Of `parameters`, (.., lanes).
        times
            [s], (rows, 1 or lanes), ascending; the start is at 0.

        Returns
        -------
        ndarray
            (order + 1, variables, rows, lanes); NaN from where a motion cannot be integrated
            further.
        """
        kind = self._kind(order)
        total = pars.shape[1]
        internal = np.broadcast_to(times, (len(times), total)) / self.second
        width = 1 << min(total - 1, MOST_LANES - 1).bit_length()
        key = kind, width, self.problem.tolerance
        starts, integrator = awaited_once(
            compiled_motion, key, "the variational equations are being compiled"
        )
        begin = starts(np.empty((0, total)), pars=pars[: starts.nparams])
        found = np.full((len(begin), *internal.shape), np.nan)

        def fill() -> None:
            for first in range(0, total, width):
                lanes = np.arange(first, first + width).clip(max=total - 1)
                grid = internal.take(lanes, axis=1)
                limit = int(self.most * (1 + np.abs(grid).max()))
                with _one_at_a_time:
                    integrator.set_time(0.0)
                    integrator.state[:] = begin[:, lanes]
                    integrator.pars[:] = pars[: len(integrator.pars), lanes]
                    integrator.propagate_until(grid[0], max_steps=limit)
                    if (integrator.time == grid[0]).all():
                        _, rows = integrator.propagate_grid(grid, max_steps=limit)
                        found[..., lanes] = np.swapaxes(rows, 0, 1)

        awaited(fill, "the variational equations are integrated")
        return found.reshape(order + 1, -1, *internal.shape)

    def read(
        self,
        order: int,
        pars: np.ndarray,
        times: np.ndarray,
        names: tuple[str, ...] | None = None,
    ) -> dict[str, np.ndarray]:
        """Return columns of states with derivatives at given times, in internal units.

        Parameters
        ----------
        order, pars, times
            As for `states`.
        names
            Of the columns; None: all.

        Returns
        -------
        dict
            name -> (order + 2, rows, lanes): values, derivatives along the direction, and last the
            derivative by time [1/s].
        """
        states = self.states(order, pars, times)
        known, function = awaited_once(
            compiled_readings,
            (self._kind(order), names),
            "the derivatives of columns are being compiled",
        )
        rows, lanes = states.shape[2:]
        pars = np.tile(pars[: function.nparams], rows)
        outputs = function(states.reshape(-1, rows * lanes), pars=pars)
        columns = outputs.reshape(order + 2, len(known), rows, lanes)
        columns[-1] /= self.second
        return dict(zip(known, columns.swapaxes(0, 1), strict=True))
