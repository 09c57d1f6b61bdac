"""One run: a checked body, a start and a span, all in SI units."""

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

import heyoka as hy
import numpy as np

from ..errors import unknown_key
from ..mechanics.caching import cached_property
from ..mechanics.contact.restitution import CONTACT, STEM, ContactLaw, stem_faults
from ..mechanics.friction import FrictionLaw
from ..mechanics.operand import refill
from ..mechanics.readonly import freeze
from ..mechanics.system import Form, Number, System
from ..mechanics.units import SECOND, Scales
from ..mechanics.variables import Variables
from ..sampling import EvenTimes, ListedTimes
from .choice import Choice, choice
from .faults import given_names
from .kept import column_names
from .many import Problems, StartedFrom


PRECISIONS: dict[str, Any] = {"double": np.float64, "longdouble": np.longdouble, "quad": hy.real128}
ROUNDING = {"double": 2.0**-52, "longdouble": 2.0**-63, "quad": 2.0**-112}
KEYFRAME_STEPS = 8192  # 20 to 60 ms of computing: what a replay does before its first row; 0.1 kB a step are 10 of rows
UNTIL = Number(SECOND, "end of the run", above=0, most=1e16)


@dataclass(frozen=True, repr=False)
class Problem:
    """One run: what a scenario says, checked. All numbers in SI units; `tippetop.load` makes one.

    Parameters
    ----------
    system, form
        The equations, and how their state is written.
    parameters, friction, initial
        Numbers of the body by name; the record of a friction law; the initial data that were given.
    until, times
        The end [s], and the times [s] of the rows that are asked for.
    events
        The kinds that are logged.
    on_liftoff
        What happens where the normal force vanishes: "stop", "continue" or "fly".
    precision, tolerance
        "double", "longdouble" or "quad"; the relative error of a step, 0 for the rounding unit of the precision.
    output
        Rows at `times`, at the "events", at the ends of the "steps"; or "keyframes" and no rows.
    keyframe_steps
        Steps from one keyframe to the next.
    stop_when
        "until", or "settled".
    orientation
        Whether the turn of the body about its axis is integrated too.
    columns
        What rows have beside the time; None: all that there are.
    sensitivities
        Dotted numbers by which derivatives of columns and events are kept.
    contact
        Where the contact may change its phase: how it opens and closes.
    origin
        The end of another run, where this one starts exactly; `initial` says it rounded.
    """

    system: System
    form: Form
    parameters: dict[str, float]
    friction: Any
    initial: dict[str, Any]
    until: float
    times: EvenTimes | ListedTimes
    events: tuple[str, ...]
    on_liftoff: str = "stop"
    precision: str = "double"
    tolerance: float = 0.0
    output: str = "times"
    keyframe_steps: int = KEYFRAME_STEPS
    stop_when: str = "until"
    orientation: bool = True
    columns: tuple[str, ...] | None = None
    sensitivities: tuple[str, ...] = ()
    contact: ContactLaw | None = None
    origin: dict[str, Any] | None = None
    checked: ClassVar[bool] = False  # of one that was: what dataclasses.replace makes of it was not

    def __post_init__(self) -> None:
        if isinstance(self.times, np.ndarray):
            object.__setattr__(self, "times", ListedTimes(self.times))
        freeze(self, "parameters", "initial", "origin")

    def __reduce__(self) -> Any:
        given = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.name != "form"}
        return _again, (self.form.name, given)

    def __repr__(self) -> str:
        start = ", ".join(f"{name} = {value:.6g}" for name, value in self.initial.items())
        return f"<Problem of {self.system.name}, {self.form.name} form: {start}; until {self.until:.6g} s>"

    @cached_property
    def number(self) -> Any:
        """The number type of the precision."""
        return PRECISIONS[self.precision]

    @cached_property
    def exact(self) -> Any:
        """The number type in which units are converted: never less than 80 bits."""
        return np.longdouble if self.precision == "double" else self.number

    @property
    def law_name(self) -> str:
        """The name of the friction law, as in `[friction] law`."""
        return self.law.key

    @property
    def law(self) -> type[FrictionLaw]:
        """The friction law: its numbers and their units."""
        return type(self.friction)

    @cached_property
    def tables(self) -> dict[str, dict[str, Any]]:
        """What is given, by table and name."""
        return {
            "parameters": dict(self.parameters),
            "friction": self.friction._asdict(),
            "initial": dict(self.initial),
            "run": {"until": self.until},
            **self._contact(),
        }

    def _contact(self) -> dict[str, dict[str, Any]]:
        """What is given of the contact, where it may change its phase."""
        if self.contact is None:
            return {}
        contact, stem = {"e_n": self.contact.e_n}, {"r": self.contact.r, "h": self.contact.h}
        return {"contact": contact, **({"stem": stem} if self.contact.stem else {})}

    @cached_property
    def rules(self) -> dict[str, Number]:
        """What must hold of the numbers, by dotted key: the keys that may vary."""
        friction = self.law.parameters if self.system.frictional else {}
        tables = {"parameters": self.system.parameters, "friction": friction, "initial": self.system.initial}
        tables |= {name: {"contact": CONTACT, "stem": STEM}[name] for name in self._contact()}
        return {f"{table}.{name}": rule for table, rules in tables.items() for name, rule in rules.items()} | {
            "run.until": UNTIL
        }

    def faults(self) -> list[str]:
        """What is wrong with the numbers that are given, in sentences; empty if nothing is."""
        faults = []
        for table in ("friction", "initial", "run", *self._contact()):
            for name, value in self.tables[table].items():
                key, rule = f"{table}.{name}", self.rules.get(f"{table}.{name}")
                if rule is not None and rule.broken(value):
                    faults.append(rule.fault(key, value))
                if rule is None and not isinstance(value, bool):
                    known = [k.partition(".")[2] for k in self.rules if k.startswith(f"{table}.")]
                    faults.append(unknown_key(key, known, self.rules))
        return [*self.system.faults(self.parameters), *faults, *self.clashes()]

    def clashes(self) -> list[str]:
        """Return sentences on what numbers break together that are right one by one, but for those of the body."""
        faults = self.system.clashes(given_names(self.initial))
        if self.contact is not None and self.contact.stem:
            faults += stem_faults(self.parameters["R"], self.contact.r, self.contact.h)
        return faults

    @property
    def choice(self) -> Choice:
        """The form that `form = "auto"` takes, and why."""
        return choice(self.system)

    def start_faults(self) -> list[str]:
        """Why there is no motion from the start, in sentences; of numbers that are right one by one."""
        return [sentence for _, sentence in self.alone.check()[1]]

    @cached_property
    def alone(self) -> Problems:
        """This run as the one of its `Problems`."""
        origin, names = self.origin, self.variables.names
        if origin is None or origin["form"] != self.form.name or not set(names) <= set(origin["state"]):
            return Problems(self, {}, self.orientation)
        state = np.array([[sum(map(self.number, origin["state"][name]))] for name in names], dtype=self.number)
        return StartedFrom(self, {}, self.orientation, state)

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

    @property
    def kept_columns(self) -> tuple[str, ...]:
        """The columns that the rows have beside the time; see `column_names`."""
        if self.columns is not None:
            return self.columns
        return column_names(self.system, self.form, self.orientation, self.precision)

    def weights(self) -> list:
        """SI value of one internal unit of each integrated variable."""
        return [weight[0] for weight in self.alone.weights]

    def start(self) -> np.ndarray:
        """The internal state at t = 0, (variables,), in the working precision, as the integrator wants it."""
        return self.alone.start[:, 0].copy()

    def internal_time(self, t: Any) -> Any:
        """Times in internal units, exactly."""
        return t / float(self.scales.of(SECOND))


def _again(form: str, given: dict[str, Any]) -> Problem:
    """The problem of a pickle."""
    return Problem(form=given["system"].forms[form], **given)
