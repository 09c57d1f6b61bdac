"""What is to be integrated: a checked system, body, start and span, and the units in which it is integrated."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import heyoka as hy
import numpy as np

from .mechanics.operand import leaves, refill
from .mechanics.system import Form, System
from .mechanics.units import SECOND, Scales
from .mechanics.variables import Variables
from .sampling import EvenTimes, ListedTimes


PRECISIONS: dict[str, Any] = {"double": np.float64, "longdouble": np.longdouble, "quad": hy.real128}
ROUNDING = {"double": 2.0**-52, "longdouble": 2.0**-63, "quad": 2.0**-112}


@dataclass(frozen=True)
class Problem:
    """One run. Built and checked by `scenario`; everything further in trusts it. All numbers in SI units."""

    system: System
    form: Form
    parameters: dict[str, float]
    friction: Any  # a record of friction.py
    friction_units: Any
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

    def body(self, number: Any = float) -> Any:
        """The record that formulas take, in SI units."""
        parameters = {name: number(value) for name, value in self.parameters.items()}
        friction = type(self.friction)(*(number(value) for value in self.friction))
        return self.system.body(parameters, friction)

    @cached_property
    def scales(self) -> Scales:
        """Internal units: the system's mass and length, and the power of two seconds that is nearest sqrt(length/g).

        A power of two, so that times convert without rounding: output and event times are exact.
        """
        body = self.body(self.exact)
        mass, length = self.system.units(body, self.form)
        time = 2.0 ** round(math.log2(math.sqrt(float(length) / float(body.g))))
        return Scales(mass, length, self.exact(time))

    @cached_property
    def internal_body(self) -> Any:
        """The body in internal units; what is 0 or 1 by construction is exactly that."""
        body = self.body(self.exact)
        units = leaves(self.system.body_units(self.friction_units))
        scaled = iter([value / self.scales.of(unit) for value, unit in zip(leaves(body), units, strict=True)])
        folds = self.system.folds(self.form).items()
        return refill(body, scaled)._replace(**{name: self.exact(v) for name, v in folds})

    @cached_property
    def variables(self) -> Variables:
        """What is integrated."""
        return Variables(self.form, self.orientation)

    def weights(self) -> list:
        """SI value of one internal unit of each integrated variable."""
        return self.variables.weights(self.scales)

    def start(self) -> np.ndarray:
        """The internal state at t = 0, in the working precision, as the integrator wants it."""
        exact, data = self.exact, self.initial
        theta = np.array([exact(data.get("theta", 0.0))], dtype=exact)
        s, z = np.sin(theta), np.cos(theta)
        if data.get("theta") == math.pi:  # what a person means who writes 3.141592653589793
            s, z = 0 * s, 0 * z - 1
        given = {k: v if isinstance(v, bool) else np.array([exact(v)], dtype=exact) for k, v in data.items()}
        body = self.body(lambda value: np.array([exact(value)], dtype=exact))
        euler = self.system.start(given, s, z, body)
        q, carried = self.variables.start(given, euler, s, z, body)
        zero = 0 * theta
        values = [(component + zero)[0] / w for component, w in zip((*q, *carried), self.weights(), strict=True)]
        return np.array([self.number(v) for v in values], dtype=self.number)

    def internal_time(self, t: Any) -> Any:
        """Times in internal units, exactly."""
        return t / float(self.scales.of(SECOND))
