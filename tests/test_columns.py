"""Columns in words: the letters of the formulas, units as people write them, flags by
their names.
"""

import numpy as np
import pytest

from tippetop.columns import (
    SUPERSCRIPTS,
    Column,
    flag_attributes,
    flagged,
    greek,
    units_text,
)
from tippetop.mechanics import units
from tippetop.mechanics.units import Unit


UNITS = {name: unit for name, unit in vars(units).items() if isinstance(unit, Unit)}
SI = {"1": (0, 0, 0), "rad": (0, 0, 0), "s": (0, 0, 1), "m": (0, 1, 0), "kg": (1, 0, 0)}
SI |= {"N": (1, 1, -2), "J": (1, 2, -2), "W": (1, 2, -3)}
"""What the symbols mean, as powers of mass, length and time."""


@pytest.mark.parametrize(
    ("words", "letters"),
    [
        ("spin omega_3", "spin ω₃"),
        ("sigma = m R^2/I3, set by I3 at the same gamma", "σ = m R^2/I3, set by I3 at the same γ"),
        ("the spin of a simulation rises through pi", "the spin of a simulation rises through π"),
    ],
)
def test_names_of_letters_become_letters(words: str, letters: str) -> None:
    assert greek(words) == letters


@pytest.mark.parametrize("unit", UNITS.values(), ids=UNITS.keys())
def test_a_unit_is_what_its_symbol_says(unit: Unit) -> None:
    """The symbol, read by the rules of SI, has the powers of the record: `kg m2 s-1` is
    1, 2, -1.
    """
    total = np.zeros(3, int)
    for factor in unit.symbol.split():
        base = factor.rstrip("-0123456789") or factor
        total += np.array(SI[base]) * int(factor[len(base) :] or 1)
    assert tuple(total.tolist()) == unit.powers


@pytest.mark.parametrize("unit", UNITS.values(), ids=UNITS.keys())
def test_powers_are_raised_and_nothing_else_changes(unit: Unit) -> None:
    text = units_text(unit.symbol)
    assert not any(digit in text for digit in "-23456789")
    assert text.translate({new: old for old, new in SUPERSCRIPTS.items()}) == unit.symbol
    assert units_text("kg m2 s-1") == "kg m² s⁻¹"
    assert units_text("1") == "1"


def test_a_flag_is_found_by_its_name() -> None:
    """A name that the column does not know is nowhere: not at the flag 0, nor at the last one."""
    names = ("turning", "liftoff", "equator")
    flags = Column(("event",), np.array([0, 2, 1, 0]), flag_attributes(names, "kind"))
    for place, name in enumerate(names):
        np.testing.assert_array_equal(flagged(flags, name), flags.values == place)
    assert not flagged(flags, "landing").any()
