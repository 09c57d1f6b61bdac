"""Convert the formulas of a system to heyoka expressions.

A `System`, a form and a friction law go in; out come `Formulas`, which are compiled to integrators
(`integrator`), and values of rows by name, which are compiled to functions over arrays
(`observables`). The formulas are called with symbols instead of numbers.

Symbols
    q         the record of the state of a form; carried: that of its integrals
    b, body   the record of the body, whose numbers are run-time parameters of the compiled code
    leaves    the numbers of a record of records, in order
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple

import heyoka as hy

from ..mechanics.dual import Dual, parts_of
from ..mechanics.event import Event
from ..mechanics.moment import moment
from ..mechanics.operand import Vector, cos, refill, sin
from ..mechanics.system import Form, System
from ..mechanics.variables import Variables
from ..problem.row_columns import component
from .code_cache import compiled_once
from .opt_level import opt_level


class Equations(NamedTuple):
    """The equations of motion of a system as heyoka expressions, in internal units.

    Parameters
    ----------
    q, carried, body
        The records that formulas take: the state, the integrals, the body.
    rates
        Pairs (variable, its time derivative), one for each integrated variable.
    """

    q: Any
    carried: Any
    body: Any
    rates: list[tuple[Any, Any]]


@dataclass(frozen=True, eq=False)
class Formulas:
    """The formulas that an integrator is compiled from.

    Parameters
    ----------
    form
        The equations of motion.
    events
        The events that are detected.
    functions
        functions(q, carried, b) -> the event functions, in the order of the events.
    body
        body(values) -> the body, of an iterator over its leaves; a parameter that is always 0 or 1
        is a number.
    alone
        Whether a run has no other formulas, so that they may take seconds to compile.
    """

    form: Form
    events: tuple[Event, ...]
    functions: Callable
    body: Callable
    alone: bool = False


@lru_cache(maxsize=64)
def formulas_of(system: System, form_name: str, friction: Any) -> Formulas:
    """Return the formulas of a system in a form, under a friction law given by its type.

    Cached, so that equal arguments give the same object: compiled integrators are cached by it.
    """
    form = system.forms[form_name]
    events = tuple(event for event in system.events if event.formula)

    def functions(q: Any, carried: Any, b: Any) -> list:
        """Return the event functions of the system."""
        state = moment(form, q, carried, b)
        return [event.formula(state, b) for event in events]

    template = system.body_of(
        dict.fromkeys((*system.parameters, *system.surroundings), 1.0),
        friction._make(1.0 for _ in friction._fields),
    )

    def body(values: Iterator) -> Any:
        """Return the body of these leaves; parameters that are always 0 or 1 are numbers."""
        return refill(template, values)._replace(**system.folds(form))

    return Formulas(form, events, functions, body, alone=True)


def in_symbols(formulas: Formulas, variables: Variables, order: int = 0) -> tuple:
    """Return symbols of the variables, and the records (q, carried, body) made of symbols.

    With an order, variables and numbers of the body have derivatives along a direction up to it:
    symbols and parameters too, each after its number. `derivatives.through` passes states and
    parameters in this order.
    """
    size = order + 1
    # of one name: no list by itself
    symbols = [hy.make_vars("d_" * k + name) for name in variables.names for k in range(size)]
    number = Dual if order else lambda value: value
    state = [number(*symbols[i : i + size]) for i in range(0, len(symbols), size)]
    body = formulas.body(number(*(hy.par[i + k] for k in range(size))) for i in count(0, size))
    return symbols, *variables.split(state), body


def expressions_of(values: Iterable, order: int = 0) -> list[Any]:
    """Return numbers and their derivatives up to an order as expressions, one after another.

    Each number is before its derivatives; a plain number becomes a constant.
    """
    return [hy.expression(0.0) + part for value in values for part in parts_of(value, order)]


def equations_of_motion(formulas: Formulas, variables: Variables, order: int = 0) -> Equations:
    """Return equations of motion as heyoka expressions, in internal units; the body is in run-time
    parameters.

    With an order, they are those of the derivatives too: see `in_symbols`.
    """
    symbols, q, carried, body = in_symbols(formulas, variables, order)
    rates = expressions_of(variables.rates(q, carried, body), order)
    return Equations(q, carried, body, list(zip(symbols, rates, strict=True)))


SINE2, SPEED2 = "pole_sine2", "pole_speed2"
"""Names of sin(theta)^2 and |3hat'|^2, which theta'^2 is at a pole, among the values of a row."""
AXES = tuple(f"{axis}_{c}" for axis in ("first", "third") for c in "xyz")
"""Names of the components of axes 1 and 3 of the body."""


def axes_in(values: dict[str, Any]) -> Iterator[Vector]:
    """Yield the axes 1 and 3 of the body, which are taken out of values by name."""
    for axis in AXES[:3], AXES[3:]:
        yield Vector(*map(values.pop, axis))


def integrated(variable: str) -> str:
    """Return the name of an integrated component of 3hat among the values of a row.

    It is used in forms where the column `axis` is computed from the angles.
    """
    return f"integrated_{variable}"


def observed(system: System, form: Form, q: Any, carried: Any, body: Any) -> dict[str, Any]:
    """Return angles, vectors and quantities of a row by name, in internal units.

    They are arrays or expressions, as the arguments are. SINE2 and SPEED2, if they are there, are
    for `values_of`, which takes them out; names are those of parts of `row_columns.Source`.
    """
    arguments = moment(form, q, carried, body)
    angles = form.to_angles(q, carried, body)
    # a hybrid system may have no theta
    values = {"theta": math.nan, "theta_dot": 0.0, **angles._asdict()}
    if system.vectors:
        vector = system.forms["vector"]
        direct = form.name == "vector"
        if direct:
            state = q
        elif form.vectors:
            state = form.vectors(q, body)
        else:
            state = vector.of_angles(angles, sin(angles.theta), cos(angles.theta), body)
        values |= {
            component(name): getattr(state, name)
            for names in system.vectors.values()
            for name in names
        }
        if not direct and integrates_axis(system, form):
            values |= {integrated(name): getattr(q, name) for name in system.vectors["axis"]}
    values |= {quantity.name: quantity.formula(arguments, body) for quantity in system.quantities}
    if system.undefined_at_poles:
        scalars = form.scalars(q, body)
        values |= {SINE2: scalars.s2, SPEED2: scalars.axis_speed2}
    return values


def integrates_axis(system: System, form: Form) -> bool:
    """Return whether the form integrates the components of 3hat, whose length must stay 1."""
    axis = system.vectors.get("axis", ())
    return bool(axis) and set(axis) <= set(form.units._fields)


def orientation_of(system: System, form: Form, q: Any, carried: Any, body: Any) -> dict[str, Any]:
    """Return AXES, and psi if the form has it, by name; arrays or expressions.

    Callers take the first three AXES for axis 1 and the others for axis 3.
    """
    orientation = form.orientation
    assert orientation is not None
    first, third = orientation.axes(q, carried, body)
    psi = {"psi": orientation.psi(first, third)} if orientation.psi else {}
    return dict(zip(AXES, (*first, *third), strict=True)) | psi


@lru_cache(maxsize=64)
def compile_observables(
    formulas: Callable, system: System, variables: Variables, friction: Any, order: int = 0
) -> tuple[tuple[str, ...], Any]:
    """Return the names of the values of `observed` or `orientation_of`, and a function for them.

    The compiled function is f(inputs=(variables, n), pars=(leaves, n)). `observed` and
    `orientation_of` are compiled apart, so that neither changes the bits of the other. Compiled
    values take 11 ns a row where numpy takes 590, so that a store keeps pace with the integrator.
    With an order, values and inputs have derivatives up to it: see `in_symbols`.
    """
    form = variables.form
    symbols, *records = in_symbols(formulas_of(system, form.name, friction), variables, order)
    values = formulas(system, form, *records)
    outputs = expressions_of(values.values(), order)
    level = min(opt_level(), 1) if order else opt_level()  # as `variational.compiled_flow`
    function = compiled_once(hy.cfunc, outputs, vars=symbols, opt_level=level)
    return tuple(values), function
