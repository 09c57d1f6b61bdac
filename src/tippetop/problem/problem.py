"""One run: a checked body, a start and a span, all in SI units.

`scenario.build` makes a `Problem`; `engine` and `runs` integrate it. Numbers are kept in SI units,
and converted to internal ones by `Problems`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import heyoka as hy
import numpy as np

from ..mechanics.caching import cached_property
from ..mechanics.contact.body import BALLS, seen_from_balls
from ..mechanics.contact.restitution import CONTACT, STEM, ContactLaw, stem_faults
from ..mechanics.contact.surroundings import RULES, by_table
from ..mechanics.friction import FrictionLaw
from ..mechanics.operand import refill
from ..mechanics.readonly import freeze
from ..mechanics.system import Form, Number, System
from ..mechanics.units import Scales, Unit
from ..mechanics.variables import Variables, variables_of
from ..sampling import EvenTimes, ListedTimes
from .batch import Problems
from .options import KEYFRAME_STEPS, OPTIONS, UNTIL, RunOptions
from .row_columns import column_names


# The form: the first of the system, which is, of those that are regular everywhere and keep every
# column exact, the cheapest. The motion alone is a tenth cheaper in the reduced form of a rolling
# top. But phi' has poles where z = cos(theta) is 1 or -1, nearer in complex time than those of z,
# which controls the step: after 4 s phi is wrong by 2e-12 where theta stays above 0.51 rad, and by
# 1.5e-8 above 0.15 rad; about the contact by 1e-14.
AUTO = "auto"
PRECISIONS: dict[str, Any] = {"double": np.float64, "longdouble": np.longdouble, "quad": hy.real128}


@dataclass(frozen=True, kw_only=True, repr=False)
class Problem(RunOptions):
    """One run: a checked scenario in SI units; `tippetop.load` makes one.

    Its other fields are the options of the run, `RunOptions`, with every default filled in.

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
    surroundings
        Numbers of the air and of the plane by dotted key, such as `air.c1`; see `System`.
    origin
        The end of another run, where this one starts exactly, as `starting.problem_from_tables`
        makes it and stores keep it (`start`); `initial` contains it rounded.
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
    contact: ContactLaw | None = None
    surroundings: dict[str, float] = field(default_factory=dict)
    origin: dict[str, Any] | None = None
    checked: ClassVar[bool] = False  # a copy by dataclasses.replace is not checked

    def __post_init__(self) -> None:
        """Derive `output_step` and `output_times`, of which one at most is not None."""
        if isinstance(self.times, np.ndarray):
            object.__setattr__(self, "times", ListedTimes(self.times))
        step, listed = (getattr(self.times, name, None) for name in ("step", "times"))
        object.__setattr__(self, "output_step", step)
        object.__setattr__(self, "output_times", None if listed is None else tuple(listed.tolist()))
        freeze(self, "parameters", "initial", "surroundings", "origin")

    def __reduce__(self) -> Any:
        """Return how to make the problem again: by its fields, with the form by its name."""
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
        """The type of the numbers that are integrated: float, longdouble or heyoka's real128."""
        return PRECISIONS[self.precision]

    @cached_property
    def exact(self) -> Any:
        """The number type in which units are converted: never less than 80 bits."""
        return np.longdouble if self.precision == "double" else self.number

    @property
    def law(self) -> type[FrictionLaw]:
        """The class of the friction law (not its numbers); it knows names and units of these."""
        return type(self.friction)

    @cached_property
    def tables(self) -> dict[str, dict[str, Any]]:
        """The numbers that are given, by table and name; `build.resolved` makes scenarios of it."""
        tables = {"parameters": dict(self.parameters), "friction": self.friction._asdict()}
        contact = self.contact
        if contact is not None:
            tables["contact"] = {"e_n": contact.e_n}
            if contact.stem:
                tables["stem"] = {"r": contact.r, "h": contact.h}
        tables |= by_table(self.surroundings)
        return tables | {"initial": dict(self.initial), "run": {"until": self.until}}

    @cached_property
    def rules(self) -> dict[str, Number]:
        """The records of the numbers, by dotted key: the keys that may vary."""
        law = self.law.parameters if self.system.frictional else {}
        tables = numbers_of(self.system, law) | by_table(self.system.surroundings)
        tables["run"] = {"until": UNTIL}
        return {
            f"{t}.{name}": rule
            for t, rules in tables.items()
            if t in self.tables
            for name, rule in rules.items()
        }

    def clashes(self) -> list[str]:
        """Return sentences on initial data, and on a stem, that contradict each other."""
        faults = self.system.clashes(self.initial)
        if self.contact is not None and self.contact.stem:
            faults += stem_faults(self.parameters["R"], self.contact.r, self.contact.h)
        return faults

    @property
    def joint(self) -> Mapping[str, Any]:
        """Return the phase and the signs of events with which another run ended: `Driver.joint`.

        It is empty unless the run starts there.
        """
        return (self.origin or {}).get("joint", {})

    @cached_property
    def alone(self) -> Problems:
        """This run as the only one of its `Problems`, which compute its numbers.

        If it starts from the end of another run (`origin`) in the same form, which had all its
        variables, it has the exact state; otherwise its state is computed of the initial data.
        """
        origin = self.origin
        names = self.variables.names
        state = None
        if (
            origin is not None
            and origin["form"] == self.form.name
            and {*names} <= origin["state"].keys()
        ):
            # doubles to be added, as `starting.problem_from_tables` keeps them
            values = [[sum(map(self.number, origin["state"][name]))] for name in names]
            state = np.array(values, dtype=self.number)
        return Problems(self, {}, self.orientation, state)

    def table(self) -> dict[str, Any]:
        """Return the options as the table [run] of a scenario, by key, SI.

        Options that do not apply to this `output`, and None, are left out.
        """
        unused = {
            "times": ("output", "keyframe_steps"),
            "keyframes": ("output_step", "output_times"),
        }.get(self.output, ("output_step", "output_times", "keyframe_steps"))
        given = {name: getattr(self, name) for name in OPTIONS if name not in unused}
        return {
            name: [*value] if isinstance(value, tuple) else value
            for name, value in given.items()
            if value is not None
        }

    def body(self, number: Any = float) -> Any:
        """Return the body `b` that formulas take, in SI units; `number` converts each number."""
        given = {**self.parameters, **self.surroundings}
        with np.errstate(all="ignore"):  # numbers that overflow are refused at the start
            return self.system.body_of(given, self.friction, number)

    @property
    def balls(self) -> dict[str, Any]:
        """The body in SI units, seen from each of its balls that may touch the plane, by name."""
        rules = self.contact
        stem = () if rules is None or not rules.stem else (rules.r, rules.h)
        return dict(zip(BALLS, seen_from_balls(self.body(), stem), strict=False))

    @cached_property
    def scales(self) -> Scales:
        """The internal units of mass, length and time; see `Problems.scales`."""
        return self.alone.scales

    def unit(self, unit: Unit) -> float:
        """Return the SI value of one internal unit of the kind `unit`."""
        return float(self.scales.of(unit))

    @cached_property
    def internal_body(self) -> Any:
        """The body in internal units, in the working precision; see `Problems.internal_body`."""
        return refill(self.alone.internal_body, iter(self.alone.pars[:, 0]))

    @cached_property
    def variables(self) -> Variables:
        """The integrated variables."""
        return variables_of(self.form, self.orientation)

    @property
    def kept_columns(self) -> tuple[str, ...]:
        """The columns that the rows have in addition to the time; see `column_names`."""
        if self.columns is not None:
            return self.columns
        return column_names(self.system, self.form, self.orientation, self.precision)

    def weights(self) -> list:
        """Return the SI value of one internal unit of each integrated variable."""
        return self.alone.weights

    def start(self) -> np.ndarray:
        """Return the internal state at t = 0, (variables,), in the working precision."""
        return self.alone.start[:, 0].copy()


def numbers_of(system: System, law: Mapping[str, Number]) -> dict[str, Mapping[str, Number]]:
    """Return the records of the numbers of a scenario, by table; `law` has those of its law."""
    return {
        "parameters": system.parameters,
        "friction": law,
        "initial": system.initial,
        "contact": CONTACT,
        "stem": STEM,
        **RULES,
    }


def _again(form: str, given: dict[str, Any]) -> Problem:
    """Return the problem of a pickle, which names the form: its formulas cannot be pickled."""
    return Problem(form=given["system"].forms[form], **given)
