"""A formula means the same in every world: floats, complex numbers, arrays of any precision,
heyoka, numba.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any, NamedTuple

import heyoka as hy
import mpmath as mp
import numba
import numpy as np
import pytest

from tippetop.mechanics import doubledouble
from tippetop.mechanics.operand import (
    Vector,
    atan2,
    cos,
    exp,
    formula,
    kinds,
    log,
    product_error,
    select,
    sin,
    sqrt,
)


@formula
def mixed(x, y):
    """Every elementary function that a formula may use, well conditioned."""
    return sqrt(1 + x * x) + sin(x) * cos(y) + exp(-x) + atan2(y, x) / 2


def test_functions_of_doubles_have_the_bits_of_the_c_library() -> None:
    """NumPy's vector code for this processor has others, in one of 20 values of exp."""
    for x in np.random.default_rng(1).uniform(0.1, 3.0, 200).tolist():
        for function in (exp, log, sin, cos):
            assert function(x) == getattr(math, function.__name__)(x)
        assert atan2(np.float64(x), 2.0) == math.atan2(x, 2.0)
    with np.errstate(all="ignore"):
        assert (exp(1e3), log(0.0)) == (math.inf, -math.inf)
        assert math.isnan(sin(math.inf))


def by_float(x: float, y: float) -> Any:
    return mixed(x, y)


def by_array(x: float, y: float) -> Any:
    return mixed(np.full(3, x), np.full(3, y))[1]


def by_longdouble(x: float, y: float) -> Any:
    found = mixed(np.longdouble(x), np.longdouble(y))
    assert found.dtype == np.longdouble
    return found


def by_heyoka(x: float, y: float) -> Any:
    symbols = hy.make_vars("x", "y")
    return hy.cfunc([mixed(*symbols)], list(symbols))(np.array([x, y]))[0]


@numba.njit
def _inside(x, y):
    return mixed(x, y)


def by_numba(x: float, y: float) -> Any:
    return _inside(x, y)


WORLDS = (
    by_float,
    by_array,
    by_longdouble,
    by_heyoka,
    by_numba,
)


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.__name__)
def test_elementary_functions_agree_with_40_digits(
    world: Callable, rng: np.random.Generator
) -> None:
    with mp.workdps(40):
        for x, y in rng.uniform(0.2, 2.0, (20, 2)):
            a, b = mp.mpf(x), mp.mpf(y)
            exact = mp.sqrt(1 + a * a) + mp.sin(a) * mp.cos(b) + mp.exp(-a) + mp.atan2(b, a) / 2
            wide = isinstance(found := world(x, y), np.longdouble)
            number = (
                mp.mpf(float(found)) + mp.mpf(float(found - np.longdouble(float(found))))
                if wide
                else mp.mpf(found)
            )
            assert abs(number / exact - 1) < (2.0**-61 if wide else 2.0**-50)


# --- vectors ------------------------------------------------------------------------------------


# --- products with their rounding ---------------------------------------------------------------


@numba.njit
def _error_inside(x, y):
    return product_error(x, y)


@pytest.mark.parametrize("error", [product_error, _error_inside], ids=["Dekker", "fma"])
def test_a_product_and_its_error_are_exact(error: Callable, rng: np.random.Generator) -> None:
    """x y = fl(x y) + error, as rational numbers; in numba by another algorithm, with the same
    result.
    """
    numbers = rng.uniform(-1, 1, (300, 2)) * 10.0 ** rng.uniform(-100, 100, (300, 2))
    for x, y in numbers.tolist():
        assert Fraction(x) * Fraction(y) == Fraction(x * y) + Fraction(float(error(x, y)))


def exact(x: doubledouble.DoubleDouble) -> Fraction:
    return Fraction(float(x.head)) + Fraction(float(x.tail))


def test_two_doubles_calculate_with_twice_the_digits(rng: np.random.Generator) -> None:
    """Sums, products and quotients of head + tail against rational numbers: to 2^-100 of the
    largest part.
    """
    for a, b, c, d in rng.uniform(0.5, 2, (200, 4)).tolist():
        x, y = (
            doubledouble.DoubleDouble(a, c * 2.0**-54),
            doubledouble.DoubleDouble(b, -d * 2.0**-54),
        )
        found = {
            "sum": (doubledouble.plus(x, y), exact(x) + exact(y)),
            "difference": (doubledouble.minus(x, y), exact(x) - exact(y)),
            "product": (doubledouble.times(x, y), exact(x) * exact(y)),
            "multiple": (doubledouble.scaled(b, x), Fraction(b) * exact(x)),
            "quotient": (doubledouble.quotient(x, y, 1 / y.head), exact(x) / exact(y)),
        }
        for name, (value, wanted) in found.items():
            assert abs(exact(value) - wanted) < 2**-100 * 4, name
        tidy = doubledouble.tidy(found["difference"][0])
        assert exact(tidy) == exact(found["difference"][0])
        assert abs(tidy.tail) <= math.ulp(tidy.head) / 2


def test_a_decimal_number_keeps_its_digits_in_two_doubles() -> None:
    with localcontext() as context:
        context.prec = 50
        x = Decimal("0.1234567890123456789012345678901234567890")
        found = doubledouble.doubledouble(x)
        assert found.head == float(x)
        assert abs(Decimal(found.head) + Decimal(found.tail) - x) < Decimal("1e-33")


# --- records ------------------------------------------------------------------------------------


class Red(NamedTuple):
    k: Any


class Blue(NamedTuple):
    k: Any


@formula
def _red(x, record):
    return x + record.k


@formula
def _blue(x, record):
    return x * record.k


chosen = select(lambda record: _red if isinstance(record, Red) else _blue)


@numba.njit
def _chosen_inside(x, record):
    return chosen(x, record)


@pytest.mark.parametrize("world", [chosen, _chosen_inside], ids=["Python", "numba"])
def test_a_formula_is_chosen_by_the_type_of_its_last_argument(world: Callable) -> None:
    assert world(2.0, Red(5.0)) == 7.0
    assert world(2.0, Blue(5.0)) == 10.0


def test_equal_records_of_other_types_have_other_kinds() -> None:
    whole, other = Vector(1.0, Red(5.0), ()), Vector(1.0, Blue(5.0), ())
    assert whole == other
    assert kinds(whole) == (Vector, (Red,), (tuple,)) != kinds(other)
