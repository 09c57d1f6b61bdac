"""Numbers as people write them: exact arithmetic, units, sentences."""

import math
from fractions import Fraction

import pytest
from refusals import refusal

from tippetop.errors import InputError
from tippetop.mechanics.quantity import number_of
from tippetop.mechanics.units import (
    INERTIA,
    KILOGRAM,
    METRE,
    METRE_PER_SECOND2,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    Unit,
)
from tippetop.runs import starting


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("3/10", ONE, Fraction(3, 10)),
        ("-(1 + 2)^2 / 3", ONE, Fraction(-3)),
        ("2 * 3 g", KILOGRAM, Fraction(6, 1000)),
        ("1 inch", METRE, Fraction(254, 10000)),
        ("20 g cm^2", INERTIA, Fraction(20, 10**7)),
        ("1e3 cm/s^2", METRE_PER_SECOND2, Fraction(10)),
        ("7 %", ONE, Fraction(7, 100)),
        ("180 deg", RADIAN, math.pi),
        ("90°", RADIAN, math.pi / 2),
        ("60 rpm", RADIAN_PER_SECOND, 2 * math.pi),
        ("pi/4", RADIAN, math.pi / 4),
    ],
)
def test_a_text_is_the_double_nearest_to_the_exact_number(
    text: str, unit: Unit, value: object
) -> None:
    assert number_of(text, "parameters.k", unit) == float(value)


def test_parameters_are_products_of_others() -> None:
    names = {"m": (0.02, KILOGRAM), "R": ("2 cm", METRE), "b": ("m*R", Unit("kg m"))}
    assert number_of("235/625*m*R^2", "parameters.I1", INERTIA, names) == float(
        Fraction(235, 625) * Fraction("0.02") * Fraction("0.02") ** 2
    )
    assert number_of("2*b", "parameters.k", Unit("kg m"), names) == 0.0008


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2/5*m*R", "be in kg m2, but .* is in kg m"),
        ("m*R^2 + R", "add numbers of one unit"),
        ("R^-2", "is in m-2"),
    ],
)
def test_a_formula_has_the_dimension_of_its_number(text: str, message: str) -> None:
    names = {"m": (0.02, KILOGRAM), "R": ("2 cm", METRE)}
    with refusal(message):
        number_of(text, "parameters.I1", INERTIA, names)
    assert number_of("m*R^2 - 1e-6", "parameters.I1", INERTIA, names) == 7e-6
    assert number_of("-(R/4)", "stem.h", METRE, names) == -0.005


def test_parameters_of_a_scenario_must_not_lead_to_one_another() -> None:
    with refusal("I1` must not depend on itself, but does"):
        starting.load("inverting", ["parameters.I1=2*I3", "parameters.I3=I1"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("20 cm", "must be in kg or a unit of the same kind"),
        ("20 flurbs", '"flurbs" is not a unit'),
        ("2*Q", "has 'Q'"),
        ("1/0", "divides by zero"),
        ("9**9**9", "whole powers up to 12"),
        ("2^0.5", "whole powers"),
        ("(((((((9^12)^12)^12)^12)^12)^12)^12)", "numbers of at most 65536 bits"),
        ("*".join(["((9^12)^12)^12"] * 13), "numbers of at most 65536 bits"),
        ("__import__('os').getpid()", "must be a number, arithmetic"),
        ("(" * 150, "must be a number, arithmetic"),
        ("1" * 201, "at most 200 characters"),
        ("1e99999999", "in the range of a double"),  # this took minutes
        ("1 kg*m**9**9**9", "is not a unit"),
    ],
)
def test_what_is_no_number_is_a_sentence(text: str, words: str) -> None:
    with pytest.raises(InputError) as found:
        number_of(text, "parameters.m", KILOGRAM, {"m": (1.0, KILOGRAM)})
    assert words in str(found.value)
    assert "parameters.m" in str(found.value)


def test_hertz_could_be_turns_or_radians() -> None:
    with refusal("could be turns or radians"):
        number_of("25 Hz", "initial.omega3", RADIAN_PER_SECOND)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("5 deg 30 arcmin", RADIAN),  # was their product: 2.6e-56
        ("10 %", RADIAN),
        ("20 deg", ONE),
        ("155 Bq", RADIAN_PER_SECOND),
    ],
)
def test_an_angle_is_no_pure_number(text: str, unit: Unit) -> None:
    with refusal(r"must (be in|have no unit)"):
        number_of(text, "initial.k", unit)


def test_angles_per_second_may_leave_out_the_radian() -> None:
    assert number_of("100 s^-1", "initial.omega3", RADIAN_PER_SECOND) == 100.0


def test_a_sum_before_a_unit_is_in_brackets() -> None:
    assert number_of("(1 + 1) cm", "parameters.R", METRE) == 0.02
    with refusal("sum in brackets"):
        number_of("1 + 1 cm", "parameters.R", METRE)


def test_a_scenario_and_its_assignments_take_them() -> None:
    words = ["m=20 g", "alpha=3/10", "I3=2/5*m*R^2", 'I1="131/350 * m * R^2"']
    assigned = [
        *(f"parameters.{word}" for word in words),
        "initial.omega3=1480 rpm",
        "run.until=2 s",
    ]
    problem = starting.load("inverting", assigned)
    assert problem.parameters == pytest.approx(starting.load("inverting").parameters, rel=1e-15)
    assert problem.initial["omega3"] == pytest.approx(1480 * 2 * math.pi / 60, rel=1e-15)
    assert problem.until == 2.0
