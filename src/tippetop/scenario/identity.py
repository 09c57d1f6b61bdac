"""User-defined events and columns: a store keeps digests of them to detect changed definitions.

`runs.attributes` and `sweeps.store` store the digests; `build.stored` compares them.
"""

import contextlib
import hashlib
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..errors import owner
from ..mechanics.contact.opening import SETTLED
from ..mechanics.event import Event
from ..mechanics.system import Quantity, System
from ..mechanics.systems import by_name, find, place_of
from ..problem import Problem


DIGESTS = "own"  # the root attribute
STATES = 16  # random states at which a formula is compared
Records = tuple[tuple[Event, ...], tuple[Quantity, ...]]
"""Events and columns that no registered system has."""


def digests_of(problem: Problem) -> dict[str, dict[str, str]]:
    """Return digests of user-defined events and columns by kind and name.

    It is the root attribute DIGESTS; kinds are also words in the sentences of `changed_records`.
    """
    kinds: dict[str, Any] = {"event": problem.system.events, "column": problem.system.quantities}
    digests = {
        kind: {r.name: _digest(r, problem) for r in records if owner(r.formula)}
        for kind, records in kinds.items()
    }
    return {kind: of for kind, of in digests.items() if of}


def changed_records(attrs: PlainData, problem: Problem, known: System | None) -> list[str]:
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
            found = "its formula, its words or its kept values differ"
            if name in given and name not in before:
                found = "the run has none of this name"
            elif before.get(name, digest) == digest:
                continue
            faults.append(
                f"the {kind} `{name}` must be one that the run was made with, but {found}."
            )
    return faults


def missing_records(attrs: PlainData, system: System) -> list[str]:
    """Return the names of user-defined events and columns of a stored run that a system lacks."""
    known = system.record_names
    return [name for of in attrs.get(DIGESTS, {}).values() for name in of if name not in known]


def user_records(system: System) -> Records:
    """Return the events and columns of a system that the registered one does not have.

    Both are empty for a registered system; the result can be passed to `System.with_records`.
    """
    if find(system.name) is None:
        return (), ()
    registered = by_name(*place_of(system))
    if registered is system:
        return (), ()
    known = *registered.quantities, *system.on_request
    return (
        tuple(event for event in system.events if event not in (*registered.events, SETTLED)),
        tuple(quantity for quantity in system.quantities if quantity not in known),
    )


def _digest(record: Event | Quantity, problem: Problem) -> str:
    """Return a digest of the fields of a record and of the values of its formula.

    Stores contain it: any change here makes user-defined records of old stores unknown.
    """
    text = [repr(value) for name, value in sorted(vars(record).items()) if name != "formula"]
    size = len(problem.variables.names), STATES
    states = np.random.default_rng(1).uniform(0.5, 1.0, size)
    body = problem.alone.body_of_pars(problem.alone.pars.astype(float))
    # a formula of a user may raise anything
    with np.errstate(all="ignore"), contextlib.suppress(Exception):
        values = record.formula(problem.alone.moment(states, body), body)
        text += [f"{value:.12e}" for value in np.broadcast_to(values, STATES)]
    return hashlib.sha256("\n".join(text).encode()).hexdigest()[:16]
