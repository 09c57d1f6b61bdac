"""Register user-defined systems and friction laws by name."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from ..errors import InputError
from ..mechanics import systems
from ..mechanics.friction import FrictionLaw
from ..mechanics.system import System


SYSTEMS = MappingProxyType(systems.SYSTEMS)
"""The systems that are known, by name; `register` adds one."""


class _Laws(Mapping):
    """The friction laws of all registered systems, looked up when they are read."""

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
        The same.

    Raises
    ------
    InputError
        If the name is that of a system or a law of this package or of an entry point, or the
        record cannot be a law or a system. A record of yours replaces one of the same name.

    Notes
    -----
    Other processes do not know it: not the command line, not the workers of a sweep, which then
    runs in this process (`workers=1`, or none given). A package makes its records known everywhere
    by entry points: the group `tippetop.systems` names System records, `tippetop.friction` names
    laws.
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
