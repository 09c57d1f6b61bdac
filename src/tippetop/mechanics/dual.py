"""Numbers with their derivatives, which formulas, jumps, starts and bodies take as numbers.

Arithmetic and functions of NumPy follow the product and chain rules; a comparison is one of values.
What is differentiated decides what the parts are: numbers, arrays or heyoka expressions.
`engine.derivatives` and `contact.outline` use them.

Symbols
    parts     a value and its derivatives, [value, first, second, ...]; a, b, r: parts or values
    da, db    derivatives of a, b
"""

import operator
from collections import deque
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from functools import reduce
from itertools import zip_longest
from math import comb
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from . import operand
from .operand import cos, leaves, log, refill, sin, sqrt


CONSTANT = 0
"""The derivative of a constant."""

COMPARED: ContextVar[Any] = ContextVar("compared", default=deque(maxlen=0))  # noqa: B039
"""The differences of numbers that are compared, Duals, if a list is set; by default none are kept.
"""


def _sum(a: Sequence, b: Sequence) -> list:
    """Return the parts of a sum of two numbers with parts a and b, of any lengths.

    A part that is missing at the end of a term is 0.
    """
    return [y if x is None else x if y is None else x + y for x, y in zip_longest(a, b)]


def _product(a: Sequence, b: Sequence) -> list:
    """Return the parts of a product, its value and derivatives, by Leibniz's rule.

    A part that is missing at the end of a factor is 0.
    """
    made = []
    for n in range(max(len(a), len(b))):
        present = [k for k in range(n + 1) if n - k < len(a) and k < len(b)]
        terms = (a[n - k] * b[k] for k in present)
        if n > 1:
            terms = (comb(n, k) * term for k, term in zip(present, terms, strict=True))
        made.append(reduce(operator.add, terms))
    return made


def _solved(a: Sequence, made: list, b: Sequence, divisor: Any) -> list:
    """Return a factor and its derivatives, of which some are `made`: Leibniz's rule for a = made b,
    solved for the highest derivative, whose own factor is `divisor`.

    It appends to `made`, which may be `b` itself, as of a root.
    """
    for n in range(len(made), max(len(a), len(b))):
        rest = a[n] if n < len(a) else CONSTANT
        for k in range(1, min(n + 1, len(b))):
            rest = rest - comb(n, k) * (made[n - k] * b[k])
        made.append(rest / divisor)
    return made


def _root(a: Sequence) -> list:
    """Return the parts of a square root: Leibniz's rule for a = r r, solved for r."""
    made = [sqrt(a[0])]
    return _solved(a, made, made, 2 * made[0])


ARITHMETIC: dict[str, Callable] = {
    "add": _sum,
    "subtract": lambda a, b: _sum(a, [-one for one in b]),
    "multiply": _product,
    "divide": lambda a, b: _solved(a, [], b, b[0]),
    "sqrt": _root,
    "negative": lambda a: [-one for one in a],
    "absolute": lambda a: [(1.0 * (a[0] > 0) - (a[0] < 0)) * one for one in a],
}
"""Functions of NumPy by their names there, of the parts of their operands; a constant has one part.
"""


def _power(a: Any, p: Any, r: Any, da: Any, dp: Any) -> Any:
    """Return the derivative of r = a^p, by the derivatives da and dp of a and p.

    For a constant power dp is the object `CONSTANT` itself, and no logarithm is taken: a may be 0.
    """
    slope = p * a ** (p - 1) * da
    return slope if dp is CONSTANT else slope + r * log(a) * dp


RULES: dict[str, Callable] = {
    "sin": lambda a, r, da: cos(a) * da,
    "cos": lambda a, r, da: -(sin(a) * da),
    "exp": lambda a, r, da: r * da,
    "log": lambda a, r, da: da / a,
    "arcsin": lambda a, r, da: da / sqrt(1 - a * a),
    "arctan2": lambda a, b, r, da, db: (b * da - a * db) / (a * a + b * b),
    "hypot": lambda a, b, r, da, db: (a * da + b * db) / r,
    "power": _power,
}
"""The derivative of a function of NumPy, of its operands, its result, and the derivatives of the
operands, in this order."""
COMPARISONS = {"less", "less_equal", "greater", "greater_equal", "equal", "not_equal"}


class Dual(NDArrayOperatorsMixin):
    """A value and its derivatives: the first, the second, ..., as `parts`.

    A derivative may be an array along several directions, (directions, ...), where the value is a
    number or an array (...).
    """

    __slots__ = ("parts",)
    level = 0
    """A number of a lower level is a constant."""
    __hash__ = object.__hash__

    def __init__(self, *parts: Any):
        self.parts = parts

    def __repr__(self) -> str:
        return f"{type(self).__name__}{self.parts}"

    @property
    def value(self) -> Any:
        """Return the value."""
        return self.parts[0]

    @property
    def first(self) -> Any:
        """Return the first derivative."""
        return self.parts[1]

    def __bool__(self) -> bool:
        COMPARED.get().append(self)
        return bool(self.value)

    def __pow__(self, power: Any) -> Any:
        if type(power) is int and power > 0:
            return reduce(operator.mul, [self] * power)
        return self.__array_ufunc__(np.power, "__call__", self, power)

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply a numpy function by the product and chain rules; a comparison compares values.

        Of duals at several levels, the highest level is differentiated, and the rest are its
        numbers.
        """
        name = function.__name__
        if name in COMPARISONS:
            COMPARED.get().append(np.subtract(*inputs))
            return function(*map(plain, inputs))
        kind = type(self)
        for one in inputs:
            if getattr(one, "level", 0) > kind.level:
                kind = type(one)
        every = [one.parts if type(one) is kind else (one,) for one in inputs]
        if name in ARITHMETIC:
            return kind(*ARITHMETIC[name](*every))
        if name not in RULES:
            return NotImplemented

        def joined(parts: Sequence) -> Any:
            """Return parts as one number with derivatives, or as the plain number."""
            return parts[0] if len(parts) == 1 else kind(*parts)

        # the chain rule on numbers of one order less: `tails` are the derivatives of `heads`
        heads = [joined(parts[:-1] or parts) for parts in every]
        tails = [joined(parts[1:] or (CONSTANT,)) for parts in every]
        # `operand` has names of `math`: asin, atan2; without one, the function of NumPy
        r = getattr(operand, name.replace("arc", "a"), function)(*heads)
        rest = RULES[name](*heads, r, *tails)
        first, *_ = r.parts if type(r) is kind else (r,)
        return kind(first, *(rest.parts if type(rest) is kind else (rest,)))


def plain(value: Any) -> Any:
    """Return the plain value of a number with derivatives.

    Of a record, return the record of plain values.
    """
    if isinstance(value, tuple):
        return refill(value, map(plain, leaves(value)))
    return plain(value.value) if isinstance(value, Dual) else value


def has_derivatives(record: tuple) -> bool:
    """Return whether there are derivatives in a record."""
    return any(isinstance(one, Dual) for one in leaves(record))


def parts_of(value: Any, order: int) -> tuple:
    """Return a value and its derivatives up to an order; those of a constant are 0."""
    known = value.parts if isinstance(value, Dual) else (value,)
    return (*known, *(0.0,) * order)[: order + 1]


class Line(Dual):
    """A number along a line of its own, such as an unknown."""

    __slots__ = ()
