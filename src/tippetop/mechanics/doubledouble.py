"""Numbers as an unevaluated sum head + tail, with twice the digits of a double.

The tail carries what rounding took from the head, to first order; nothing is renormalised but by
`tidy`. Plain arithmetic: fed with decimals or 50-digit numbers, the formulas give what these give,
and the tails are nothing.
"""

from typing import NamedTuple

from .operand import Operand, formula, product_error


class DoubleDouble(NamedTuple):
    """head + tail, |tail| of the order of the rounding of head."""

    head: Operand
    tail: Operand


def doubledouble(x: Operand) -> DoubleDouble:
    """Return the decimal number x as two doubles."""
    head = float(x)
    return DoubleDouble(head, float(x - type(x)(head)))


@formula
def plus(x, y):
    """Return x + y of two DoubleDoubles (Knuth's two-sum)."""
    s = x.head + y.head
    v = s - x.head
    return DoubleDouble(s, ((x.head - (s - v)) + (y.head - v)) + (x.tail + y.tail))


@formula
def minus(x, y):
    """Return x - y of two DoubleDoubles."""
    return plus(x, DoubleDouble(-y.head, -y.tail))


@formula
def tidy(x):
    """Return the same DoubleDouble x with the head rounded from the whole.

    This is needed after a cancellation, if heads are used alone.
    """
    s = x.head + x.tail
    return DoubleDouble(s, x.tail - (s - x.head))


@formula
def times(x, y):
    """Return x y of two DoubleDoubles."""
    return DoubleDouble(
        x.head * y.head, product_error(x.head, y.head) + (x.head * y.tail + x.tail * y.head)
    )


@formula
def scaled(k, x):
    """Return k x of a plain number k and a DoubleDouble x."""
    return DoubleDouble(k * x.head, product_error(k, x.head) + k * x.tail)


@formula
def quotient(x, y, per):
    """Return x/y of two DoubleDoubles, given per = 1/y to a few roundings.

    The remainder corrects it.
    """
    c = x.head * per
    return DoubleDouble(
        c, (((x.head - c * y.head) - product_error(c, y.head)) + (x.tail - c * y.tail)) * per
    )
