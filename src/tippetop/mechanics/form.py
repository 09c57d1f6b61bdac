"""Records of a motion: forms, their integrals and quantities, phases of the contact and exits.

The modules of `systems` and `contact` fill these records with formulas; `engine` compiles and calls
them.

Symbols
    q         the record of the state of a form; carried: that of its integrals; b: the body
    x         the common state, to which every phase of a system can be converted
    n         a `Next`, the result of a jump; world: further arguments of a jump, see `Exit`
    scalars   the record that events and quantities take, the same in every form
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import InputError, is_one_number, names_its_faults
from .described import Described
from .event import Event
from .operand import leaves
from .readonly import ReadOnly
from .units import Unit


@dataclass(frozen=True)
class Quantity(metaclass=Described):
    """A function of the scalars, which every form has: formula(scalars, b).

    Parameters
    ----------
    name, symbol, unit, long_name
        As a column of a run, and as a label of a figure.
    formula
        formula(scalars, b), in any consistent units.
    meanings
        Only for a flag variable: the meaning of each number.
    is_column
        Whether it is stored; otherwise it is used for comparisons only.
    """

    name: str
    symbol: str
    unit: Unit
    long_name: str
    formula: Callable
    meanings: tuple[str, ...] = ()
    is_column: bool = True

    def __post_init__(self) -> None:
        if callable(self.formula):
            named = names_its_faults(self.formula, f"the column `{self.name}`")
            object.__setattr__(self, "formula", named)


@dataclass(frozen=True)
class Integral(metaclass=Described):
    """A quadrature: a variable that does not occur in the equations of motion.

    It is integrated together with them and must not control the step.

    Parameters
    ----------
    name, unit, long_name
        As a column; the name is unique in its form.
    rate
        rate(q, carried, b), its time derivative: of the state that moves, q, and the record of all
        integrals of the form, `carried`; None in a form that is not integrated.
    start
        start(data, sin_theta, cos_theta) of the initial data that the user gives; None: the value
        of the same name in the record of angles, 0 where it has none.
    of
        The quantity whose integral it is, if an event has that one's extremes: it is then not
        integrated twice.
    """

    name: str
    unit: Unit
    long_name: str
    rate: Any
    start: Callable | None = None
    of: str = ""


@dataclass(frozen=True)
class Orientation:
    """The orientation of the whole body in a form, not of its axis alone.

    Parameters
    ----------
    axes
        axes(q, carried, b) -> the body's axes 1 and 3 in the space frame, two Vectors; defined at
        the poles too.
    integrals
        Integrals that it needs.
    psi
        psi(first, third) of these axes [rad]; None: a planar motion has no psi, or it is one of the
        angles.
    """

    axes: Callable
    integrals: tuple[Integral, ...] = ()
    psi: Callable | None = None


def all_are(records: Any, container: Any, kind: type) -> bool:
    """Return whether records are a container, Mapping or Sequence, of records of one kind."""
    if not isinstance(records, container):
        return False
    values = records.values() if isinstance(records, Mapping) else records
    return all(isinstance(record, kind) for record in values)


@dataclass(frozen=True)
class Domain:
    """A condition for a motion to be possible: formula(scalars, b) must stay positive.

    `meaning` is a clause on a state where it is not, for messages.
    """

    formula: Callable
    meaning: str


@dataclass(frozen=True, eq=False)  # a key of caches: compared by identity
class Form(metaclass=Described):
    """A choice of variables for the state of a system, such as Euler angles or vectors.

    Two forms of a system must agree: a state that is converted from one form to the other by the
    record of angles has the same `scalars`, also after both have moved for the same time.

    Parameters
    ----------
    name
        The name in a scenario: vector, euler, ...
    units
        The type of the integrated state q: a NamedTuple that contains the unit of each variable.
    rates
        rates(q, b) -> the time derivatives, a record of the same type. None: rows can be written in
        this form, but it cannot be integrated.
    scalars
        scalars(q, b) -> the record that quantities and events take; by default the state itself.
    of_angles, to_angles
        of_angles(angles, sin_theta, cos_theta, b) -> q converts the record of angles to the state;
        to_angles(q, carried, b) -> angles converts it back. By default the state is that record.
    vectors
        vectors(q, b) -> a record of the `vectors` of the system. None: they are computed from the
        angles.
    integrals
        Variables that are integrated together with the state.
    orientation
        The orientation of the whole body; None if the form does not have it.
    domains
        Scalar functions that must stay positive for the form and the model to be valid.
    length_unit, not_normalised
        The unit of length of the form, in units of the system; the fields of the body that are 1 in
        the units of the system but not in those of the form.
    resolved
        Names of events whose functions control the step too. It is needed where their Taylor series
        converge more slowly than those of the state, as that of a gap that is no polynomial of it.
    """

    name: str
    units: Any
    rates: Any
    scalars: Callable = lambda q, b: q
    of_angles: Any = lambda angles, s, z, b: angles
    to_angles: Any = lambda q, carried, b: q
    vectors: Callable | None = None
    integrals: tuple[Integral, ...] = ()
    orientation: Orientation | None = None
    domains: tuple[Domain, ...] = ()
    length_unit: float = 1.0
    not_normalised: tuple[str, ...] = ()
    resolved: tuple[str, ...] = ()


def unchanged(x: Any, b: Any) -> Any:
    """Return a state as it is."""
    return x


@dataclass
class Next(metaclass=Described):
    """The result of a jump: the next phase, and the state in which it begins.

    Parameters
    ----------
    phase
        The name of the next phase. It may be empty if the run ends.
    x
        The common state in which the next phase begins, or in which the run ends. It is required.
        If it has a field `carried`, that field is the new record of the integrals of the run;
        otherwise the integrals keep their values.
    delay
        Time that passes during the jump, finite. Times and `x` are in internal units.
    series
        The motion during `delay`: series(t) -> the state of the next phase and the integrals at
        a time t since its start. None: the jump is too short to contain events; rows in it have
        the state at its end.
    logged
        Names of events that the jump adds to the event log, because no step finds their zeros; at
        most 1024.
    zeros
        The event functions of the next phase that are zero at its start: multiplicity of the root,
        by name.
    sides
        The signs of event functions at the start of the next phase, by name. By default, the
        function of an event with an exit has the sign from which it can reach its zero.
    lasts
        Time after which the next phase ends by its exit `CLOCK`, unless another exit comes first.
        By default it has no such time. 0: it ends immediately, after `delay`.
    cause
        The reason in the table of phases. None: the event that ended the phase before. Empty: no
        new row, because the same phase continues with other variables.
    rows
        Rows that the jump adds to further tables of the run: records in internal units, by table.
    ends, message
        If the jump ends the run: the status, one of `ENDS`, and the reason. Empty: it continues.
    """

    phase: str = ""
    x: Any = None
    cause: str | None = None
    delay: Any = 0
    series: Any = None
    logged: tuple[str, ...] = ()
    zeros: Mapping[str, int] = field(default_factory=dict)
    sides: Mapping[str, int] = field(default_factory=dict)
    lasts: Any = math.inf
    rows: Mapping[str, tuple] = field(default_factory=dict)
    ends: str = ""
    message: str = ""


CLOCK = "clock"
"""The event by which a phase ends that lasts a time known at its beginning."""

STALL = "stall"
"""The event by which a phase ends whose steps have become too short to go on."""

ENDS = ("ended", "liftoff", "fallen", "stalled")
"""Statuses with which a jump may end a run."""

KINDS = dict(ends=str, message=str, logged=tuple, zeros=dict, sides=dict, rows=dict)
"""Types of fields of a Next, for `Exit.fault`."""

MOST_LOGGED = 1024
"""Events that a jump may log."""


@dataclass(frozen=True)
class Exit(metaclass=Described):
    """A way in which a phase can end: an event, and the jump to the next phase.

    Parameters
    ----------
    event
        The name of an event of the phase, `CLOCK` or `STALL`.
    to
        The names of the phases that may follow.
    jump
        jump(x, world) -> Next. `x` is the common state, in numbers, in which the phase ended.
        `world` has the attributes `body`, `system`, `rules` (of the contact), `phases` (all Phases
        by name), `phase` (the Phase that ends), `left` (the time to the end of the run) and
        `rates(phase, q, carried)` (the rates of the integrals of the run). If a jump raises
        ArithmeticError(message), the run ends as `stalled`; any other exception becomes an
        InputError that names the jump.
    smooth
        Whether the motion goes on smoothly, so that it does not matter much where it happens, or
        whether it does.
    """

    event: str
    to: tuple[str, ...]
    jump: Callable
    smooth: bool = False

    def fault(self, n: Any, x: Any, known: Mapping[str, Any]) -> str:
        """Return a clause on what a jump must return, but does not: "return a Next, but ...".

        "" without one.

        n is the result of the jump from the common state x; `known`, which `engine.hybrid` makes
        once for a run, contains the words that its fields may have (of `rows`, tables with their
        columns).
        """
        if not isinstance(n, Next):
            return f"return a Next, but returns {n!r:.60}"
        for what, kind in KINDS.items():
            if not isinstance(value := getattr(n, what), kind):
                return f"have a {kind.__name__} in `{what}`, but has {value!r:.60}"
        if len(n.logged) > MOST_LOGGED:
            return f"log at most {MOST_LOGGED} events, but logs {len(n.logged)}"
        if n.phase not in self.to and not n.ends:
            return f"lead to {' or '.join(self.to)}, as its Exit declares, but leads to {n.phase!r}"
        if type(n.x) is not type(x):
            return f"return a state as it takes ({type(x).__name__}), but returns {n.x!r:.60}"
        for name, value in n.x._asdict().items():
            if not all(is_one_number(one) for one in leaves((value,))):
                return f"return a number in `{name}` of the state, but returns {value!r:.60}"
        for what, words in known.items():
            given = getattr(n, what) or ()
            for word in given if isinstance(given, tuple | dict) else (given,):
                if word not in words:
                    return f"have {' or '.join(words) or 'nothing'} in `{what}`, but has {word!r}"
        if not all(type(count) is int and count > 0 for count in n.zeros.values()):
            return f"have multiplicities of roots in `zeros`, 1 at least, but has {dict(n.zeros)}"
        if not {*n.sides.values()} <= {-1, 1}:
            return f"have signs in `sides`, -1 or 1, but has {n.sides}"
        for name, rows in n.rows.items():
            columns = known["rows"][name]
            for row in rows:
                if len(row) != len(columns):
                    return f"have {', '.join(columns)} in a row of `{name}`, but has {row!r:.60}"
        return ""


@dataclass(frozen=True, eq=False)
class Phase(metaclass=Described):
    """A period in which the contact does not change: slip, roll, flight, or contact of both balls.

    Parameters
    ----------
    forms
        One Form, or a dict of Forms by name. The first is the default, in which a phase begins
        after a jump.
    quantities
        Functions of a state that become columns.
    events
        Events of the phase.
    exits
        The events that end the phase, with their jumps. If there are none, the phase lasts until
        the run ends.
    enter, leave
        enter(x, b) -> q converts the common state to the state of the first form;
        leave(q, b) -> x converts it back.
    reaction
        reaction(q, b) -> the force of the plane and the power of its torques, for columns. None:
        the plane does not act on the body.
    parameters
        parameters(body) -> b, the argument of the formulas of this phase.
    label, ball
        The name in tables and figures; the number of the ball in contact, or last in contact.
    axis_stays
        Whether theta is constant, so that its turnings are rounding errors.
    """

    forms: Any
    quantities: Sequence[Quantity] = ()
    events: Sequence[Event] = ()
    exits: tuple[Exit, ...] = ()
    enter: Callable = unchanged
    leave: Callable = unchanged
    reaction: Any = None
    parameters: Callable = lambda body: body
    label: str = ""
    ball: int = 0
    axis_stays: bool = False

    def __post_init__(self) -> None:
        """Check the records, and make `forms` a read-only dict by name."""
        forms = {"": self.forms} if isinstance(self.forms, Form) else self.forms
        if not (forms and all_are(forms, Mapping, Form)):
            raise InputError(f"`forms` of a Phase must be a Form or a dict, but is {forms!r:.60}.")
        object.__setattr__(self, "forms", ReadOnly({form.name: form for form in forms.values()}))
        for name, kind in {"quantities": Quantity, "events": Event, "exits": Exit}.items():
            if not all_are(records := getattr(self, name), Sequence, kind):
                must = f"`{name}` of a Phase must be a tuple of {kind.__name__}"
                raise InputError(f"{must}, but is {records!r:.60}.")

    @property
    def form(self) -> Form:
        """Return the first form."""
        return next(iter(self.forms.values()))
