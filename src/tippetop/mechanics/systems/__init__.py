"""The registry of systems: those of the package, registered ones, and those of entry points.

`SYSTEMS` contains each `System` by name, `find` and `add` read and extend it. A module for
each kind of body has its class (`TippeTop`, ...) and its systems; `outlook` has the predictions of
theory.

Entry points are loaded when an unknown name is used (a scan takes 10 to 70 ms): the group
`tippetop.systems` contains System records, `tippetop.friction` contains friction laws under the
name of the entry point.
"""

import copyreg
import pickle
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

from ...errors import InputError
from .. import friction
from ..contact.opening import kind_of, opened
from ..contact.surrounded import rolls, surrounded_rolling
from ..contact.surroundings import groups_of
from ..friction import FrictionLaw
from ..number import RecordType
from ..system import System
from .consistency import check
from .cylinder import GLIDING_CYLINDER, Modified
from .ellipsoid import ELLIPSOID, ROLLING_ELLIPSOID
from .gliding_heavy_top import GLIDING_HEAVY_TOP
from .heavy_top import HEAVY_TOP
from .revolution import DISC, ROLLING_DISC, ROLLING_SPHEROID, SPHEROID
from .rolling_cylinder import ROLLING_CYLINDER
from .rolling_tippe_top import ROLLING_TIPPE_TOP
from .tippe_top import TIPPE_TOP


SYSTEMS: dict[str, System] = {
    system.name: system
    for system in (
        TIPPE_TOP,
        ROLLING_TIPPE_TOP,
        GLIDING_HEAVY_TOP,
        HEAVY_TOP,
        GLIDING_CYLINDER,
        ROLLING_CYLINDER,
        SPHEROID,
        ROLLING_SPHEROID,
        DISC,
        ROLLING_DISC,
        ELLIPSOID,
        ROLLING_ELLIPSOID,
    )
}


SHARED: set[Any] = {*SYSTEMS.values(), *friction.LAWS.values(), Modified}
"""Systems and laws of this package and of entry points: other processes know them too."""


def add(system: System) -> None:
    """Register a system under its name in this process, in place of a user's one of that name.

    Raises InputError if the name is that of a system in `SHARED`, from the package or an entry
    point, or if `check` finds faults.
    """
    before = SYSTEMS.get(friction.checked_name(system.name, "system"))
    if before in SHARED and before is not system:
        raise InputError(f"the name of a system must be new, but `{system.name}` is known.")
    check(system)
    SYSTEMS[system.name] = system


def add_law(law: type[FrictionLaw]) -> None:
    """Register a friction law under its key in this process, in place of a user's one of that key.

    Raises InputError if the key is that of a law in `SHARED`, or the law cannot be registered.
    """
    name = friction.checked_name(law.key, "law")
    before = next((s.laws[name] for s in SYSTEMS.values() if name in s.laws), law)
    if before in SHARED and before is not law:
        raise InputError(
            f"the name of a law must be new, but `{name}` is that of {before.__name__}."
        )
    friction.add(law)


def known_to_others(record: Any) -> bool:
    """Return whether other processes know a system or a law: it comes from an installed package."""
    load_entry_points()
    return getattr(record, "face", record) in SHARED


def find(name: str) -> System | None:
    """Return the system of a name, of the package, registered, or of an entry point.

    Return None if it does not exist.
    """
    if name not in SYSTEMS:
        load_entry_points()
    return SYSTEMS.get(name)


def laws_of(system: System) -> dict[str, type[FrictionLaw]]:
    """Return the friction laws that runs of a system take, by name.

    Laws with regions are for a body with a contact disc. Where the contact may open, laws that have
    no phases, as `kind_of` finds, are left out.
    """
    if system.contact is not None:
        return {
            name: law for name, law in laws_of(SYSTEMS[system.name]).items() if any(kind_of(law))
        }
    has_disc = system.opening is not None and system.opening.rounded
    return {name: law for name, law in system.laws.items() if not law.regions or has_disc}


def opening_systems() -> dict[str, System]:
    """Return the systems whose contact may open, by name: those with an `Opening`.

    A scenario of one of them may have a table [contact].
    """
    return {name: system for name, system in SYSTEMS.items() if system.opening is not None}


def surroundable_systems() -> dict[str, System]:
    """Return the systems that may be in surroundings, by name: those that may fly, or that roll."""
    return {n: s for n, s in SYSTEMS.items() if s.opening is not None or rolls(s)}


def systems_of_laws() -> dict[str, tuple[type[FrictionLaw], list[str]]]:
    """Return every friction law by name, with the names of the systems that take it."""
    known: dict[str, tuple[type[FrictionLaw], list[str]]] = {
        name: (law, []) for name, law in friction.LAWS.items()
    }
    for system in SYSTEMS.values():
        for name, law in laws_of(system).items():
            known.setdefault(name, (law, []))[1].append(system.name)
    return known


def by_name(name: str, contact: tuple = (), around: tuple[str, ...] = ()) -> System:
    """Return the system of a name, as a pickle has it.

    Raises InputError if this process does not know it, or the law of its contact.

    Parameters
    ----------
    name
        Its name.
    contact
        Its law, balls and surroundings, if its contact may open.
    around
        The groups of its surroundings otherwise.
    """
    system = find(name)
    if system is None:
        raise InputError(f"the system `{name}` is not known in this process: register it first.")
    if not contact:
        return surrounded_rolling(system, around) if around else system
    law, *_ = contact
    if not friction.is_known(law, system.laws):
        raise InputError(
            f"the law of `{law.__name__}` is not known in this process: register it first."
        )
    return opened(system, *contact)


def place_of(system: System) -> tuple:
    """Return the arguments of `by_name`, in their order, for the registered system of which one is
    made. Pickles contain them.
    """
    contact = system.contact or ()
    return system.name, contact, () if contact else groups_of(system.surroundings)


def _pickled(system: System) -> tuple:
    """Return (by_name, its arguments), by which a pickle names a system: it has no formulas.

    Raises PicklingError for a system that `by_name` would not return.
    """
    place = place_of(system)
    if system.name not in SYSTEMS or by_name(*place) is not system:
        raise pickle.PicklingError(
            f"a `{system.name}` that is not registered, or has events or columns of your own, "
            "cannot be pickled: its "
            "formulas are functions. Save the run, or pickle what `run` was given."
        )
    return by_name, place


copyreg.pickle(System, _pickled)


@cache
def load_entry_points() -> None:
    """Register the entry points of installed packages, once per process.

    A record that fails is left out with a warning.
    """
    from importlib.metadata import entry_points

    groups: dict[str, tuple[type, str, Callable[[Any], None]]] = {
        "tippetop.friction": (RecordType, "a FrictionLaw", add_law),
        "tippetop.systems": (System, "a System", add),
    }
    for group, (kind, words, register) in groups.items():
        for entry in entry_points(group=group):
            try:
                record = entry.load()
                if not isinstance(record, kind):
                    raise InputError([f"it must be {words}, but is {record!r:.60}."])
                register(record)
                SHARED.add(record)
            except Exception as error:  # any package may have installed it, and broken it
                warnings.warn(f"`{entry.name}` of {group} is left out: {error}", stacklevel=2)
