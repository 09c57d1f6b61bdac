"""What is to be integrated: checked bodies, starts and spans, and the units in which they are integrated.

`Problem` is one run. `Problems` are many that differ in numbers only, arrays of shape (n,); everything that is computed
of a run is computed there, and a single run is the case n = 1.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import heyoka as hy
import numpy as np

from .errors import InputError, unknown_key
from .mechanics.friction import LAWS, Law
from .mechanics.operand import leaves, refill
from .mechanics.system import Form, Parameter, System
from .mechanics.units import SECOND, Scales, Unit
from .mechanics.variables import Variables
from .sampling import EvenTimes, ListedTimes


PRECISIONS: dict[str, Any] = {"double": np.float64, "longdouble": np.longdouble, "quad": hy.real128}
ROUNDING = {"double": 2.0**-52, "longdouble": 2.0**-63, "quad": 2.0**-112}
UNTIL = Parameter(SECOND, "end of the run", above=0)


@dataclass(frozen=True)
class Problem:
    """One run. Built and checked by `scenario`; everything further in trusts it. All numbers in SI units."""

    system: System
    form: Form
    parameters: dict[str, float]
    friction: Any  # a record of friction.py
    initial: dict[str, Any]
    until: float
    times: EvenTimes | ListedTimes  # of the rows that are asked for
    events: tuple[str, ...]  # the kinds that are logged
    on_liftoff: str = "stop"
    precision: str = "double"
    tolerance: float = 0.0  # 0 is the rounding unit of the precision
    output: str = "times"  # rows at `times`, at the "events", or at the ends of the "steps"
    stop_when: str = "until"  # or "settled"
    orientation: bool = True  # whether the turn of the body about its axis is integrated too

    def __post_init__(self) -> None:
        if isinstance(self.times, np.ndarray):
            object.__setattr__(self, "times", ListedTimes(self.times))

    @cached_property
    def number(self) -> Any:
        """The number type of the precision."""
        return PRECISIONS[self.precision]

    @cached_property
    def exact(self) -> Any:
        """The number type in which units are converted: never less than 80 bits."""
        return np.longdouble if self.precision == "double" else self.number

    @cached_property
    def law_name(self) -> str:
        """The name of the friction law, as in `[friction] law`."""
        laws = {**LAWS, **self.system.laws}
        return next(name for name, law in laws.items() if law.record is type(self.friction))

    @property
    def law(self) -> Law:
        """The friction law: its numbers and their units."""
        return {**LAWS, **self.system.laws}[self.law_name]

    @cached_property
    def tables(self) -> dict[str, dict[str, Any]]:
        """What is given, by table and name."""
        return {
            "parameters": dict(self.parameters),
            "friction": self.friction._asdict(),
            "initial": dict(self.initial),
            "run": {"until": self.until},
        }

    @cached_property
    def rules(self) -> dict[str, Parameter]:
        """What must hold of the numbers, by dotted key: the keys that may vary."""
        friction = self.law.parameters if self.system.frictional else {}
        tables = {"parameters": self.system.parameters, "friction": friction, "initial": self.system.initial}
        return {f"{table}.{name}": rule for table, rules in tables.items() for name, rule in rules.items()} | {
            "run.until": UNTIL
        }

    def faults(self) -> list[str]:
        """What is wrong with the numbers that are given, in sentences; empty if nothing is."""
        faults = self.system.faults(self.parameters)
        for table in ("friction", "initial", "run"):
            for name, value in self.tables[table].items():
                key, rule = f"{table}.{name}", self.rules.get(f"{table}.{name}")
                if rule is not None and rule.broken(value):
                    faults.append(rule.fault(key, value))
                if rule is None and not isinstance(value, bool):
                    known = [k.partition(".")[2] for k in self.rules if k.startswith(f"{table}.")]
                    faults.append(unknown_key(key, known, self.rules))
        return faults + self.system.clashes(_given(self.initial))

    def start_faults(self) -> list[str]:
        """Why there is no motion from the start, in sentences; of numbers that are right one by one."""
        return [sentence for _, sentence in self.alone.check()[1]]

    @cached_property
    def alone(self) -> "Problems":
        """This run as the one of its `Problems`."""
        return Problems(self, {}, self.orientation)

    def body(self, number: Any = float) -> Any:
        """The record that formulas take, in SI units."""
        return self.system.body_of(self.parameters, self.friction, number)

    @cached_property
    def scales(self) -> Scales:
        """The units of mass, length and time in which the run is integrated; see `Problems.scales`."""
        return Scales(*(unit[0] for unit in self.alone.scales))

    @cached_property
    def internal_body(self) -> Any:
        """The body in internal units, in the working precision; what is 0 or 1 by construction is exactly that."""
        return refill(self.alone.internal_body, iter(self.alone.pars[:, 0]))

    @cached_property
    def variables(self) -> Variables:
        """What is integrated."""
        return Variables(self.form, self.orientation)

    def weights(self) -> list:
        """SI value of one internal unit of each integrated variable."""
        return [weight[0] for weight in self.alone.weights]

    def start(self) -> np.ndarray:
        """The internal state at t = 0, (variables,), in the working precision, as the integrator wants it."""
        return self.alone.start[:, 0].copy()

    def internal_time(self, t: Any) -> Any:
        """Times in internal units, exactly."""
        return t / float(self.scales.of(SECOND))


@dataclass(frozen=True, eq=False)
class Problems:
    """n runs that differ in numbers only: `columns` has arrays (n,), SI, under dotted keys like `friction.mu`.

    A run's numbers depend on its own alone, to the bit. Units are converted in 80 bits, or in the precision of the base
    if that is wider; what an integrator is fed is rounded once.
    """

    base: Problem
    columns: Mapping[str, np.ndarray]
    orientation: bool = False  # whether the turn about the axis is integrated too: of one among many, nobody asks

    @classmethod
    def vary(cls, base: Problem, columns: Mapping[str, Any]) -> "Problems":
        """Problems of arrays or lists (n,). Raises InputError if a key is wrong; `check` tells of single numbers."""
        sentences = variation_faults(base, columns)
        if sentences:
            raise InputError(sentences)
        return cls(base, {key: np.array(values, dtype=float) for key, values in columns.items()})

    @property
    def n(self) -> int:
        """Number of runs."""
        return len(next(iter(self.columns.values()))) if self.columns else 1

    def given(self, table: str) -> dict[str, Any]:
        """What a table gives, by name: arrays where it varies."""
        columns = {key.partition(".")[2]: v for key, v in self.columns.items() if key.startswith(f"{table}.")}
        base = self.base.tables[table]
        return self.base.system.replaced(base, columns) if table == "initial" else {**base, **columns}

    def _wide(self, value: Any) -> Any:
        """A number or a column in the type in which units are converted, (n,); a flag as it is."""
        if isinstance(value, bool):
            return value
        value = np.asarray(value, dtype=self.base.exact)
        return value if np.ndim(value) else np.full(self.n, value, dtype=self.base.exact)

    def body(self, number: Callable) -> Any:
        """The bodies in SI units, of what is given passed through `number`."""
        friction = type(self.base.friction)(**self.given("friction"))
        return self.base.system.body_of(self.given("parameters"), friction, number)

    @cached_property
    def _body(self) -> Any:
        return self.body(self._wide)

    @cached_property
    def scales(self) -> Scales:
        """Internal units, (n,): the system's mass and length, and the power of two seconds that is nearest
        sqrt(length/g).

        A power of two, so that times convert without rounding: output and event times are exact.
        """
        mass, length = self.base.system.scales(self._body)
        length = length * self._wide(self.base.form.length_unit)
        ratio = np.sqrt(length.astype(float) / self._body.g.astype(float))
        return Scales(mass, length, (2.0 ** np.round(np.log2(ratio))).astype(self.base.exact))

    def unit(self, unit: Unit) -> np.ndarray:
        """SI units in one internal unit, (n,), doubles."""
        return self.scales.of(unit).astype(float)

    @cached_property
    def weights(self) -> list[np.ndarray]:
        """SI value of one internal unit of each integrated variable, (n,) each."""
        return self.variables.weights(self.scales)

    @cached_property
    def variables(self) -> Variables:
        """What is integrated."""
        return Variables(self.base.form, self.orientation)

    @cached_property
    def pars(self) -> np.ndarray:
        """Leaves of the bodies in internal units, (leaves, n), in the working precision."""
        units = leaves(self.base.system.body_units(self.base.law.units()))
        scaled = iter([value / self.scales.of(unit) for value, unit in zip(leaves(self._body), units, strict=True)])
        body = refill(self._body, scaled)._replace(**self.base.system.folds(self.base.form))
        return self._rounded(leaves(body))

    @cached_property
    def parameters(self) -> np.ndarray:
        """What the user gives of the bodies, in internal units: parameters, then friction, (numbers, n)."""
        given, friction = self.given("parameters"), self.given("friction")
        units = [*(p.unit for p in self.base.system.parameters.values()), *self.base.law.units()]
        values = [*(given[name] for name in self.base.system.parameters), *friction.values()]
        return self._rounded([self._wide(v) / self.scales.of(unit) for v, unit in zip(values, units, strict=True)])

    @cached_property
    def internal_body(self) -> Any:
        """The bodies in internal units, as formulas take them; what is 0 or 1 by construction is exactly that."""
        return self._internal_body(self.pars)

    def _internal_body(self, pars: np.ndarray) -> Any:
        return refill(self._body, iter(pars))._replace(**self.base.system.folds(self.base.form))

    @cached_property
    def start(self) -> np.ndarray:
        """Internal states at t = 0, (variables, n), in the working precision."""
        data = {name: self._wide(value) for name, value in self.given("initial").items()}
        theta = data.get("theta", self._wide(0.0))
        s, z = np.sin(theta), np.cos(theta)
        pole = theta.astype(float) == math.pi  # what the user means who writes 3.141592653589793
        s[pole], z[pole] = 0, -1
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
        return np.asarray(np.broadcast_to(self.given("run")["until"], (self.n,)) / self.unit(SECOND), float)

    def record(self, states: np.ndarray) -> Any:
        """The state record of states (variables, k), in internal units."""
        return self.variables.split(states)[0]

    # --- which of them can be -------------------------------------------------------------------------------------

    def check(self) -> tuple[np.ndarray, list[tuple[int, str]]]:
        """Which runs are valid, (n,), and what is wrong with the others: (number, sentence), ascending.

        Looks at every number that varies, at what parameters break together, and at the start: all that is computed of
        it must be finite, and the model must have a solution there.
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
            faults += [(int(i), rule.fault(key, column[i])) for i in np.flatnonzero(rule.broken(column))]
        valid[[i for i, _ in faults]] = False
        if any(key.startswith("parameters.") for key in self.columns):
            together = self._together(valid)
            valid[[i for i, _ in together]] = False
            faults += together
        with np.errstate(all="ignore"):
            sentences = self._at_start()
        for sentence, bad in sentences:
            faults += [(int(i), sentence) for i in np.flatnonzero(valid & bad)]
            valid &= ~bad
        valid.flags.writeable = False
        return valid, sorted(faults)

    def _together(self, valid: np.ndarray) -> list[tuple[int, str]]:
        """What parameters break together, for each set of them once."""
        given = self.given("parameters")
        rows = np.stack([np.broadcast_to(np.asarray(v, float), (self.n,)) for v in given.values()], axis=1)
        known: dict[bytes, list[str]] = {}
        faults = []
        for i in np.flatnonzero(valid):
            key = rows[i].tobytes()
            if key not in known:
                known[key] = self.base.system.checks(dict(zip(given, rows[i].tolist(), strict=True)))
            faults += [(int(i), sentence) for sentence in known[key][:1]]
        return faults

    def _at_start(self) -> list[tuple[str, np.ndarray]]:
        """What may be wrong with a start, and where it is, (n,): numbers that are finite one by one may overflow
        together, or the model may have no solution."""
        base = self.base
        plain = np.float64 if base.precision == "double" else np.longdouble
        pars, start = self.pars.astype(float), self.start.astype(float)
        body = self._internal_body(pars.astype(plain))
        scalars = base.form.scalars(self.record(start.astype(plain)), body)
        quantities = [q.formula(scalars, body) for q in base.system.quantities]
        finite = np.ones(self.n, bool)
        for value in (*pars, *start, *self.weights, *quantities):
            finite &= np.isfinite(np.asarray(value, dtype=float))
        overflow = "`parameters` and `initial` must stay finite together, but they overflow."
        return [(overflow, ~finite)] + [
            (f"`initial` must allow a motion, but {h.meaning}.", ~(np.zeros(self.n) + h.formula(scalars, body) > 0))
            for h in base.form.domains
        ]


def key_faults(base: Problem, keys: Iterable[str], also: Iterable[str] = ()) -> list[str]:
    """What is wrong with varying these keys of a problem, in sentences; `also` are further names that may vary."""
    keys, known = list(keys), [*also, *base.rules]
    faults = [f"`{key}` must be one of {', '.join(known)}, but is not." for key in keys if key not in base.rules]
    names = [name for table, _, name in (key.partition(".") for key in keys) if table == "initial"]
    return faults + base.system.clashes(_given(base.system.replaced(base.initial, dict.fromkeys(names))), "varies")


def variation_faults(base: Problem, columns: Mapping[str, Any]) -> list[str]:
    """What is wrong with the keys and the shapes of columns, in sentences."""
    if not columns:
        return ["`variations` must vary something, but is empty."]
    shapes = {key: np.shape(values) for key, values in columns.items() if key in base.rules}
    faults = key_faults(base, columns)
    if len(set(shapes.values())) > 1 or any(len(shape) != 1 or not shape[0] for shape in shapes.values()):
        sizes = ", ".join(f"{key} {shape}" for key, shape in shapes.items())
        faults.append(f"`variations` must be arrays of one length and dimension, but are {sizes}.")
    return faults


def _given(initial: Mapping[str, Any]) -> list[str]:
    """The names of initial data that say something."""
    return [name for name, value in initial.items() if value is not False]
