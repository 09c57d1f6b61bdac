"""Numbers with their derivatives, which formulas, jumps, starts and bodies take as numbers.

Arithmetic and functions follow the product and chain rules; a comparison is one of values. What is
differentiated decides what the parts are: numbers, arrays or heyoka expressions.
"""

import operator
from collections.abc import Callable
from contextvars import ContextVar
from functools import reduce
from typing import Any

import numpy as np

from . import operand
from .operand import cos, leaves, log, refill, sin, sqrt


PASCAL = ((1,), (1, 1), (1, 2, 1), (1, 3, 3, 1))
CONSTANT = 0

COMPARED: ContextVar[Callable | None] = ContextVar("compared", default=None)
"""Takes the difference of two numbers that are compared, a Dual, where somebody wants to know by
how much the result could have been another one.
"""


def _power(a: Any, p: Any, r: Any, da: Any, dp: Any) -> Any:
    slope = p * a ** (p - 1) * da
    return slope if dp is CONSTANT else slope + r * log(a) * dp


RULES: dict[str, Callable] = {
    "sqrt": lambda a, r, da: da / (2 * r),
    "sin": lambda a, r, da: cos(a) * da,
    "cos": lambda a, r, da: -(sin(a) * da),
    "exp": lambda a, r, da: r * da,
    "log": lambda a, r, da: da / a,
    "arcsin": lambda a, r, da: da / sqrt(1 - a * a),
    "arctan2": lambda a, b, r, da, db: (b * da - a * db) / (a * a + b * b),
    "hypot": lambda a, b, r, da, db: (a * da + b * db) / r,
    "power": _power,
}
"""The derivative of a function of NumPy, of its operands, its result and their derivatives."""

REFLECTED = {
    "add": operator.add,
    "subtract": lambda b, a: -b + a,
    "multiply": operator.mul,
    "divide": lambda b, a: b.__rtruediv__(a),
    "less": operator.gt,
    "less_equal": operator.ge,
    "greater": operator.lt,
    "greater_equal": operator.le,
    "equal": operator.eq,
}
"""Operations of NumPy on another number and a Dual, by the Dual and the number."""


class Dual:
    """A value and its derivatives: the first, the second, ..., as `parts`.

    A derivative may be an array along several directions, (directions, ...), where the value is a
    number or an array (...).
    """

    __slots__ = ("parts",)
    level = 0
    """Of two numbers, the one of the lower level is a constant for the other one."""

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

    def _like(self, other: Any) -> Any:
        """Return the parts of a number of this level; None: it is constant."""
        if not isinstance(other, Dual) or other.level < self.level:
            return None
        return other.parts if other.level == self.level else NotImplemented

    def __add__(self, other: Any) -> Any:
        more = self._like(other)
        if more is NotImplemented:
            return more
        if more is None:
            return type(self)(self.parts[0] + other, *self.parts[1:])
        return type(self)(*(a + b for a, b in zip(self.parts, more, strict=True)))

    def __sub__(self, other: Any) -> Any:
        more = self._like(other)
        if more is NotImplemented:
            return more
        if more is None:
            return type(self)(self.parts[0] - other, *self.parts[1:])
        return type(self)(*(a - b for a, b in zip(self.parts, more, strict=True)))

    def __mul__(self, other: Any) -> Any:
        a = self.parts
        b = self._like(other)
        if b is NotImplemented:
            return b
        if b is None:
            return type(self)(*(one * other for one in a))
        if len(a) == 2:
            return type(self)(a[0] * b[0], a[1] * b[0] + a[0] * b[1])
        made = []
        for n in range(len(a)):
            total = a[n] * b[0]
            for k in range(1, n + 1):
                total = total + PASCAL[n][k] * (a[n - k] * b[k])
            made.append(total)
        return type(self)(*made)

    def __truediv__(self, other: Any) -> Any:
        b = self._like(other)
        if b is NotImplemented:
            return b
        if b is None:
            return type(self)(*(one / other for one in self.parts))
        made = list[Any]()
        for n, rest in enumerate(self.parts):
            for k in range(1, n + 1):
                rest = rest - PASCAL[n][k] * (made[n - k] * b[k])
            made.append(rest / b[0])
        return type(self)(*made)

    def __neg__(self) -> Any:
        return type(self)(*(-one for one in self.parts))

    def __abs__(self) -> Any:
        return self * np.sign(self.parts[0])

    def __pow__(self, power: Any) -> Any:
        if type(power) is int and power > 0:
            return reduce(operator.mul, [self] * power)
        return np.power(self, power)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __rtruediv__(self, other: Any) -> Any:
        return type(self)(other, *(0 * one for one in self.parts[1:])) / self

    def __rpow__(self, other: Any) -> Any:
        return np.power(other, self)

    __radd__ = __add__
    __rmul__ = __mul__

    def _compared(self, other: Any) -> Any:
        """Return the value of a number with which this one is compared."""
        if compared := COMPARED.get():
            compared(self - other)
        return plain(other)

    def __lt__(self, other: Any) -> Any:
        return self.value < self._compared(other)

    def __le__(self, other: Any) -> Any:
        return self.value <= self._compared(other)

    def __gt__(self, other: Any) -> Any:
        return self.value > self._compared(other)

    def __ge__(self, other: Any) -> Any:
        return self.value >= self._compared(other)

    def __eq__(self, other: Any) -> Any:
        return self.value == self._compared(other)

    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        return bool(self != 0)

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        name = function.__name__
        if name == "absolute":
            return abs(self)
        if name in REFLECTED and not isinstance(inputs[0], Dual):
            return REFLECTED[name](inputs[1], inputs[0])
        if name not in RULES:
            return NotImplemented
        level = max(one.level for one in inputs if isinstance(one, Dual))
        kind = next(type(one) for one in inputs if isinstance(one, Dual) and one.level == level)

        def less(one: Any, part: slice, constant: Any) -> Any:
            if not isinstance(one, Dual) or one.level < level:
                return constant
            some = one.parts[part]
            return some[0] if len(some) == 1 else kind(*some)

        heads = [less(one, slice(-1), one) for one in inputs]
        tails = [less(one, slice(1, None), CONSTANT) for one in inputs]
        lifted = getattr(operand, name.replace("arc", "a"), function)
        r = lifted(*heads)
        rest = RULES[name](*heads, r, *tails)
        rest = rest.parts if type(rest) is kind else (rest,)
        return kind(r.parts[0] if type(r) is kind else r, *rest)


def plain(value: Any) -> Any:
    """Return the value of a number or an expression with derivatives, or of all in a record."""
    if isinstance(value, tuple):
        return refill(value, map(plain, leaves(value)))
    return value.value if isinstance(value, Dual) else value


def has_derivatives(record: tuple) -> bool:
    """Return whether there are derivatives in a record."""
    return any(isinstance(one, Dual) for one in leaves(record))


def parts_of(value: Any, order: int) -> tuple:
    """Return a value and its derivatives; those of a constant are 0."""
    return value.parts if isinstance(value, Dual) else (value, *(0.0,) * order)


def implicit(root: Any, residual: Callable) -> Any:
    """Return the root of residual(x), found for plain numbers, with its derivatives."""
    slope = plain(residual(Dual(root, 1.0)).first)
    return root - residual(root) / slope
