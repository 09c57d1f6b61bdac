"""Numbers of a friction law when the law changes: the same name may measure something else."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..mechanics.units import ONE, Unit


if TYPE_CHECKING:
    from ..mechanics.friction import Law


def refuse_other_units(before: Mapping[str, Any], after: Mapping[str, Any], given: Collection[str]) -> None:
    """Check that no number keeps its value while the new law measures it in another unit.

    Parameters
    ----------
    before, after
        The tables of a scenario before and after its law may have changed.
    given
        Names of the numbers of the law that are given with the change.

    Raises
    ------
    InputError
        One sentence for each such number.
    """
    name, other = (_law_name(tables) for tables in (before, after))
    if name is None or other is None or name == other:
        return
    old, new = _law(before, name), _law(after, other)
    if old is None or new is None:
        return
    numbers = after["friction"]
    kept = [name for name in new.parameters if name in old.parameters and name in numbers and name not in given]
    faults = [
        f"`friction.{name}` must be given anew: the law `{other}` takes it {_in(new.parameters[name].unit)}, "
        f"but {numbers[name]} is that of `{name}`, {_in(old.parameters[name].unit)} "
        f"(--set friction.{name}=...)."
        for name in kept
        if new.parameters[name].unit != old.parameters[name].unit
    ]
    if faults:
        raise InputError(faults)


def _law_name(tables: Mapping[str, Any]) -> str | None:
    friction = tables.get("friction")
    name = friction.get("law") if isinstance(friction, dict) else None
    return name if isinstance(name, str) else None


def _law(tables: Mapping[str, Any], name: str) -> "Law | None":
    """Return a law of the system of a scenario; None if the system or the law is not known."""
    from ..mechanics.systems import find, laws_of  # half a second, which scenarios that keep their law do without

    system = find(tables["system"]) if isinstance(tables.get("system"), str) else None
    return laws_of(system).get(name) if system is not None else None


def _in(unit: Unit) -> str:
    return "without a unit" if unit == ONE else f"in {unit.symbol}"
