"""Register user-defined systems and friction laws by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from ..errors import InputError
from ..mechanics import systems
from ..mechanics.contact.body import Top
from ..mechanics.friction import FrictionLaw
from ..mechanics.number import Number
from ..mechanics.system import System
from ..mechanics.systems import revolution, user_outline


SYSTEMS = MappingProxyType(systems.SYSTEMS)
"""The systems that are known, by name; `register` adds one."""


class _Laws(Mapping):
    """The friction laws of all registered systems, looked up when they are read.

    Not a copy: `register` and entry points add laws later.
    """

    def __getitem__(self, name: str) -> type[FrictionLaw]:
        return systems.systems_of_laws()[name][0]

    def __iter__(self) -> Iterator[str]:
        return iter(systems.systems_of_laws())

    def __len__(self) -> int:
        return len(systems.systems_of_laws())


LAWS: Mapping[str, type[FrictionLaw]] = _Laws()
"""The friction laws that are known, by name, of whichever system; `register` adds one."""


def register(record: System | type[FrictionLaw]) -> Any:
    """Register a user-defined system or friction law by name, for TOML, `run` and sweeps.

    Parameters
    ----------
    record : System or FrictionLaw
        The record of a system, or the class of a law: `[friction] law = "..."` takes its `key`.

    Returns
    -------
    System or FrictionLaw
        The record itself.

    Raises
    ------
    InputError
        If the name is that of a system or a law of this package or of an entry point, or the
        record cannot be a law or a system. A user-defined record of the same name is replaced.

    Notes
    -----
    The record is registered in this process only. The command line cannot use it, and a sweep
    with it must run in this process (`workers=1`, the default then). A package registers its
    records everywhere by entry points: System records in the group `tippetop.systems`, laws in
    the group `tippetop.friction`.
    """
    if isinstance(record, System):
        systems.add(record)
    elif isinstance(record, type) and issubclass(record, FrictionLaw) and record is not FrictionLaw:
        systems.add_law(record)
    else:
        raise InputError(
            f"`record` must be a System or a class of FrictionLaw, but is {record!r:.60}."
        )
    return record


def outline(numbers: Mapping[str, Number], height: Callable) -> type[Top]:
    """Register a body of revolution by the height of its centre of mass on the plane.

    Its two systems, gliding and rolling, are named after the function: that of `hen_egg` is
    "hen-egg", and "rolling-hen-egg". They have every law and every phase of the contact that a
    Spheroid has.

    Parameters
    ----------
    numbers : dict of Number
        Its numbers by name, other than m, I1, I3 and g.
    height : callable
        height(z, s2, b) -> the height of the centre of mass [m] at the inclination theta: z is
        cos(theta), s2 is sin(theta)^2, b has the numbers. It may use + - * /, whole powers and
        `tippetop.extending.root`; derivatives follow.

    Returns
    -------
    class
        The body, which `tippetop.run` takes as it does a Spheroid.

    Raises
    ------
    InputError
        If `height` cannot be evaluated, or the name is known. A body whose outline is not smooth
        or not convex is refused when it is made.
    """
    body = user_outline.body_by_height(numbers, height)
    title = body.gliding.replace("-", " ")
    for system in revolution.systems(body, title, classes=revolution.SPHEROID.classes):
        register(system)
    return body
