"""Systems of the package are consistent, and have what a run needs; also where contacts open."""

import pytest

from tippetop.mechanics.contact.opening import opened
from tippetop.mechanics.friction import Contensou, SetValued, Viscous
from tippetop.mechanics.system import System
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.systems.consistency import inconsistencies, unmet_requirements


OPENED = [
    opened(SYSTEMS[name], law, balls).replace(contact=None)
    for name, balls in (("tippe-top", 2), ("gliding-heavy-top", 1), ("gliding-cylinder", 1))
    for law in (Viscous, SetValued, Contensou)
    if law is not Contensou or balls == 2
]


@pytest.mark.parametrize("system", [*SYSTEMS.values(), *OPENED], ids=lambda one: one.name)
def test_systems_are_consistent(system: System) -> None:
    assert inconsistencies(system) == []
    assert system in OPENED or unmet_requirements(system) == []


def test_units_of_a_body_follow_from_its_formula() -> None:
    """A product adds powers, a function of an angle has none: 2 pi f is 1/s, a (2 pi f)^2 m/s^2."""
    top = opened(SYSTEMS["tippe-top"], Viscous, 1, ("tilt", "vibration"))
    units = top.body_units(Viscous.units())
    shake = units.around.shake
    assert units.c.powers == (0, 1, 0)  # alpha R
    assert [unit.powers for unit in shake] == [(0, 1, -2)] * 3 + [(0, 0, -1)]
    outline = SYSTEMS["ellipsoid"].body_units(()).outline
    assert (outline.sin.powers, outline.a12.powers) == ((0, 0, 0), (0, 2, 0))
