"""Numbers of a friction law when the law changes: the same name may measure something else."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..mechanics.units import ONE, Unit


if TYPE_CHECKING:
    from ..mechanics.friction import FrictionLaw


def change_law(before: Mapping[str, Any], after: dict[str, Any], given: Collection[str]) -> None:
    """Drop the numbers that a new law does not have; no other may keep its value in another unit.

    Parameters
    ----------
    before, after
        The tables of a scenario before and after its law may have changed; `after` is changed in
        place.
    given
        Names of the numbers of the law that are given with the change.

    Raises
    ------
    InputError
        One sentence for each such number.
    """
    names = law_name(before), law_name(after)
    if None in names or names[0] == names[1]:
        return
    old, new = _law(before, names[0]), _law(after, names[1])
    if old is None or new is None:
        return
    numbers, faults = after["friction"], []
    for name in set(old.parameters) - set(new.parameters) - set(given):
        numbers.pop(name, None)
    for name, rule in new.parameters.items():
        if name not in old.parameters or name not in numbers or name in given:
            continue
        unit = old.parameters[name].unit
        if rule.unit != unit:
            faults.append(
                f"`friction.{name}` must be given anew: `{names[1]}` takes it {_in(rule.unit)}, "
                "but "
                f"{numbers[name]} is that of `{names[0]}`, {_in(unit)} (--set friction.{name}=...)."
            )
    if faults:
        raise InputError(faults)


def law_name(tables: Mapping[str, Any]) -> str | None:
    """Return the name of the law that tables give; None where there is none, or no text."""
    friction = tables.get("friction")
    name = friction.get("law") if isinstance(friction, dict) else None
    return name if isinstance(name, str) else None


def _law(tables: Mapping[str, Any], name: str | None) -> "type[FrictionLaw] | None":
    """Return a law of the system of a scenario; None if the system or the law is not known."""
    from ..mechanics.systems import (
        find,
        laws_of,
    )  # half a second, which scenarios that keep their law do without

    system = find(tables["system"]) if isinstance(tables.get("system"), str) else None
    return laws_of(system).get(name or "") if system is not None else None


def _in(unit: Unit) -> str:
    return "without a unit" if unit == ONE else f"in {unit.symbol}"
