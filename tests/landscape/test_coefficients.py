"""Test the potential's coefficients, intervals of parameters, and momenta by name."""

import numpy as np
import pytest
from examples import CANONICAL, HEAVY

from tippetop.landscape import formulas, landscape_body, landscape_labels
from tippetop.mechanics.systems import SYSTEMS


KNOWN = [name for name, system in SYSTEMS.items() if system.landscape is not None]


def numbers(name: str) -> dict[str, float]:
    return HEAVY if "l" in SYSTEMS[name].parameters else CANONICAL


@pytest.mark.parametrize("name", KNOWN)
def test_coefficients_give_the_potential_of_the_system(name: str, rng: np.random.Generator) -> None:
    """Test the law of `Landscape`, for every system, momenta matched by the names of columns."""
    t = landscape_body.top(numbers(name), name)
    scale = np.sqrt(t.body.m * t.body.g * max(t.body.R, -t.body.c) * t.body.I3)
    q = np.exp(rng.uniform(-6, 6, 50))
    z = landscape_labels.cosine(q, t.bottom_z)
    values = {"routh": scale, "jellett": scale * t.body.R, "L3": scale, "Lz": scale}
    momenta = {m.column: values[m.column] * rng.uniform(-5, 5, 50) for m in t.landscape.momenta}
    V = formulas.value(q, formulas.at_momenta(*momenta.values(), t.coefficients), t.coefficients)
    assert t.system.potential is not None
    expected = t.system.potential(z, *(momenta[quantity] for quantity in t.system.momenta), t.body)
    np.testing.assert_allclose(V, expected, rtol=1e-12)


@pytest.mark.parametrize("name", KNOWN)
def test_momenta_are_quantities_of_the_system(name: str) -> None:
    landscape, system = SYSTEMS[name].landscape, SYSTEMS[name]
    assert landscape is not None
    assert landscape.energy in {q.name for q in system.quantities}
    for m in landscape.momenta:
        (quantity,) = (q for q in system.quantities if q.name == m.column)
        assert m.unit == quantity.unit
        assert np.add(m.unit.powers, m.rate.powers).tolist() == [1, 2, -2]
