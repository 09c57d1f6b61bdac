"""Records that describe a system: formulas, names and units; nothing numerical.

The modules of `systems` make a `System` for each kind of top, users register their own. `problem`,
`engine` and `library` read it; nothing else depends on the kind of a top.
"""

from __future__ import annotations

import dataclasses
from collections import ChainMap, namedtuple
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple, cast

from ..errors import InputError, refuse_unknown, unknown_key
from .described import Described
from .event import NUMBERED, Event
from .form import Domain, Exit, Form, Integral, Orientation, Phase, Quantity, all_are
from .number import Alternative, Number
from .readonly import freeze
from .units import Unit


__all__ = [
    "Alternative",
    "Domain",
    "Exit",
    "Form",
    "Integral",
    "Landscape",
    "Momentum",
    "Number",
    "Opening",
    "Orientation",
    "Outlook",
    "Phase",
    "Quantity",
    "System",
    "of_one_phase",
]


class Momentum(NamedTuple):
    """A momentum of the effective potential: an axis of the landscape, and a column of a run."""

    symbol: str  # of the axis: D, lambda, L3, Lz
    unit: Unit
    long_name: str
    rate: Unit  # of dF by this momentum: joules per unit of it
    column: str  # of a run


@dataclass(frozen=True)
class Landscape:
    """Formulas of the effective potential V(z; first, second momentum) of a system.

    Law: V of the coefficients at q = (1 - up z)/(1 + up z) is `System.potential` at z, where q = 0,
    z = up = +1 or -1 is the pole at which the centre of mass is lowest.
    """

    momenta: tuple[Momentum, Momentum]
    # coefficients(body) -> PotentialCoefficients, in the numbers of the body
    coefficients: Callable
    # two_wells(body): whether V can have two minima; None: it never has
    two_wells: Callable | None = None
    # the column of a run that is compared with V
    energy: str = "modified_energy"

    @property
    def symbols(self) -> tuple[str, str]:
        """Return the symbols of the two momenta."""
        return self.momenta[0].symbol, self.momenta[1].symbol

    @property
    def columns(self) -> tuple[str, str, str]:
        """Return the columns of a run that place it in its landscape.

        They are two momenta and the energy.
        """
        return self.momenta[0].column, self.momenta[1].column, self.energy


class Outlook(NamedTuple):
    """Predictions of theory for a start; a field without a prediction is empty."""

    regime: str = ""  # the stable states, a sentence
    fate: str = ""  # where the motion ends
    thresholds: Mapping[str, Any] = {}  # name -> theory.thresholds.Threshold


class Opening(NamedTuple):
    """Properties of a body whose contact may open."""

    # whether it moves in a plane
    planar: bool = False
    # whether it is a sphere, which may have a stem
    sphere: bool = False
    # whether it has an outline, and is a different ball at each inclination
    outlined: bool = False
    # angles and form of the rows of a body without an axis of symmetry
    framed: Any = ()
    # domains of its rows
    domains: tuple[Domain, ...] = ()
    # Routh's function of the gliding body, if it has one
    routh: Callable | None = None
    # outlook(b, start, rules) -> Outlook
    outlook: Callable | None = None
    # quantities of the gliding body that are not columns of its phases
    without: tuple[str, ...] = ()

    @property
    def rounded(self) -> bool:
        """Return whether there may be a contact disc: a rounded contact of a body with an axis."""
        return self.sphere or self.outlined


def _same(value: Any) -> Any:
    """Return the value: the default of conversions of a System."""
    return value


@dataclass(frozen=True, eq=False, repr=False)  # a key of caches: compared by identity
class System(metaclass=Described):
    """A mechanical system: its body, equations, columns, events and theory.

    `replace(**changes)` returns a changed copy, in which `forms`, `quantities` and `events` are
    those of the first phase. docs/how-to/a-system.md explains each field.

    Parameters
    ----------
    name, title, source : str
        The name in TOML, a description, and the publication.
    parameters, initial : dict of Number
        The numbers of the body and of the start, by name.
    surroundings : dict of Number
        The numbers of the air and of the plane, by dotted key such as `air.c1`; empty: the air is
        still and the plane level. `body` finds them among its parameters.
    body, body_units : callable
        body(parameters, friction) -> the NamedTuple `b` that every formula takes, in SI units;
        body_units(units of the friction record) -> the same, filled with units; by default `body`
        of units.
    scales : callable
        scales(b) -> the mass [kg] and the length [m] that are 1 while it is integrated.
    normalised_to : dict of float
        Fields of `b` that are always 0 or 1 in these units.
    start : callable
        start(data, sin_theta, cos_theta, b) -> the record of angles, SI, of the initial numbers
        `data` that the user gives.
    angles : NamedTuple
        The variables that users read, each field filled with its unit; `start` returns such a
        record.
    phases : dict of Phase
        The phases of the contact by name. A run starts in the first one, unless its initial data
        determine another.
    integrals : tuple of str
        Names of the conserved quantities, whose drift is reported.
    long_names : dict of str
        Words for the fields of `angles` and for `vectors`.
    vectors : dict of tuple of str
        Vectors that users read: the names of their components, variables of the form `vector`.
    undefined_at_poles : tuple of str
        Fields of `angles` that are undefined where sin(theta) = 0.
    checks : callable
        checks(parameters) -> messages on numbers that do not fit together.
    alternatives : tuple of Alternative
        Initial data that determine the same numbers in another way.
    laws : dict
        The friction laws that it takes, by name; empty if nothing glides.
    potential, theta_inertia : callable
        `potential(z, *momenta, b)` -> V and `theta_inertia(z, b)` -> the factor J of
        E~ = J theta'^2 + V.
    momenta : tuple of str
        The quantities that V takes.
    landscape : Landscape
        V in the variable of the landscape; None: no minimal surface and no band.
    outlook : callable
        outlook(b, start) -> Outlook, the predictions of theory; start: the quantities at t = 0 by
        name; all SI. A system whose contact has phases gets its ContactLaw as a third argument.
    motion : callable
        motion(b, start) -> the name of the motion, if theory has one.
    borders : callable
        borders(b) -> {label: |lambda|}, the limits of regimes in a map of many tops, SI: b has
        arrays, (n,). A label is symbols, a colon and words: figures write the symbols as formulas.
    inverts : bool
        Whether friction can turn the body over; its inversion is then always reported.
    on_request : tuple of Quantity
        Quantities that are columns only of runs that request them.
    classes : tuple of str
        Outcomes that apply, of "tumbling", "upright", "inverted"; if several fit, the last counts.
    tables : dict
        Further tables of a run: units or flag meanings by column.
    contact, opening
        The contact law of a body whose contact may open, and the records of its phases: see
        `mechanics.contact.opening`; None: the contact does not open.
    common : Phase
        Forms, columns and events of the rows of all phases; by default those of the first phase.
    read : callable
        read(phase, q, carried, b) -> the state of the common form within a phase, and its body; by
        default leave(q, b), and b.
    begin : callable
        begin(x, world) -> Next, the beginning of a run; by default it begins in the first phase.
    assembled : callable
        assembled(b, rules, internal) -> the body of the world, and the phases; by default b and
        `phases`.
    """

    name: str
    parameters: dict[str, Number]
    phases: dict[str, Phase]
    title: str = ""
    source: str = ""
    body: Any = None
    body_units: Any = None
    scales: Callable = lambda b: (1.0, 1.0)
    normalised_to: dict[str, float] = field(default_factory=dict)
    initial: Any = None
    surroundings: Mapping[str, Number] = field(default_factory=dict)
    start: Any = None
    angles: Any = None
    integrals: tuple[str, ...] = ()
    long_names: dict[str, str] = field(default_factory=dict)
    vectors: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    undefined_at_poles: tuple[str, ...] = ()
    checks: Callable = lambda parameters: []
    alternatives: tuple[Alternative, ...] = ()
    laws: Mapping[Any, Any] = field(default_factory=dict)
    potential: Callable | None = None
    theta_inertia: Callable | None = None
    momenta: tuple[str, ...] = ()
    landscape: Landscape | None = None
    outlook: Callable | None = None
    motion: Callable | None = None
    borders: Callable | None = None
    inverts: bool = False
    contact: Any = None
    on_request: tuple[Quantity, ...] = ()
    classes: tuple[str, ...] = ()
    opening: Opening | None = None
    common: Phase | None = None
    read: Callable = lambda phase, q, carried, b: (phase.leave(q, b), b)
    begin: Callable | None = None
    assembled: Callable | None = None
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the phases, derive what follows from them, and make mappings read-only."""
        if not (self.phases and all_are(self.phases, Mapping, Phase)):
            found: Any = self.phases
            if isinstance(found, Mapping):
                found = {name: type(phase).__name__ for name, phase in found.items()}
            raise InputError(
                f"`phases` of `{self.name}` must be a dict of Phase, but is {found!r:.60}."
            )
        self._derive()
        freeze(self, "parameters", "initial", "normalised_to", "phases", "long_names", "vectors")
        if isinstance(self.laws, dict | ChainMap):  # a view: friction.LAWS may grow
            object.__setattr__(self, "laws", MappingProxyType(self.laws))

    def _derive(self) -> None:
        """Fill the fields that are not given, in place, although the record is frozen.

        They are derived from the parameters and the state of the first phase. The places of phases
        and of exits in `tables` are their numbers in stores.
        """
        given: dict[str, Any] = {} if self.title != "" else {"title": self.name}
        if self.body is None and all_are(self.parameters, Mapping, Number):
            record = cast(Any, namedtuple)("Body", [*self.parameters, "friction"], rename=True)
            given["body"] = lambda parameters, friction: record(*parameters.values(), friction)
        if self.body_units is None:
            body = given.get("body", self.body)
            given["body_units"] = lambda friction: body(
                {name: rule.unit for name, rule in self.parameters.items()}, friction
            )
        angles = self.angles
        if angles is None:
            angles = given["angles"] = self.phase.form.units
        fields = getattr(angles, "_fields", ())
        if self.initial is None and fields:
            given["initial"] = {
                name: Number(unit, name, default=0.0) for name, unit in angles._asdict().items()
            }
        if self.start is None and fields:
            make = type(angles)._make
            given["start"] = lambda data, s, z, b: make(data.get(name, 0 * z) for name in fields)
        rules = given.get("initial", self.initial)
        if not self.long_names and all_are(rules, Mapping, Number):
            given["long_names"] = {
                name: rules[name].long_name if name in rules else name for name in fields
            }
        if not self.tables and self.is_hybrid:
            ways = [way.event for phase in self.phases.values() for way in phase.exits]
            given["tables"] = {
                "phases": {"phase": tuple(self.phases), "reason": ("start", *dict.fromkeys(ways))}
            }
        for name, value in given.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"<System {self.name}: {self.title}>"

    def __copy__(self) -> System:
        return self

    def __deepcopy__(self, memo: Any) -> System:
        return self

    def body_of(
        self, parameters: Mapping[str, Any], friction: Any, number: Callable = _same
    ) -> Any:
        """Return the record that formulas take, in SI units.

        It is made of parameters by name and the record of a friction law.

        Parameters
        ----------
        parameters
            Numbers or arrays (n,) by name, SI; those of surroundings by dotted key.
        friction
            The record of a friction law, numbers or arrays (n,), SI.
        number
            Applied to each of them: a type, or what makes arrays of one shape.

        Returns
        -------
        NamedTuple
            The body, `b` of every formula.

        Raises
        ------
        KeyError
            If a parameter is missing.
        """
        given = {name: number(parameters[name]) for name in (*self.parameters, *self.surroundings)}
        return self.body(given, friction._make(map(number, friction)))

    def faults(self, parameters: Mapping[str, float]) -> list[str]:
        """Return messages on parameters that are wrong, one by one or together.

        The numbers are checked one by one, then together.
        """
        faults = []
        for name, rule in self.parameters.items():
            if name not in parameters:
                faults.append(f"`parameters.{name}` must be given, but is missing.")
            elif rule.broken(parameters[name]):
                faults.append(rule.fault(f"parameters.{name}", parameters[name]))
        unknown = [name for name in parameters if name not in self.parameters]
        faults += [unknown_key(f"parameters.{name}", self.parameters) for name in unknown]
        return faults or list(self.checks(parameters))

    @property
    def record_names(self) -> set[str]:
        """Names of the events and of the quantities."""
        return {event.name for event in self.events} | {q.name for q in self.quantities}

    def clashes(self, initial: Mapping[str, Any], verb: str = "is given") -> list[str]:
        """Return messages on initial data that determine the same number in two ways.

        Parameters
        ----------
        initial
            Initial data by name; flags that are false count as not given.
        verb
            The verb of the message for the others.

        Returns
        -------
        list of str
            Empty if each datum is given once.
        """
        given = {name for name, value in initial.items() if value is not False}
        return [
            a.fault(verb)
            for a in self.alternatives
            if a.name in given and not given.isdisjoint(a.others)
        ]

    def rivals(self, name: str) -> set[str]:
        """Return the initial numbers that cannot be given together with the number `name`."""
        names: set[str] = set()
        for alternative in self.alternatives:
            if not alternative.flag and name == alternative.name:
                names.update(alternative.others)
            elif not alternative.flag and name in alternative.others:
                names.add(alternative.name)
        return names

    def replaced(self, initial: Mapping[str, Any], changed: Mapping[str, Any]) -> dict[str, Any]:
        """Return initial data with changes.

        A number replaces those that determine the same in another way.

        Parameters
        ----------
        initial
            The present values by name.
        changed
            The values that replace them.

        Returns
        -------
        dict
            Both, without numbers that `changed` determines in another way.
        """
        rivals = {rival for name in changed for rival in self.rivals(name)}
        return {**{name: value for name, value in initial.items() if name not in rivals}, **changed}

    @property
    def is_hybrid(self) -> bool:
        """Return whether runs go from phase to phase, so that `engine.hybrid` integrates them."""
        return self.begin is not None or any(phase.exits for phase in self.phases.values())

    @property
    def phase(self) -> Phase:
        """Return the phase whose form rows have: the common one, or else the first."""
        return self.common or next(iter(self.phases.values()))

    @property
    def forms(self) -> dict[str, Form]:
        """Return the forms of its rows."""
        return self.phase.forms

    @property
    def quantities(self) -> Sequence[Quantity]:
        """Return the quantities of its rows."""
        return self.phase.quantities

    @property
    def events(self) -> Sequence[Event]:
        """Return the events that every phase has."""
        return self.phase.events

    def replace(self, **changes: Any) -> System:
        """Return the system with other fields.

        `forms`, `quantities` and `events` are those of the first phase.

        The predictions of theory (`outlook`) are kept: pass None if you change the equations.
        """
        of_phase = {"forms", "quantities", "events", "exits"}
        refuse_unknown("System.replace", changes, {*vars(self), *of_phase})
        given = {key: changes.pop(key) for key in changes.keys() & of_phase}
        phase = dataclasses.replace(self.phase, **given)
        if self.common:
            changes.setdefault("common", phase)
        else:
            changes.setdefault("phases", {**self.phases, next(iter(self.phases)): phase})
        return dataclasses.replace(self, **changes)

    def with_requested(self, columns: Collection[str]) -> System:
        """Return the system with those of its quantities on request that are named.

        Equal names give the same record.

        Parameters
        ----------
        columns
            Names of columns.

        Returns
        -------
        System
            This one, where none is named, or where the contact may change its phase.
        """
        asked = self.on_request if self.contact is None else ()
        return self.with_records(
            (), tuple(q for q in asked if q.name in columns and q not in self.quantities)
        )

    @lru_cache(maxsize=64)  # noqa: B019 - a system is compiled only once
    def with_records(self, events: tuple[Event, ...], quantities: tuple[Quantity, ...]) -> System:
        """Return the system with more events and columns.

        Cached, so that equal records give the same object: compiled equations are cached by it. The
        records must be hashable, hence the tuples.
        """
        if not (events or quantities):
            return self
        return self.replace(
            events=(*self.events, *events), quantities=(*self.quantities, *quantities)
        )

    def folds(self, form: Form) -> dict[str, float]:
        """Return the numbers of the body that are 0 or 1 in the units of a form, by name.

        They become constants of the compiled equations.
        """
        return {
            name: value
            for name, value in self.normalised_to.items()
            if name not in form.not_normalised
        }

    @property
    def kinds(self) -> tuple[str, ...]:
        """Return the names of the kinds of events in its logs, by their numbers in a store.

        The numbered kinds come first, whether the system has them or not.
        """
        return (*NUMBERED, *(event.name for event in self.events if event.name not in NUMBERED))

    @property
    def frictional(self) -> bool:
        """Return whether a friction law must be given."""
        return bool(self.laws)


def of_one_phase(
    phase: str,
    *,
    forms: dict[str, Form],
    quantities: Sequence[Quantity],
    events: Sequence[Event],
    **rest: Any,
) -> System:
    """Return a system whose contact never changes.

    Parameters
    ----------
    phase
        Its name, such as "gliding".
    forms, quantities, events
        As of a `Phase`.
    **rest
        The other fields of a `System`.

    Returns
    -------
    System
    """
    return System(phases={phase: Phase(forms, quantities, events)}, **rest)
