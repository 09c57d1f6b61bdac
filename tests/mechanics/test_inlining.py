"""Formulas as straight-line Python: the numbers of the formulas, to the last bit."""

from typing import NamedTuple

import numpy as np
import pytest

from tippetop.mechanics import inlining
from tippetop.mechanics.contact import response
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import SetValued, Viscous
from tippetop.mechanics.operand import Vector, cos, dot, sqrt


BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, Viscous(0.3))


class Pair(NamedTuple):
    one: float
    other: Vector


def mixed(u, b):
    """A record of records, with constants, powers and functions."""
    return Pair(sqrt(u.x**2 + 2) / b.R, Vector(-u.x, 1.5 * cos(u.y), 0))


def vectors(count: int, rng: np.random.Generator) -> list[Vector]:
    return [Vector(*numbers) for numbers in rng.normal(0, 1, (count, 3)).tolist()]


@pytest.mark.parametrize(
    "formula", [mixed, lambda u, b: [dot(u, u), u.x / b.m], lambda u, b: u.z * b.friction[0]]
)
def test_bits_are_those_of_the_formula(formula, rng: np.random.Generator) -> None:
    straight = inlining.straight(formula, (*vectors(1, rng), BALL))
    assert straight is not formula
    for u in vectors(100, rng):
        assert straight(u, BALL) == formula(u, BALL)


def test_a_formula_of_the_contact_keeps_its_bits(rng: np.random.Generator) -> None:
    for u, L in zip(vectors(100, rng), vectors(100, rng), strict=True):
        whole = response.bias_vector.__wrapped__(u, L, BALL)
        assert response.bias_vector(u, L, BALL) == whole
        assert type(response.bias_vector(u, L, BALL)) is Vector


def test_a_formula_that_branches_stays_as_it_is(rng: np.random.Generator) -> None:
    def branching(u, b):
        return u.x if u.x > 0 else b.R

    assert inlining.straight(branching, (*vectors(1, rng), BALL)) is branching


def test_each_law_has_a_trace_of_its_own() -> None:
    @inlining.inlined
    def of_law(u, b):
        return u.x * (2 if isinstance(b.friction, SetValued) else 3)

    u, exact = Vector(1.0, 0.0, 0.0), BALL._replace(friction=SetValued(0.3))
    for _ in range(2 * inlining.PATIENCE):
        assert (of_law(u, BALL), of_law(u, exact)) == (3, 2)


def test_divisions_by_zero_are_those_of_the_formula() -> None:
    """NumPy's roots give infinities where Python's floats raise."""

    @inlining.inlined
    def inverse(u, b):
        return b.R / sqrt(u.x)

    with np.errstate(divide="ignore"):
        for x in [*[1.0] * inlining.PATIENCE, 0.0]:
            assert inverse(Vector(x, 0.0, 0.0), BALL) == (0.02 if x else np.inf)
