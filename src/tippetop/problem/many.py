"""Many runs that differ in numbers only, arrays of shape (n,), and the units in which they are
integrated.

Everything that is computed of a run is computed here; a single run is the case n = 1.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..mechanics.caching import cached_property
from ..mechanics.moment import Moment, moment
from ..mechanics.operand import leaves, refill
from ..mechanics.units import SECOND, Scales, Unit
from ..mechanics.variables import Variables
from .faults import at_start, together, variation_faults


if TYPE_CHECKING:
    from .one import Problem


ROUNDING = 1e-9  # of what a system says of its units


@dataclass(frozen=True, eq=False)
class Problems:
    """n runs that differ in numbers only: `columns` has arrays (n,), SI, under dotted keys like
    `friction.mu`.

    A run's numbers depend on its own alone, to the bit. Units are converted in 80 bits, or in the
    precision of the base if that is wider; what an integrator is fed is rounded once.
    """

    base: "Problem"
    columns: Mapping[str, np.ndarray]
    orientation: bool = (
        False  # whether the turn about the axis is integrated too: of one among many, few ask
    )

    @classmethod
    def vary(
        cls, base: "Problem", columns: Mapping[str, Any], orientation: bool = False
    ) -> "Problems":
        """Problems of arrays or lists (n,).

        Raises InputError if a key is wrong; `check` tells of single numbers.

        Parameters
        ----------
        base
            What the runs have in common.
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
            sentences = [
                "`initial.from` must be the start of a single run, but many are asked for."
            ]
        if sentences:
            raise InputError(sentences)
        return cls(
            base,
            {key: np.array(values, dtype=float) for key, values in columns.items()},
            orientation,
        )

    @property
    def n(self) -> int:
        """Number of runs."""
        return len(next(iter(self.columns.values()))) if self.columns else 1

    def given(self, table: str) -> dict[str, Any]:
        """What a table gives, by name: arrays where it varies."""
        columns = {
            key.partition(".")[2]: v
            for key, v in self.columns.items()
            if key.startswith(f"{table}.")
        }
        base = self.base.tables[table]
        return (
            self.base.system.replaced(base, columns) if table == "initial" else {**base, **columns}
        )

    @cached_property
    def _single(self) -> bool:
        """Whether numbers are used instead of arrays of one: faster, and the same bits."""
        return not self.columns and self.base.exact is np.longdouble

    def _wide(self, value: Any) -> Any:
        """A number or a column in the type in which units are converted, (n,), or a number; a flag
        as it is.
        """
        if isinstance(value, bool):
            return value
        if self._single:
            return np.longdouble(value)
        value = np.asarray(value, dtype=self.base.exact)
        return value if np.ndim(value) else np.full(self.n, value, dtype=self.base.exact)

    def body(self, number: Callable) -> Any:
        """The bodies in SI units, of what is given passed through `number`."""
        friction = self.base.friction
        friction = friction._replace(**self.given("friction")) if self.columns else friction
        return self.base.system.body_of(self.given("parameters"), friction, number)

    @cached_property
    def _body(self) -> Any:
        body = self.body(self._wide)
        return refill(body, map(self._wide, leaves(body)))  # some may be constants

    @cached_property
    def scales(self) -> Scales:
        """Internal units, (n,): of mass, length and time."""
        return Scales(*map(np.atleast_1d, self._scales))

    @cached_property
    def _scales(self) -> Scales:
        """Internal units, (n,) or numbers: the system's mass and length, and the power of two
        seconds that is nearest sqrt(length/g), or to a second without `g`.

        A power of two, so that times convert without rounding: output and event times are exact.
        """
        mass, length = map(self._wide, self.base.system.scales(self._body))
        length = length * self._wide(self.base.form.length_unit)
        gravity = getattr(self._body, "g", length)  # without gravity the unit is a second
        ratio = np.sqrt(length.astype(float) / gravity.astype(float))
        return Scales(mass, length, (2.0 ** np.round(np.log2(ratio))).astype(self.base.exact))

    def unit(self, unit: Unit) -> np.ndarray:
        """SI units in one internal unit, (n,), doubles."""
        return self.scales.of(unit).astype(float)

    @cached_property
    def weights(self) -> list:
        """SI value of one internal unit of each integrated variable, (n,) or a number each."""
        return self.variables.weights(self._scales)

    @cached_property
    def variables(self) -> Variables:
        """What is integrated."""
        return Variables(self.base.form, self.orientation)

    @cached_property
    def pars(self) -> np.ndarray:
        """Leaves of the bodies in internal units, (leaves, n), in the working precision."""
        units = leaves(self.base.system.body_units(self.base.law.units()))
        scaled = iter(
            [
                value / self._scales.of(unit)
                for value, unit in zip(leaves(self._body), units, strict=True)
            ]
        )
        body, folds = refill(self._body, scaled), self.base.system.folds(self.base.form)
        self._refuse_false(folds, body)
        return self._rounded(leaves(body._replace(**folds)))

    def _refuse_false(self, folds: dict[str, float], body: Any) -> None:
        """Raises InputError where what the equations take for 0 or 1 is another number in internal
        units.
        """
        numbers = [name for name, value in body._asdict().items() if not isinstance(value, tuple)]
        if strange := [name for name in folds if name not in numbers]:
            raise InputError(
                f"`normalised_to` of `{self.base.system.name}` must name numbers of its body "
                f"({', '.join(numbers)}), but has `{strange[0]}`."
            )
        for name, value in folds.items():
            scaled = getattr(body, name).astype(float)
            far = abs(scaled - value) > ROUNDING  # what is no number is refused elsewhere
            if far.any():
                wrong = np.atleast_1d(scaled)[np.atleast_1d(far)]
                raise InputError(
                    f"`normalised_to` of `{self.base.system.name}` must hold in its internal "
                    "units (`scales`; the "
                    f"unit of time is a power of two seconds), but `{name}` is {wrong[0]:.6g} "
                    f"there, not {value:g}."
                )

    @cached_property
    def parameters(self) -> np.ndarray:
        """What the user gives of the bodies, in internal units: parameters, then friction,
        (numbers, n).
        """
        given, friction = self.given("parameters"), self.given("friction")
        units = [*(p.unit for p in self.base.system.parameters.values()), *self.base.law.units()]
        values = [*(given[name] for name in self.base.system.parameters), *friction.values()]
        return self._rounded(
            [self._wide(v) / self._scales.of(unit) for v, unit in zip(values, units, strict=True)]
        )

    @cached_property
    def internal_body(self) -> Any:
        """The bodies in internal units, as formulas take them; what is 0 or 1 by construction is
        exactly that.
        """
        return self.body_of_pars(self.pars)

    def body_of_pars(self, pars: np.ndarray) -> Any:
        """The bodies of leaves (leaves, n); what is 0 or 1 by construction is exactly that."""
        return refill(self._body, iter(pars))._replace(**self.base.system.folds(self.base.form))

    @cached_property
    def start(self) -> np.ndarray:
        """Internal states at t = 0, (variables, n), in the working precision."""
        data = {name: self._wide(value) for name, value in self.given("initial").items()}
        theta = np.atleast_1d(data.get("theta", self._wide(0.0)))
        s, z = np.sin(theta), np.cos(theta)
        pole = theta.astype(float) == math.pi  # what the user means who writes 3.141592653589793
        s[pole], z[pole] = 0, -1
        if self._single:
            theta, s, z = theta[0], s[0], z[0]
        angles = self.base.system.start(data, s, z, self._body)
        q, carried = self.variables.start(data, angles, s, z, self._body)
        values = zip((*q, *carried), self.weights, strict=True)
        return self._rounded([(v + 0 * theta) / weight for v, weight in values])

    def _rounded(self, rows: list) -> np.ndarray:
        """Rows of numbers or arrays (n,) in the working precision, (rows, n)."""
        rounded = np.empty((len(rows), self.n), dtype=self.base.number)
        for i, row in enumerate(rows):
            rounded[i] = row
        return rounded

    @cached_property
    def end(self) -> np.ndarray:
        """Internal times at which the runs end, (n,), doubles."""
        return np.asarray(
            np.broadcast_to(self.given("run")["until"], (self.n,)) / self.unit(SECOND), float
        )

    def record(self, states: np.ndarray) -> Any:
        """The state record of states (variables, k), in internal units."""
        return self.variables.split(states)[0]

    def moment(self, states: np.ndarray, body: Any) -> Moment:
        """Return what formulas read of states (variables, k), in internal units."""
        return moment(self.base.system, self.base.form, *self.variables.split(states), body)

    # --- which of them can be --------------------------------------------------------------------

    def check(self) -> tuple[np.ndarray, list[tuple[int, str]]]:
        """Which runs are valid, (n,), and what is wrong with the others: (number, sentence),
        ascending.

        Returns
        -------
        valid
            (n,) bool.
        faults
            Sentences with the number of their run.

        Notes
        -----
        Looks at every number that varies, at what parameters break together, and at the start: all
        that is computed of it must be finite, and the model must have a solution there.
        """
        return self._checked

    @property
    def valid(self) -> np.ndarray:
        """Which runs are valid, (n,)."""
        return self._checked[0]

    @cached_property
    def _checked(self) -> tuple[np.ndarray, list[tuple[int, str]]]:
        valid, faults = np.ones(self.n, bool), []
        for key, column in self.columns.items():
            rule = self.base.rules[key]
            broken = np.flatnonzero(rule.broken(column))
            faults += [(int(i), rule.fault(key, column[i])) for i in broken]
            valid[broken] = False
        if any(key.startswith("parameters.") for key in self.columns):
            clashes = together(self, valid)
            valid[[i for i, _ in clashes]] = False
            faults += clashes
        with np.errstate(all="ignore"):
            sentences = at_start(self)
        for sentence, bad in sentences:
            if bad.any():
                faults += [(int(i), sentence) for i in np.flatnonzero(valid & bad)]
                valid &= ~bad
        valid.flags.writeable = False
        return valid, sorted(faults)


@dataclass(frozen=True, eq=False)
class StartedFrom(Problems):
    """A run that starts in a given state, (variables, 1), internal, whatever its initial data say
    of it.
    """

    state: np.ndarray = field(default_factory=lambda: np.zeros((0, 1)))

    @cached_property
    def start(self) -> np.ndarray:
        """The state."""
        return self.state
