"""The smallest state that the equations of a problem need, and their right-hand side for every
peer: the engine's own formulas, fed what each peer computes with.
"""

import ctypes
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from tippetop.engine.observables import Observables
from tippetop.mechanics.units import SECOND
from tippetop.mechanics.writing import CPP, function
from tippetop.problem import Problem


COMPILER = shutil.which("c++")
FLAGS = ("-O3", "-march=native", "-std=gnu++17", "-shared", "-fPIC", "-x", "c++")


@dataclass(frozen=True)
class Minimal:
    """A problem without its integrals (x, y, work, impulse, phi): internal units, doubles."""

    problem: Problem
    samples: np.ndarray  # [s] where errors are taken; the last is the end

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The variables that are integrated."""
        return self.problem.form.units._fields

    @cached_property
    def start(self) -> np.ndarray:
        """The state at t = 0, (n,)."""
        return self.of_rows(self.problem.start()[None, :])[0].astype(float)

    @cached_property
    def times(self) -> np.ndarray:
        """0 and the samples, internal."""
        return np.concatenate([[0.0], self.samples / float(self.problem.scales.of(SECOND))])

    @cached_property
    def body(self) -> Any:
        """The parameters, plain floats: those that are 0 or 1 in these units fold."""
        return _plain(self.problem.internal_body)

    def of_rows(self, rows: np.ndarray) -> np.ndarray:
        """The minimal states among full rows."""
        return rows[:, : len(self.names)]

    def theta(self, states: np.ndarray) -> np.ndarray:
        """theta [rad] of minimal states (k, n); where it is an integral itself (cylinders), without
        its turns.
        """
        if "theta" not in self.names and "s" in self.names:
            return np.arctan2(*(states[:, self.names.index(name)] for name in "sz"))
        rows = np.zeros((len(states), len(self.problem.variables.names)), dtype=states.dtype)
        rows[:, : len(self.names)] = states
        return theta_of(self.problem, rows)

    def rates(self, values: Any) -> list:
        """Time derivatives of the variables, for whatever the formulas may be fed."""
        form = self.problem.form
        return list(form.rates(type(form.units)(*values), self.body))

    @cached_property
    def source(self) -> str:
        """`slope(y, d)` in C++: each sub-expression once."""
        lines, ends = function(CPP, [f"y[{i}]" for i in range(len(self.names))], self.rates)
        body = [*lines, *(f"d[{i}] = {end};" for i, end in enumerate(ends))]
        text = "\n  ".join(body)
        return (
            "static inline void slope(const double* __restrict y, double* __restrict d) "
            f"{{\n  {text}\n}}\n"
        )

    @cached_property
    def built(self) -> ctypes.CDLL:
        """The right-hand side as a shared library: `rhs(t, y, d, p)`, as the C solvers call it."""
        return built(
            "#include <cmath>\n"
            + self.source
            + 'extern "C" void rhs(double, const double* y, double* d, void*)'
            " { slope(y, d); }\n"
        )

    @cached_property
    def jitted(self) -> Any:
        """slope(y, d) for numba, of the same formulas."""
        from numba import njit

        form = self.problem.form
        rates = njit(error_model="numpy")(form.rates)
        arguments = ", ".join(f"y[{i}]" for i in range(len(self.names)))
        sets = "\n".join(f"    d[{i}] = found[{i}]" for i in range(len(self.names)))
        space = {"rates": rates, "State": type(form.units), "body": self.body}
        exec(f"def slope(y, d):\n    found = rates(State({arguments}), body)\n{sets}", space)
        return njit(error_model="numpy", nogil=True)(space["slope"])


@cache
def built(source: str) -> ctypes.CDLL:
    """Compile a C++ source into a shared library, once in a process.

    Raises OSError with the message of the compiler.
    """
    if COMPILER is None:
        raise OSError("there must be a C++ compiler `c++`, but there is none.")
    with tempfile.TemporaryDirectory() as folder:
        library = f"{folder}/built.so"
        made = subprocess.run(
            [COMPILER, *FLAGS, "-o", library, "-"], input=source, text=True, capture_output=True
        )
        if made.returncode:
            raise OSError(made.stderr)
        return ctypes.CDLL(library)


def _plain(record: Any) -> Any:
    return type(record)(
        *(_plain(leaf) if isinstance(leaf, tuple) else float(leaf) for leaf in record)
    )


def theta_of(problem: Problem, rows: np.ndarray) -> np.ndarray:
    """theta [rad] of full rows, in 80 bits where the run has them."""
    columns = Observables(problem).columns(np.zeros(len(rows)), rows)
    low = columns["theta_lo"].values.astype(np.longdouble) if "theta_lo" in columns else 0.0
    return columns["theta"].values + low


def apart(theta: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """|theta - exact| [rad], whatever the turns."""
    difference = theta - exact
    turn = 2 * np.longdouble(np.pi)
    return np.abs(difference - turn * np.round(difference / turn)).astype(float)
