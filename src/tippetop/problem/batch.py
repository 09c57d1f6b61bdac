"""Runs that differ only in numbers, arrays of shape (n,), and their internal units.

The numbers of a single run are computed here too: it is the case n = 1.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..mechanics.caching import cached_property
from ..mechanics.dual import plain
from ..mechanics.moment import Moment, moment
from ..mechanics.operand import leaves, refill
from ..mechanics.units import SECOND, Scales, Unit
from ..mechanics.variables import Variables, variables_of
from .faults import contradictions, start_faults, variation_faults


if TYPE_CHECKING:
    from .problem import Problem


ROUNDING = 1e-9  # of the numbers that a system declares to be 0 or 1


@dataclass(frozen=True, eq=False)
class Problems:
    """n runs that differ only in numbers: `columns` has arrays (n,), SI, by dotted key.

    `Problems.vary` makes it for ensembles, `Problem.alone` for a single run.

    A run's numbers depend on its own alone, to the bit. Units are converted in 80 bits, or in the
    precision of the base if that is wider; the numbers of an integrator are rounded once.
    """

    base: "Problem"
    columns: Mapping[str, np.ndarray]
    orientation: bool = False  # whether the turn of the body about its axis is integrated too
    state: np.ndarray | None = None  # internal, (variables, 1): where a run starts from another

    @classmethod
    def vary(
        cls, base: "Problem", columns: Mapping[str, Any], orientation: bool = False
    ) -> "Problems":
        """Return problems of arrays or lists (n,); `check` finds faults of single numbers.

        Parameters
        ----------
        base
            The problem that varies.
        columns
            Arrays (n,), SI, by dotted key.
        orientation
            Whether the turn of the body about its axis is integrated too.

        Returns
        -------
        Problems

        Raises
        ------
        InputError
            If a key or a shape is wrong.
        """
        sentences = variation_faults(base, columns)
        if base.origin is not None:
            sentences = ["`initial.from` must be the start of a single run, but there are many."]
        if sentences:
            raise InputError(sentences)
        arrays = {key: np.array(values, dtype=float) for key, values in columns.items()}
        return cls(base, arrays, orientation)

    @property
    def n(self) -> int:
        """Return the number of runs."""
        return len(next(iter(self.columns.values()))) if self.columns else 1

    def given(self, table: str) -> dict[str, Any]:
        """Return the numbers of a table of the scenario by name, SI; arrays (n,) if they vary."""
        varied = {
            key.removeprefix(f"{table}."): values
            for key, values in self.columns.items()
            if key.startswith(f"{table}.")
        }
        base = self.base.tables[table]
        if table == "initial":
            return self.base.system.replaced(base, varied)
        return {**base, **varied}

    @property
    def contact(self) -> Any:
        """Return the law of the contact, SI, with arrays (n,); None where it never opens."""
        rules: Any = self.base.contact
        for table in {"contact", "stem"} & self.base.tables.keys():
            rules = rules._replace(**self.given(table))
        return rules

    def _wide(self, value: Any) -> Any:
        """Return a number as a column, (n,), in the type in which units are converted.

        It stays a number if nothing varies, which is faster. `engine.derivatives.through` overrides
        this and `_rounded`, so that all numbers of `pars` and `start` may be duals.
        """
        if isinstance(value, bool):
            return value
        value = np.asarray(value, dtype=self.base.exact)
        return np.full(self.n, value) if self.columns and not value.ndim else value[()]

    def body(self, number: Callable) -> Any:
        """Return the bodies in SI units, a record `b` whose numbers are passed through `number`.

        Numbers that vary are arrays (n,), others may stay numbers.
        """
        friction = self.base.friction._replace(**self.given("friction"))
        around = self.base.surroundings
        given = self.given("parameters") | {
            key: self.columns.get(key, around[key]) for key in around
        }
        return self.base.system.body_of(given, friction, number)

    @cached_property
    def _body(self) -> Any:
        """Return the bodies that formulas take, in SI units and in the widest precision."""
        return self.body(self._wide)

    @cached_property
    def scales(self) -> Scales:
        """The internal units of mass, length and time, (n,), or numbers if nothing varies.

        Time is in the power of two seconds that is nearest sqrt(length/g), or in seconds without
        `g`: times convert without rounding, so that output and event times are exact.
        """
        mass, length = map(self._wide, self.base.system.scales(self._body))
        length = length * self._wide(self.base.form.length_unit)
        # without `g` the ratio is 1 and the unit a second; `g` may be a constant of the system
        gravity = self._wide(getattr(self._body, "g", length))
        ratio = np.sqrt(np.asarray(plain(length), float) / np.asarray(plain(gravity), float))
        return Scales(mass, length, self._wide(2.0 ** np.round(np.log2(ratio))))

    def unit(self, unit: Unit) -> np.ndarray:
        """Return the SI value of one internal unit, of the shape of the scales, doubles."""
        return np.asarray(self.scales.of(unit), float)

    @cached_property
    def weights(self) -> list:
        """The SI value of one internal unit of each variable, of the shape of the scales."""
        return self.variables.weights(self.scales)

    @cached_property
    def variables(self) -> Variables:
        """The integrated variables."""
        return variables_of(self.base.form, self.orientation)

    @cached_property
    def pars(self) -> np.ndarray:
        """The leaves of the bodies in internal units, (leaves, n), in the working precision.

        In the order of `operand.leaves`: the k-th is the parameter k of compiled equations.
        """
        system = self.base.system
        units = leaves(system.body_units(self.base.law.units()))
        values = zip(leaves(self._body), map(self.scales.of, units), strict=True)
        body = refill(self._body, (value / unit for value, unit in values))
        folds = system.folds(self.base.form)
        for name, value in folds.items():  # the equations have it for 0 or 1
            if isinstance(getattr(body, name, ()), tuple):
                names = [name for name, v in body._asdict().items() if not isinstance(v, tuple)]
                raise InputError(
                    f"`normalised_to` of `{system.name}` must name numbers of its body "
                    f"({', '.join(names)}), but has `{name}`."
                )
            numbers = np.asarray(plain(getattr(body, name)), dtype=float)
            far = ~(abs(numbers - value) <= ROUNDING) & np.isfinite(numbers)
            if far.any():
                raise InputError(
                    f"`normalised_to` of `{system.name}` must hold in its internal units "
                    "(`scales`; the unit of time is a power of two seconds), but "
                    f"`{name}` is {numbers[far][0]:.6g} there, not {value:g}."
                )
        return self._rounded(leaves(body._replace(**folds)))

    @cached_property
    def internal_body(self) -> Any:
        """The bodies in internal units; numbers that are 0 or 1 by construction are exact."""
        return self.body_of_pars(self.pars)

    def body_of_pars(self, pars: np.ndarray) -> Any:
        """Return the bodies whose leaves are `pars` (leaves, n), as `internal_body`."""
        return refill(self._body, iter(pars))._replace(**self.base.system.folds(self.base.form))

    @cached_property
    def start(self) -> np.ndarray:
        """The internal states at t = 0, (variables, n), in the working precision."""
        if self.state is not None:
            return self.state
        data = {name: self._wide(value) for name, value in self.given("initial").items()}
        theta = data.get("theta", self._wide(0.0))
        pole = np.asarray(plain(theta), float) == math.pi  # 3.141592653589793 means the pole
        s = np.sin(theta)
        z = np.cos(theta)
        s = s - np.where(pole, plain(s), self._wide(0.0))[()]  # which may have derivatives
        z = z - np.where(pole, plain(z) + 1, self._wide(0.0))[()]
        angles = self.base.system.start(data, s, z, self._body)
        q, carried = self.variables.start(data, angles, s, z, self._body)
        values = zip((*q, *carried), self.weights, strict=True)
        # 0 * theta: a constant gets the type of the start, perhaps a dual
        return self._rounded([(v + 0 * theta) / weight for v, weight in values])

    def _rounded(self, rows: list) -> np.ndarray:
        """Return rows of numbers or arrays (n,) in the working precision, (rows, n)."""
        rounded = np.empty((len(rows), self.n), dtype=self.base.number)
        for i, row in enumerate(rows):
            rounded[i] = row
        return rounded

    @cached_property
    def end(self) -> np.ndarray:
        """The internal times at which the runs end, (n,), doubles."""
        return np.asarray(
            np.broadcast_to(self.given("run")["until"], (self.n,)) / self.unit(SECOND), float
        )

    def moment(self, states: np.ndarray, body: Any) -> Moment:
        """Return the arguments of formulas for states (variables, k), in internal units."""
        return moment(self.base.form, *self.variables.split(states), body)

    @property
    def valid(self) -> np.ndarray:
        """Which runs are valid, (n,)."""
        return self.checked[0]

    @cached_property
    def checked(self) -> tuple[np.ndarray, list[tuple[int, str]]]:
        """Which runs are valid, (n,), and pairs of the number of a run and a fault, ascending.

        Checks every number that varies, contradictions between parameters, and the start: all that
        is computed of it must be finite, and there must be a motion. A run whose number is at fault
        is not checked further: later faults would follow from that.
        """
        valid = np.ones(self.n, bool)
        faults = []
        for key, column in self.columns.items():
            rule = self.base.rules[key]
            broken = np.flatnonzero(rule.broken(column))
            faults += [(int(i), rule.fault(key, column[i])) for i in broken]
            valid[broken] = False
        if any(key.startswith("parameters.") for key in self.columns):
            clashes = contradictions(self, valid)
            valid[[i for i, _ in clashes]] = False
            faults += clashes
        with np.errstate(all="ignore"):
            sentences = start_faults(self)
        for sentence, bad in sentences:
            if bad.any():
                faults += [(int(i), sentence) for i in np.flatnonzero(valid & bad)]
                valid &= ~bad
        valid.flags.writeable = False
        return valid, sorted(faults)
