"""What a system is: records of formulas, names and units; nothing numerical."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .events import Event, kinds
from .units import Unit


@dataclass(frozen=True)
class Parameter:
    """A number that the user gives: its unit, its meaning, and the open or closed interval it must lie in."""

    unit: Unit
    long_name: str
    above: float | None = None  # must be greater than
    least: float | None = None  # must be at least
    below: float | None = None  # must be less than
    most: float | None = None  # must be at most

    def _bounds(self) -> list[tuple[str, float, Callable]]:
        """The bounds that are set: what a value must be, the limit, and how a value breaks it."""
        bounds = (
            ("greater than", self.above, np.less_equal),
            ("at least", self.least, np.less),
            ("less than", self.below, np.greater_equal),
            ("at most", self.most, np.greater),
        )
        return [(words, float(limit), breaks) for words, limit, breaks in bounds if limit is not None]

    def broken(self, values: Any) -> Any:
        """Where values lie outside the interval or are not finite: a mask of their shape."""
        broken = ~np.isfinite(values)
        for _, limit, breaks in self._bounds():
            broken = broken | breaks(values, limit)
        return broken

    def must(self, value: float | None = None) -> str:
        """What must hold, as in "must be finite, greater than 0"; of a value: the first thing that it breaks."""
        if value is None:
            return "must be finite" + "".join(f", {words} {limit:g}" for words, limit, _ in self._bounds())
        broken = [f"{words} {limit}" for words, limit, breaks in self._bounds() if breaks(value, limit)]
        return f"must be {broken[0]}" if broken and np.isfinite(value) else "must be a finite number"

    def fault(self, key: str, value: float) -> str:
        """The sentence on a value that is broken."""
        return f"`{key}` {self.must()}, but is {value:.17g}."


class Alternative(NamedTuple):
    """An initial datum that says in another way what others say: it stands alone, without any of `others`."""

    name: str
    others: tuple[str, ...]
    flag: bool = False  # true or false, not a number

    def fault(self, verb: str) -> str:
        """The sentence on data that are not alone; `verb` says how the others come: they are given, or vary."""
        others = " or ".join(f"`initial.{other}`" for other in self.others)
        return f"`initial.{self.name}` must stand alone, but {others} {verb} too."


@dataclass(frozen=True)
class Quantity:
    """A function of the scalars of a form, hence of no form in particular: formula(scalars, b)."""

    name: str
    symbol: str
    unit: Unit
    long_name: str
    formula: Callable


class Hazard(NamedTuple):
    """A scalar function that must stay positive, and what it means when it does not."""

    formula: Callable  # formula(scalars, b)
    meaning: str


@dataclass(frozen=True)
class Form:
    """A way to write the state of a system.

    Law: `scalars` of two forms agree through the chart, and the chart commutes with the flow.
    """

    name: str
    units: Any  # the state record (a NamedTuple) filled with the unit of each variable
    rates: Callable  # rates(q, b) -> the same record: the time derivatives
    scalars: Callable  # scalars(q, b) -> what the quantities are written in
    of_angles: Callable  # of_angles(angles, sin_theta, cos_theta, b) -> q
    to_angles: Callable  # to_angles(q, b) -> record of angles
    quadratures: tuple[str, ...] = ()  # variables that the equations do not read: they must not control the step
    hazards: tuple[Hazard, ...] = ()  # where the form or the model breaks down
    stretch: float = 1.0  # the form's unit of length, in that of the system
    unfolded: tuple[str, ...] = ()  # what is then no longer 1


class Momentum(NamedTuple):
    """One of the two momenta that the effective potential takes: an axis of the landscape, a column of a run."""

    symbol: str  # of the axis: D, lambda, L3, Lz
    unit: Unit
    long_name: str
    rate: Unit  # of dF by this momentum: joules per unit of it
    column: str  # of a run


@dataclass(frozen=True)
class Landscape:
    """What the effective potential V(z; first, second momentum) of a system is made of. [section 5, 8]

    Law: V of the coefficients at q = (1 - upright z)/(1 + upright z) is `System.potential` at z.
    """

    momenta: tuple[Momentum, Momentum]
    coefficients: Callable  # coefficients(body) -> PotentialCoefficients, in the numbers of the body
    upright: int  # +1, -1: z = cos(theta) at q = 0
    two_wells: Callable | None = None  # two_wells(body) < 0 iff V can have two minima; None: it never has
    energy: str = "modified_energy"  # the column of a run that is compared with V

    @property
    def symbols(self) -> tuple[str, str]:
        """The symbols of the two momenta."""
        return self.momenta[0].symbol, self.momenta[1].symbol

    @property
    def columns(self) -> tuple[str, str, str]:
        """The columns of a run that place it in its landscape: two momenta and the energy."""
        return self.momenta[0].column, self.momenta[1].column, self.energy


class Outlook(NamedTuple):
    """What theory predicts of a start; an empty field where it says nothing."""

    regime: str = ""  # what is stable, a sentence
    fate: str = ""  # where the motion ends
    thresholds: Mapping[str, Any] = {}  # name -> theory.thresholds.Threshold


def _same(value: Any) -> Any:
    return value


@dataclass(frozen=True, eq=False)  # a key of caches: compared by identity
class System:
    """A mechanical system: everything that the rest of the package needs to know of it."""

    name: str
    title: str
    source: str
    parameters: dict[str, Parameter]
    body: Callable  # body(parameters, friction) -> the record that every formula takes, SI
    body_units: Callable  # body_units(friction units) -> that record filled with units
    scales: Callable  # scales(b) -> mass [kg] and length [m] that become 1
    folded: dict[str, float]  # what is 0 or 1 in these units by construction: the expressions fold
    initial: dict[str, Parameter]
    start: Callable  # start(data, sin_theta, cos_theta, b) -> record of angles, SI
    angles: Any  # the record that people read and write (a NamedTuple) filled with units
    forms: dict[str, Form]
    quantities: Sequence[Quantity]
    integrals: tuple[str, ...]  # conserved quantities, by name: their drift is reported
    events: Sequence[Event]
    long_names: dict[str, str]  # of the variables of the Euler record and of `vectors`
    vectors: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # name -> variables of the vector form
    checks: Callable = field(default=lambda parameters: [])  # sentences on what parameters break together
    alternatives: tuple[Alternative, ...] = ()  # initial data that say the same in two ways
    laws: Any = field(default_factory=dict)  # the friction laws that it takes, by name; none where nothing glides
    potential: Callable | None = None  # V(z, *momenta, b) of E~ = theta_inertia(z, b) theta'^2 + V
    theta_inertia: Callable | None = None
    momenta: tuple[str, ...] = ()  # the quantities that V takes
    landscape: Landscape | None = None  # V in the variable of the landscape; None: no surface, no band
    outlook: Callable | None = None  # outlook(b, start) -> Outlook; start: the quantities at t = 0 by name; all SI
    motion: Callable | None = None  # motion(b, start) -> the name of the motion, where theory has one
    borders: Callable | None = None  # borders(b) -> {words: |lambda| there}: regimes in a map of many tops, SI
    long_form: str = ""  # the form that keeps E over runs of 1e5 s and more, if another one does not
    inverts: bool = False  # friction can turn it over: its inversion is reported even where there was none
    classes: tuple[str, ...] = ()  # names of its end, of "tumbling", "upright", "inverted"; the last that fits counts

    def body_of(self, parameters: Mapping[str, Any], friction: Any, number: Callable = _same) -> Any:
        """The record that formulas take, in SI units: of parameters by name and the record of a friction law.

        `number` is applied to each of them: a type, or what makes arrays of one shape.
        """
        given = {name: number(parameters[name]) for name in self.parameters}
        return self.body(given, type(friction)(*(number(value) for value in friction)))

    def faults(self, parameters: Mapping[str, float]) -> list[str]:
        """What is wrong with parameters by name, in sentences: one by one, then together; empty if nothing is."""
        faults, known = [], ", ".join(self.parameters)
        for name, rule in self.parameters.items():
            if name not in parameters:
                faults.append(f"`parameters.{name}` must be given, but is missing.")
            elif rule.broken(parameters[name]):
                faults.append(rule.fault(f"parameters.{name}", parameters[name]))
        for name in parameters:
            if name not in self.parameters:
                faults.append(f"`parameters.{name}` must not be there: known keys are {known}.")
        return faults or list(self.checks(parameters))

    def clashes(self, initial: Collection[str], verb: str = "is given") -> list[str]:
        """Sentences on initial data, by name, of which some say the same in two ways."""
        return [a.fault(verb) for a in self.alternatives if a.name in initial and not set(a.others).isdisjoint(initial)]

    def rivals(self, name: str) -> set[str]:
        """The initial numbers that cannot be given beside another."""
        found = set()
        for alternative in self.alternatives:
            if not alternative.flag and name in (alternative.name, *alternative.others):
                found |= {alternative.name, *alternative.others} - {name}
        return found

    def replaced(self, initial: Mapping[str, Any], changed: Mapping[str, Any]) -> dict[str, Any]:
        """Initial data with some changed: a number takes the place of those that say the same in another way."""
        rivals = {rival for name in changed for rival in self.rivals(name)}
        return {**{name: value for name, value in initial.items() if name not in rivals}, **changed}

    def folds(self, form: Form) -> dict[str, float]:
        """What is 0 or 1 in the units of a form by construction."""
        return {name: value for name, value in self.folded.items() if name not in form.unfolded}

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the kinds of events in its logs, by their numbers in a store."""
        return kinds(self.events)

    @property
    def frictional(self) -> bool:
        """Whether a friction law must be given."""
        return bool(self.laws)
