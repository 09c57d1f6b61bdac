"""The numbers of a problem that a derivative can be taken by: their names, values and units."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...mechanics.system import Number
from ...problem import Problem, refuse
from ..variational import Kind


class Numbers:
    """All numbers of a problem, in the order in which tangents take them.

    Parameters
    ----------
    problem
        The run.
    wrt
        Dotted names; an initial number among them that is not given is 0.

    Raises
    ------
    InputError
        If the problem has no number of a name, or the run has no derivatives.

    Attributes
    ----------
    values, names
        The numbers by name, SI, and their names.
    directions
        One internal unit of each of `wrt`, (numbers, directions).
    """

    def __init__(self, problem: Problem, wrt: Sequence[str]):
        self.problem = problem
        refuse(problem, wrt)
        asked = {name.partition(".")[2] for name in wrt if name.startswith("initial.")}
        given = {
            name: value for name, value in problem.initial.items() if not isinstance(value, bool)
        }
        self.initial = {**given, **{name: 0.0 for name in sorted(asked - given.keys())}}
        self.flags = tuple(name for name, value in problem.initial.items() if value is True)
        tables = {
            "parameters": {name: problem.parameters[name] for name in problem.system.parameters},
            "friction": problem.friction._asdict(),
            "initial": self.initial,
        }
        self.values = {
            f"{table}.{name}": float(v) for table, of in tables.items() for name, v in of.items()
        }
        self.names = tuple(self.values)
        self.directions = np.array([[float(name == one) for one in wrt] for name in self.names])

    def rule(self, name: str) -> Number:
        """Unit and interval of a number."""
        return self.problem.rules[name]

    def scale(self, name: str) -> float:
        """SI units in one internal unit of a number."""
        return float(self.problem.scales.of(self.rule(name).unit))

    def internal(self, values: dict[str, Any] | None = None) -> np.ndarray:
        """The numbers in internal units, (numbers, ...): those of the problem, some replaced by
        `values`.
        """
        rows = [
            np.asarray((values or {}).get(name, value)) / self.scale(name)
            for name, value in self.values.items()
        ]
        return np.array(np.broadcast_arrays(*rows))

    def kind(self, order: int, *, orientation: bool) -> Kind:
        """Key of the compiled tangents of the problem."""
        problem, names = self.problem, tuple(self.initial)
        equations = problem.system, problem.form.name, type(problem.friction), orientation
        return Kind(*equations, names, self.flags, order)
