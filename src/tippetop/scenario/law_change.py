"""Numbers of a friction law when the law changes: a name may have another unit in the new law."""

from collections.abc import Collection, Mapping
from typing import Any

from ..errors import InputError
from ..mechanics.units import ONE, Unit


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
    from ..mechanics.systems import find, laws_of  # half a second, needed only here

    found = [
        laws_of(system).get(str(name)) if (system := find(str(tables.get("system")))) else None
        for tables, name in zip((before, after), names, strict=True)
    ]
    if None in found:
        return
    old, new = (law.parameters for law in found if law)
    numbers, faults = after["friction"], []
    for name in old.keys() & numbers.keys() - {*given}:
        value, unit = numbers[name], old[name].unit
        if name not in new:
            del numbers[name]
        elif new[name].unit != unit:
            faults.append(
                f"`friction.{name}` must be given anew: `{names[1]}` takes it "
                f"{_in(new[name].unit)}, but {value} is that of `{names[0]}`, {_in(unit)} "
                f"(--set friction.{name}=...)."
            )
    if faults:
        raise InputError(faults)


def law_name(tables: Mapping[str, Any]) -> str | None:
    """Return the name of the law in the tables of a scenario; None if there is none."""
    friction = tables.get("friction")
    name = friction.get("law") if isinstance(friction, dict) else None
    return name if isinstance(name, str) else None


def _in(unit: Unit) -> str:
    return "without a unit" if unit == ONE else f"in {unit.symbol}"
