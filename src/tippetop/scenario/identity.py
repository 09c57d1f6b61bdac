"""User-defined events and columns: a store keeps digests of them to detect changed definitions."""

import contextlib
import hashlib
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..mechanics.contact.opening import SETTLED, opened
from ..mechanics.event import Event
from ..mechanics.moment import PLACE, Moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import Form, Quantity, System
from ..mechanics.systems import find
from ..problem import Problem


DIGESTS = "own"  # the root attribute
STATES = 16  # random states at which a formula is compared


def digests_of(problem: Problem) -> dict[str, dict[str, str]]:
    """Return digests of user-defined events and columns by kind and name.

    Events and columns of a system that was registered by the user are among them.
    """
    return _digests(problem.system, problem.form, problem.friction.__class__)


@lru_cache(maxsize=64)
def _digests(system: System, form: Form, friction: Any) -> dict[str, dict[str, str]]:
    registered = registered_as(system)
    known: list[Any] = []
    if registered is not None:
        known = [*registered.events, *registered.quantities, *registered.on_request]
    packaged = {r.name for r in known if not is_user_defined(r.formula)}
    kinds: dict[str, Any] = {"event": system.events, "column": system.quantities}
    digests = {
        kind: {r.name: _digest(r, system, form, friction) for r in of if r.name not in packaged}
        for kind, of in kinds.items()
    }
    return {kind: of for kind, of in digests.items() if of}


def changed_records(attrs: dict[str, Any], problem: Problem, known: System | None) -> list[str]:
    """Return sentences on events and columns of a problem that are not those of a stored run.

    Parameters
    ----------
    attrs
        The root attributes of the store.
    problem
        The problem of these attributes.
    known
        The system with user-defined events and columns that was given for it.
    """
    given = {r.name for records in (user_records(known) if known else ()) for r in records}
    faults = []
    for kind, digests in digests_of(problem).items():
        before = attrs.get(DIGESTS, {}).get(kind, {})
        for name, digest in digests.items():
            if name in given and name not in before:
                faults.append(
                    f"the {kind} `{name}` must be one that the run was made with, but the run has "
                    "none of this name."
                )
            elif before.get(name, digest) != digest:
                faults.append(
                    f"the {kind} `{name}` must be the record that the run was made with, but its "
                    "formula, its words or its kept values differ."
                )
    return faults


def missing_records(attrs: dict[str, Any], system: System) -> list[str]:
    """Return the names of user-defined events and columns of a stored run that a system lacks."""
    known = {event.name for event in system.events} | {q.name for q in system.quantities}
    return [name for of in attrs.get(DIGESTS, {}).values() for name in of if name not in known]


def registered_as(system: System) -> System | None:
    """Return the registered system of the same name, opened where this one is; None if none."""
    registered = find(system.name)
    return registered and opened(registered, *system.contact) if system.contact else registered


def user_records(system: System) -> tuple[tuple[Event, ...], tuple[Quantity, ...]]:
    """Return the events and columns of a system that the registered one does not have."""
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
    """Return a system with more events and columns; the same one for the same records.

    It is compiled only once.
    """
    if not (events or quantities):
        return system
    return system.replace(
        events=(*system.events, *events), quantities=(*system.quantities, *quantities)
    )


def is_user_defined(formula: Callable | None) -> bool:
    """Return whether a formula is not one of this package."""
    return formula is not None and not str(getattr(formula, "__module__", "")).startswith(
        f"{__name__.partition('.')[0]}."
    )


def _digest(record: Event | Quantity, system: System, form: Form, friction: Any) -> str:
    """Return a digest of the fields of a record and of the values of its formula."""
    random = np.random.default_rng(1)

    def numbers(record: Any) -> Any:
        return refill(record, iter(random.uniform(0.5, 1.0, (len(leaves(record)), STATES))))

    ones = friction._make(1.0 for _ in friction._fields)
    body = numbers(system.body_of(dict.fromkeys(system.parameters, 1.0), ones))
    text = [repr(value) for name, value in sorted(vars(record).items()) if name != "formula"]
    # a formula of a user may raise anything
    with np.errstate(all="ignore"), contextlib.suppress(Exception):
        scalars = form.scalars(numbers(form.units), body)
        place = dict(zip(PLACE, random.uniform(0.5, 1.0, (len(PLACE), STATES)), strict=True))
        moment = Moment(scalars, {name: partial(place.__getitem__, name) for name in PLACE})
        values = np.broadcast_to(np.asarray(record.formula(moment, body), dtype=float), STATES)
        text += [f"{value:.12e}" for value in values]
    return hashlib.sha256("\n".join(text).encode()).hexdigest()[:16]
