"""The numbers that a user gives: what must hold of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .units import Unit


@dataclass(frozen=True)
class Parameter:
    """A number that the user gives: its unit, its meaning, and the open or closed interval it must lie in.

    Parameters
    ----------
    unit : Unit
        What it is given in, SI; `tippetop.mechanics.units` has those of the package.
    long_name : str
        What it is, in words.
    above, least : float, optional
        It must be greater than `above`, at least `least`.
    below, most : float, optional
        It must be less than `below`, at most `most`.
    nonzero : bool
        Whether it must differ from 0.
    default : float, optional
        What it is where it is left out; without, it must be given.

    Raises
    ------
    InputError
        If the unit is none, no number can lie in the interval, or the default does not.
    """

    unit: Unit
    long_name: str
    above: float | None = None  # must be greater than
    least: float | None = None  # must be at least
    below: float | None = None  # must be less than
    most: float | None = None  # must be at most
    default: float | None = None  # where it is left out; None: it must be given
    nonzero: bool = False  # must not be 0

    def __post_init__(self) -> None:
        if faults := self._faults():
            raise InputError(faults)

    def _faults(self) -> list[str]:
        """What contradicts itself, in sentences."""
        unit: Any = self.unit
        if not isinstance(unit, Unit):
            return [f"`unit` of the number `{self.long_name}` must be a Unit, but is {self.unit!r:.60}."]
        for low in (bound for bound in (self.above, self.least) if bound is not None):
            for high in (bound for bound in (self.below, self.most) if bound is not None):
                if low > high or (low == high and (self.above == low or self.below == high)):
                    return [f"some number must be {self.must()[8:]}, for `{self.long_name}`, but none is."]
        if self.default is not None and self.broken(self.default):
            return [f"`default` of the number `{self.long_name}` {self.must()}, but is {self.default:g}."]
        return []

    def _bounds(self) -> list[tuple[str, float, Callable]]:
        """The bounds that are set: what a value must be, the limit, and how a value breaks it."""
        bounds = (
            ("other than", 0.0 if self.nonzero else None, np.equal),
            ("greater than", self.above, np.less_equal),
            ("at least", self.least, np.less),
            ("less than", self.below, np.greater_equal),
            ("at most", self.most, np.greater),
        )
        return [(words, float(limit), breaks) for words, limit, breaks in bounds if limit is not None]

    def broken(self, values: Any) -> Any:
        """Where values lie outside the interval or are not finite: a mask of their shape.

        Parameters
        ----------
        values
            A number or an array, in SI units.

        Returns
        -------
        bool or array of bool
            True where the value is not allowed.
        """
        broken = ~np.isfinite(values)
        for _, limit, breaks in self._bounds():
            broken = broken | breaks(values, limit)
        return broken

    def must(self, value: float | None = None) -> str:
        """What must hold, as in "must be finite, greater than 0"; of a value: the first thing that it breaks."""
        if value is None:
            return "must be finite" + "".join(f", {words} {limit:g}" for words, limit, _ in self._bounds())
        broken = [f"{words} {limit}" for words, limit, breaks in self._bounds() if breaks(value, limit)]
        return f"must be {broken[0]}" if broken and np.isfinite(value) else "must be a finite number"

    def fault(self, key: str, value: float) -> str:
        """The sentence on a value that is broken."""
        return f"`{key}` {self.must()}, but is {value:.17g}."


def rules_faults(words: str, rules: Any) -> list[str]:
    """The sentence on what must be Parameter records by name, and is not; `words` say what it is."""
    if isinstance(rules, Mapping) and all(isinstance(rule, Parameter) for rule in rules.values()):
        return []
    return [f"{words} must be Parameter records by name, but is {rules!r:.60}."]


class Alternative(NamedTuple):
    """An initial datum that says in another way what others say: it stands alone, without any of `others`."""

    name: str
    others: tuple[str, ...]
    flag: bool = False  # true or false, not a number

    def fault(self, verb: str) -> str:
        """The sentence on data that are not alone; `verb` says how the others come: they are given, or vary."""
        others = " or ".join(f"`initial.{other}`" for other in self.others)
        return f"`initial.{self.name}` must stand alone, but {others} {verb} too."
