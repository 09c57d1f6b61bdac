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
