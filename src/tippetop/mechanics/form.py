"""How a motion is written: forms, their integrals and quantities, phases of the contact and their exits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from .events import Event
from .readonly import freeze
from .units import Unit


@dataclass(frozen=True)
class Quantity:
    """A function of the scalars of a form, hence of no form in particular: formula(scalars, b).

    Parameters
    ----------
    name, symbol, unit, long_name
        As a column of a run, and as a label of a figure.
    formula
        formula(scalars, b), in any consistent units.
    meanings
        Of a number that stands for a name: the names, by number.
    is_column
        Whether it is stored; what is not is compared with others.
    """

    name: str
    symbol: str
    unit: Unit
    long_name: str
    formula: Callable
    meanings: tuple[str, ...] = ()
    is_column: bool = True


@dataclass(frozen=True)
class Integral:
    """A variable that the equations of motion do not read: it is integrated beside them and must not control the step.

    Parameters
    ----------
    name, unit, long_name
        As a column; the name is unique in its form.
    rate
        rate(q, carried, b), its time derivative: of the state that moves, q, and the record of all integrals of the
        form, `carried`.
    start
        start(data, sin_theta, cos_theta) of the initial data that the user gives; None: the value of the same name in
        the record of angles, 0 where it has none.
    """

    name: str
    unit: Unit
    long_name: str
    rate: Callable
    start: Callable | None = None


@dataclass(frozen=True)
class Orientation:
    """How a form knows which way the whole body is turned, not its axis alone.

    Parameters
    ----------
    axes
        axes(q, carried, b) -> the body's axes 1 and 3 in the space frame, two Vectors; defined at the poles too.
    integrals
        What is integrated for it.
    psi
        psi(first, third) of these axes [rad]; None: a planar motion, which has no psi.
    """

    axes: Callable
    integrals: tuple[Integral, ...] = ()
    psi: Callable | None = None


class Domain(NamedTuple):
    """A scalar function that must stay positive, formula(scalars, b), and what it means when it does not."""

    formula: Callable
    meaning: str


@dataclass(frozen=True)
class Form:
    """A way to write the state of a system.

    Law: `scalars` of two forms agree through the chart, and the chart commutes with the flow.

    Parameters
    ----------
    name
        As it stands in a scenario: vector, angles, ...
    units
        The record (a NamedTuple) of the state that moves, q, filled with the unit of each variable.
    rates
        rates(q, b) -> the same record: the time derivatives.
    scalars
        scalars(q, b) -> what the quantities and events are written in.
    of_angles, to_angles
        of_angles(angles, sin_theta, cos_theta, b) -> q, and back: to_angles(q, carried, b) -> the record of angles.
    vectors
        vectors(q, b) -> a record with the `vectors` of its system; None: they are made of the angles.
    integrals
        What is integrated beside the state.
    orientation
        How the turn of the whole body is known; None: it is not.
    domains
        Where the form or the model breaks down.
    length_unit, not_normalised
        The form's unit of length, in that of the system, and what of the body is then no longer 1.
    """

    name: str
    units: Any
    rates: Callable
    scalars: Callable
    of_angles: Callable
    to_angles: Callable
    vectors: Callable | None = None
    integrals: tuple[Integral, ...] = ()
    orientation: Orientation | None = None
    domains: tuple[Domain, ...] = ()
    length_unit: float = 1.0
    not_normalised: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exit:
    """How a phase ends in another one.

    Parameters
    ----------
    event
        The name of an event of the phase.
    to
        The names of the phases that may follow.
    jump
        jump(q, carried, b) -> name of the phase that follows, its state: from the first form of the one to the first
        form of the other, in internal units. Integrals of the same name continue from the values that they have.
    """

    event: str
    to: tuple[str, ...]
    jump: Callable


@dataclass(frozen=True)
class Phase:
    """What stays the same between two changes of the contact: slip, roll, flight, both balls at once.

    Parameters
    ----------
    forms
        The ways to write the state, by name; the first is the default, and the one in which jumps are written.
    quantities
        What can be read of a state, as columns.
    events
        What is looked for.
    exits
        Which events end the phase, and in which phases; none: only the end of the run does, or an event that stops it.
    """

    forms: dict[str, Form]
    quantities: Sequence[Quantity]
    events: Sequence[Event]
    exits: tuple[Exit, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "forms")
