"""One run: a checked body, a start and a span, all in SI units."""

import dataclasses
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

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
from .options import KEYFRAME_STEPS, UNTIL, RunOptions


PRECISIONS: dict[str, Any] = {"double": np.float64, "longdouble": np.longdouble, "quad": hy.real128}


@dataclass(frozen=True, kw_only=True, repr=False)
class Problem(RunOptions):
    """One run: what a scenario says, checked. All numbers in SI units; `tippetop.load` makes one.

    Its other fields are the options of the run, `RunOptions`, every default filled in.

    Parameters
    ----------
    system, form
        The equations, and how their state is written.
    parameters, friction, initial
        Numbers of the body by name; the record of a friction law; the initial data that were given.
    times
        The times [s] of the rows, which decide `output_step` or `output_times`.
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
    times: EvenTimes | ListedTimes
    output_step: float | None = field(init=False, compare=False)
    output_times: tuple[float, ...] | None = field(init=False, compare=False)
    events: tuple[str, ...]
    on_liftoff: Literal["stop", "continue", "fly"] = "stop"
    keyframe_steps: int = KEYFRAME_STEPS
    orientation: bool = True
    sensitivities: tuple[str, ...] = ()
    contact: ContactLaw | None = None
    origin: dict[str, Any] | None = None
    checked: ClassVar[bool] = False  # of one that was: what dataclasses.replace makes of it was not

    def __post_init__(self) -> None:
        if isinstance(self.times, np.ndarray):
            object.__setattr__(self, "times", ListedTimes(self.times))
        step, listed = (getattr(self.times, name, None) for name in ("step", "times"))
        object.__setattr__(self, "output_step", step)
        object.__setattr__(self, "output_times", None if listed is None else tuple(listed.tolist()))
        freeze(self, "parameters", "initial", "origin")

    def __reduce__(self) -> Any:
        given = {
            f.name: getattr(self, f.name)
            for f in dataclasses.fields(self)
            if f.init and f.name != "form"
        }
        return _again, (self.form.name, given)

    def __repr__(self) -> str:
        start = ", ".join(f"{name} = {value:.6g}" for name, value in self.initial.items())
        return (
            f"<Problem of {self.system.name}, {self.form.name} form: {start}; until "
            f"{self.until:.6g} s>"
        )

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
        tables = {
            "parameters": self.system.parameters,
            "friction": friction,
            "initial": self.system.initial,
        }
        tables |= {name: {"contact": CONTACT, "stem": STEM}[name] for name in self._contact()}
        return {
            f"{table}.{name}": rule
            for table, rules in tables.items()
            for name, rule in rules.items()
        } | {"run.until": UNTIL}

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
        """Return sentences on what numbers break together that are right one by one, but for those
        of the body.
        """
        faults = self.system.clashes(given_names(self.initial))
        if self.contact is not None and self.contact.stem:
            faults += stem_faults(self.parameters["R"], self.contact.r, self.contact.h)
        return faults

    @property
    def choice(self) -> Choice:
        """The form that `form = "auto"` takes, and why."""
        return choice(self.system)

    def start_faults(self) -> list[str]:
        """Why there is no motion from the start, in sentences; of numbers that are right one by
        one.
        """
        return [sentence for _, sentence in self.alone.check()[1]]

    @cached_property
    def alone(self) -> Problems:
        """This run as the one of its `Problems`."""
        origin, names = self.origin, self.variables.names
        if (
            origin is None
            or origin["form"] != self.form.name
            or not set(names) <= set(origin["state"])
        ):
            return Problems(self, {}, self.orientation)
        state = np.array(
            [[sum(map(self.number, origin["state"][name]))] for name in names], dtype=self.number
        )
        return StartedFrom(self, {}, self.orientation, state)

    def table(self) -> dict[str, Any]:
        """Return the options as the table [run] of a scenario, without those that do not apply."""
        table = super().table()
        without = {
            "times": ["output", "keyframe_steps"],
            "keyframes": ["output_step", "output_times"],
        }
        for name in without.get(self.output, ["output_step", "output_times", "keyframe_steps"]):
            table.pop(name, None)
        if not self.sensitivities:
            del table["sensitivities"]
        return table

    def body(self, number: Any = float) -> Any:
        """The record that formulas take, in SI units."""
        return self.system.body_of(self.parameters, self.friction, number)

    @cached_property
    def scales(self) -> Scales:
        """The units of mass, length and time in which the run is integrated; see
        `Problems.scales`.
        """
        return Scales(*(unit[0] for unit in self.alone.scales))

    @cached_property
    def internal_body(self) -> Any:
        """The body in internal units, in the working precision; what is 0 or 1 by construction is
        exactly that.
        """
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
        return [np.atleast_1d(weight)[0] for weight in self.alone.weights]

    def start(self) -> np.ndarray:
        """The internal state at t = 0, (variables,), in the working precision, as the integrator
        wants it.
        """
        return self.alone.start[:, 0].copy()

    def internal_time(self, t: Any) -> Any:
        """Times in internal units, exactly."""
        return t / float(self.scales.of(SECOND))


def _again(form: str, given: dict[str, Any]) -> Problem:
    """The problem of a pickle."""
    return Problem(form=given["system"].forms[form], **given)
