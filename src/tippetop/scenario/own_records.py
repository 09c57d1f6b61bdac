"""Events and columns of one's own, as a store remembers them: a digest of what each says, to know
it again by.
"""

import contextlib
import hashlib
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..mechanics.contact.opening import SETTLED, opened
from ..mechanics.event import Event
from ..mechanics.moment import PLACE, Moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import Form, Quantity, System
from ..mechanics.systems import find
from ..mechanics.writing import JAVASCRIPT, function
from ..problem import Problem


OWN = "own"  # the root attribute
STATES = 3  # at which a formula that cannot be written down is compared


def own_of(problem: Problem) -> dict[str, dict[str, str]]:
    """Digests of the events and columns whose formulas are not of this package, by name; empty
    where there is none.
    """
    return _own(problem.system, problem.form.name, problem.friction.__class__)


def other_records(attrs: dict[str, Any], problem: Problem, known: System | None) -> list[str]:
    """Return sentences on events and columns of a problem that are not those of the run in a store.

    Parameters
    ----------
    attrs
        The root attributes of the store.
    problem
        What was made of them.
    known
        The system with events and columns of one's own that was given for it.
    """
    faults = []
    for kind, now in own_of(problem).items():
        before = attrs.get(OWN, {}).get(kind, {})
        faults += [
            f"the {kind} `{name}` must be the record that the run was made with, but is "
            "another: its formula, its "
            "words or what it keeps differ."
            for name, digest in now.items()
            if before.get(name, digest) != digest
        ]
    return faults + _more(attrs, known)


def _more(attrs: dict[str, Any], known: System | None) -> list[str]:
    """Sentences on events and columns that were given, and the run has not."""
    given: Any = own_records(known) if known is not None else ((), ())
    has = attrs["run"]["events"], attrs["run"].get("columns", ())
    return [
        f"the {kind} `{name}` must be one that the run was made with, but the run has none of "
        "this name."
        for kind, records, names in zip(("event", "column"), given, has, strict=True)
        for name in sorted(record.name for record in records)
        if name not in names
    ]


@lru_cache(maxsize=64)
def _own(system: System, form_name: str, friction: Any) -> dict[str, dict[str, str]]:
    registered, form = registered_as(system), system.forms[form_name]
    known: list[Any] = [] if registered is None else [*registered.events, *registered.quantities]
    ours = {record.name for record in known}
    of: dict[str, Sequence[Any]] = {"event": system.events, "column": system.quantities}
    digests = {
        kind: {
            r.name: _digest(r, system, form, friction)
            for r in records
            if r.name not in ours or is_users(r.formula)
        }
        for kind, records in of.items()
    }
    return {kind: names for kind, names in digests.items() if names}


def registered_as(system: System) -> System | None:
    """Return the registered system of the same name, opened where this one is; None if there is
    none.
    """
    registered = find(system.name)
    return registered and opened(registered, *system.contact) if system.contact else registered


def own_records(system: System) -> tuple[tuple[Event, ...], tuple[Quantity, ...]]:
    """Return the events and columns of a system that the registered one has not."""
    registered = registered_as(system)
    if registered is None or registered is system:
        return (), ()
    return (
        tuple(event for event in system.events if event not in (*registered.events, SETTLED)),
        tuple(quantity for quantity in system.quantities if quantity not in registered.quantities),
    )


@lru_cache(maxsize=64)
def with_records(
    system: System, events: tuple[Event, ...], quantities: tuple[Quantity, ...]
) -> System:
    """Return a system with more events and columns; the same one for the same records, so that it
    is compiled once.
    """
    if not (events or quantities):
        return system
    return system.replace(
        events=(*system.events, *events), quantities=(*system.quantities, *quantities)
    )


def is_users(formula: Callable | None) -> bool:
    """Return whether a formula is not one of this package."""
    return formula is not None and not str(getattr(formula, "__module__", "")).startswith(
        f"{__name__.partition('.')[0]}."
    )


def _digest(record: Event | Quantity, system: System, form: Form, friction: Any) -> str:
    """A digest of all that a record says, its formula written down."""
    words = [repr(value) for name, value in sorted(vars(record).items()) if name != "formula"]
    text = "\n".join([*words, *_written(record.formula, system, form, friction)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _written(formula: Callable, system: System, form: Form, friction: Any) -> list[str]:
    """A formula of the scalars and the body as lines; its values in some states where it cannot be
    written down.
    """
    random = np.random.default_rng(1)

    def numbers(record: Any) -> Any:
        return refill(record, iter(random.uniform(0.5, 1.0, len(leaves(record)))))

    body = system.body_of(
        dict.fromkeys(system.parameters, 1.0), friction._make(1.0 for _ in friction._fields)
    )
    with np.errstate(all="ignore"):
        states = [
            (form.scalars(numbers(form.units), b), b)
            for b in (numbers(body) for _ in range(STATES))
        ]
        scalars, body = states[0]

        def of_symbols(symbols: list[Any]) -> list[Any]:
            given = iter(symbols)
            known, of_body = refill(scalars, given), refill(body, given)
            return [formula(_moment(known, given), of_body)]

        fewest = len(leaves(scalars)) + len(leaves(body))
        for size in (
            fewest,
            fewest + len(PLACE),
        ):  # most formulas read no place, and keep their digest
            with contextlib.suppress(Exception):  # the formula of a user may do what no program can
                lines, results = function(JAVASCRIPT, [f"x{i}" for i in range(size)], of_symbols)
                return [*lines, *results]
        place = random.uniform(0.5, 1.0, (STATES, len(PLACE)))
        given = [(_moment(s, iter(p)), b) for (s, b), p in zip(states, place, strict=True)]
        return [_value(formula, *state) for state in given]


def _moment(scalars: Any, place: Iterator[Any]) -> Moment:
    """Return a moment of these scalars whose place and axis are the next values."""
    values = dict(zip(PLACE, place, strict=False))
    return Moment(scalars, {name: partial(values.__getitem__, name) for name in values})


def _value(formula: Callable, scalars: Any, body: Any) -> str:
    """A formula in a state; nothing where it has no value there."""
    try:
        return f"{float(formula(scalars, body)):.12e}"
    except Exception:  # see above
        return ""
