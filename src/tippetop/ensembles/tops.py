"""Many tops that differ in numbers only: what `Problem` says of one, said of all at once, bit by bit the same."""

import dataclasses
import math
from functools import cached_property
from typing import Any

import numpy as np

from ..engine.expressions import compile_observables
from ..mechanics.operand import leaves, refill
from ..mechanics.system import Parameter
from ..mechanics.units import SECOND, Scales, Unit
from ..problem import Problem


TABLES = ("parameters", "friction", "initial", "run")


class Tops:
    """A problem of which some numbers vary: `columns` has arrays (n,) under dotted keys, checked by `faults`."""

    def __init__(self, base: Problem, columns: dict[str, np.ndarray]):
        self.base, self.columns = dataclasses.replace(base, orientation=False), columns
        self.n = len(next(iter(columns.values())))
        self.valid = np.ones(self.n, bool)

    def given(self, name: str) -> dict[str, Any]:
        """The numbers of a table: arrays where they vary."""
        base = {
            "parameters": self.base.parameters,
            "friction": self.base.friction._asdict(),
            "initial": self.base.initial,
            "run": {"until": self.base.until},
        }[name]
        varied = {k.partition(".")[2]: v for k, v in self.columns.items() if k.startswith(f"{name}.")}
        if "omega3" in varied:
            base = {k: v for k, v in base.items() if k != "psi_dot"}
        if "psi_dot" in varied:
            base = {k: v for k, v in base.items() if k != "omega3"}
        return {**base, **varied}

    def _wide(self, values: dict[str, Any]) -> dict[str, Any]:
        return {
            k: v if isinstance(v, bool) else np.broadcast_to(np.asarray(v, np.longdouble), (self.n,))
            for k, v in values.items()
        }

    @cached_property
    def body(self) -> Any:
        """The bodies, SI, 80 bits."""
        friction = type(self.base.friction)(**self._wide(self.given("friction")))
        return self.base.system.body(self._wide(self.given("parameters")), friction)

    @cached_property
    def scales(self) -> Scales:
        """Internal units, as `Problem.scales`."""
        mass, length = self.base.system.units(self.body, self.base.form)
        ratio = np.sqrt(length.astype(float) / self.body.g.astype(float))
        return Scales(mass, length, 2.0 ** np.round(np.log2(ratio)).astype(np.longdouble))

    @cached_property
    def pars(self) -> np.ndarray:
        """Leaves of the internal bodies, (leaves, n)."""
        units = leaves(self.base.system.body_units(self.base.friction_units))
        scaled = iter([v / self.scales.of(u) for v, u in zip(leaves(self.body), units, strict=True)])
        body = refill(self.body, scaled)._replace(**self.base.system.folds(self.base.form))
        return np.array([np.broadcast_to(leaf, (self.n,)) for leaf in leaves(body)], dtype=float)

    @cached_property
    def start(self) -> np.ndarray:
        """Internal states at t = 0, (variables, n)."""
        data = self._wide(self.given("initial"))
        theta = np.array(data.get("theta", np.zeros(self.n, np.longdouble)))
        s, z = np.sin(theta), np.cos(theta)
        pole = theta.astype(float) == math.pi
        s[pole], z[pole] = 0, -1
        euler = self.base.system.start(data, s, z, self.body)
        q, carried = self.base.variables.start(data, euler, s, z, self.body)
        weights = self.base.variables.weights(self.scales)
        return np.array([(v + 0 * theta) / w for v, w in zip((*q, *carried), weights, strict=True)], dtype=float)

    @cached_property
    def end(self) -> np.ndarray:
        """Internal times at which the runs end, (n,)."""
        return np.asarray(np.broadcast_to(self.given("run")["until"], (self.n,)) / self.unit(SECOND), float)

    def unit(self, unit: Unit) -> np.ndarray:
        """SI units in one internal unit, (n,)."""
        return np.asarray(np.broadcast_to(self.scales.of(unit), (self.n,)), float)

    def values(self, states: np.ndarray, which: np.ndarray) -> dict[str, np.ndarray]:
        """All that states (variables, k) of the tops `which` (k,) say, by name, in internal units."""
        base = self.base
        names, function = compile_observables(base.system, base.form.name, base.friction.__class__, False)
        k = states.shape[1]
        fill = -k % function.batch_size  # whole SIMD batches: the bits of a column do not depend on its neighbours
        padded = np.ascontiguousarray(np.pad(states, ((0, 0), (0, fill)), mode="edge"))
        pars = np.ascontiguousarray(np.pad(self.pars[: function.nparams, which], ((0, 0), (0, fill)), mode="edge"))
        outputs = function(padded, pars=pars)[:, :k]
        return dict(zip(names, outputs, strict=False))

    def faults(self) -> list[tuple[int, str]]:
        """Checks every number of every top, and marks what cannot be: (top, sentence)."""
        found = []
        for key, column in self.columns.items():
            rule = known(self.base)[key]
            bad = ~np.isfinite(column)
            for limit, breaks in (
                (rule.above, np.less_equal),
                (rule.least, np.less),
                (rule.below, np.greater_equal),
                (rule.most, np.greater),
            ):
                if limit is not None:
                    bad |= breaks(column, limit)
            found += [
                (int(i), f"`{key}` must be {_range(rule)}, but is {column[i]:.17g}.") for i in np.flatnonzero(bad)
            ]
        self.valid[[i for i, _ in found]] = False
        if any(key.startswith("parameters.") for key in self.columns):
            found += self._together()
        with np.errstate(all="ignore"):
            at_start = self.values(self.start, np.arange(self.n))
            finite = np.isfinite(self.start).all(axis=0) & np.isfinite(self.pars).all(axis=0)
            finite &= np.isfinite([at_start[q.name] for q in self.base.system.quantities]).all(axis=0)
            sound = finite & ~self._jammed()
        found += [
            (int(i), "`parameters` and `initial` must allow a motion, but do not.")
            for i in np.flatnonzero(self.valid & ~sound)
        ]
        self.valid &= sound
        return sorted(found)

    def _together(self) -> list[tuple[int, str]]:
        """What parameters break together, for each set of them once."""
        given = self.given("parameters")
        rows = np.stack([np.broadcast_to(np.asarray(v, float), (self.n,)) for v in given.values()], axis=1)
        said: dict[bytes, list[str]] = {}
        found = []
        for i in np.flatnonzero(self.valid):
            key = rows[i].tobytes()
            if key not in said:
                said[key] = self.base.system.checks(dict(zip(given, rows[i].tolist(), strict=True)))
            if said[key]:
                found.append((int(i), said[key][0]))
        self.valid[[i for i, _ in found]] = False
        return found

    def record(self, states: np.ndarray) -> Any:
        """The state record of states (variables, n), in internal units."""
        return self.base.variables.split(states)[0]

    @cached_property
    def internal_body(self) -> Any:
        """The bodies in internal units, as formulas take them."""
        return refill(self.base.internal_body, iter(self.pars))._replace(**self.base.system.folds(self.base.form))

    def _jammed(self) -> np.ndarray:
        """Where the model has no solution at the start."""
        scalars, jammed = self.base.form.scalars(self.record(self.start), self.internal_body), np.zeros(self.n, bool)
        for domain in self.base.form.domains:
            jammed |= ~(domain.formula(scalars, self.internal_body) > 0)
        return jammed


def known(base: Problem) -> dict[str, Parameter]:
    """The keys that may vary, and what must hold of them."""
    system = base.system
    found = {f"parameters.{name}": rule for name, rule in system.parameters.items()}
    for law in system.laws.values():
        if law.record is type(base.friction):
            found |= {f"friction.{name}": rule for name, rule in law.parameters.items()}
    found |= {f"initial.{name}": rule for name, rule in system.initial.items()}
    return {**found, "run.until": Parameter(SECOND, "end of the run", above=0)}


def _range(rule: Parameter) -> str:
    words = [
        (rule.above, "greater than"),
        (rule.least, "at least"),
        (rule.below, "less than"),
        (rule.most, "at most"),
    ]
    return "finite" + "".join(f", {word} {limit:g}" for limit, word in words if limit is not None)
