"""Operands of formulas: numbers, arrays, heyoka expressions, and scalars inside numba.

A formula is a Python function of records and operands, marked by `@formula`. The same function is
called with numbers, arrays and duals, with heyoka expressions that are compiled, and inside kernels
of numba; it uses the functions of this module, such as `sin`, so that each of these gets its own.
"""

import math
import operator
import sys
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import heyoka as hy
import numpy as np


# float, complex, array (any precision), heyoka expression; heyoka and numba are untyped
Operand = Any
F = TypeVar("F", bound=Callable)


DOUBLES = {float, np.float64}
_untaught: list[Callable] = []
_teach: Callable = _untaught.append
"""Takes a formula: into a list, until numba is first used; then to numba."""


class Vector(NamedTuple):
    """Cartesian components in the frame fixed in space, z up."""

    x: Operand
    y: Operand
    z: Operand


def formula(function: F) -> F:
    """Mark a function as a formula, which compiled functions of numba may call.

    Parameters
    ----------
    function
        Arithmetic, functions of this module and other formulas; no `if`, no `abs`.

    Returns
    -------
    function
        The same function.

    Notes
    -----
    numba is imported only by those who use it: before it compiles anything, its entry point
    (`numba_extensions` in pyproject.toml) calls `teach_numba`, if this module is imported.
    """
    _teach(function)
    return function


def _lift(name: str) -> Callable:
    """Return a function of operands. Of doubles it has the bits of the C library: those of NumPy
    depend on the processor, and the loop repeats jumps (see `lines`).
    """
    symbolic: Any = getattr(hy, name, None)
    numeric = getattr(np, f"arc{name[1:]}" if name[0] == "a" else name)
    scalar = getattr(math, name)
    doubles = DOUBLES if name != "sqrt" else ()  # it is exact everywhere

    def lifted(*x: Operand) -> Operand:
        """Apply the function of the type of its arguments: floats, expressions, or arrays."""
        if type(x[0]) in doubles and type(x[-1]) in doubles:
            try:
                return np.float64(scalar(*x))
            except (ValueError, OverflowError):  # a result that is not finite
                pass
        return symbolic(*x) if hy.expression in map(type, x) else numeric(*x)

    def for_numba(*x: Any) -> Callable:
        """Return the function that numba compiles for arguments of these types."""
        from numba import types

        is_real = all(isinstance(v, (types.Float, types.Integer)) for v in x)
        return scalar if is_real else numeric

    lifted.__name__ = name
    lifted.for_numba = for_numba  # type: ignore[attr-defined]
    _teach(lifted)
    return lifted


sqrt = _lift("sqrt")
sin = _lift("sin")
cos = _lift("cos")
exp = _lift("exp")
log = _lift("log")
atan2 = _lift("atan2")
asin = _lift("asin")
hypot = _lift("hypot")


def product_error(x: Operand, y: Operand) -> Operand:
    """Return the rounding error of a product.

    x y = fl(x y) + product_error(x, y) exactly (Dekker 1971; an fma in numba).

    Parameters
    ----------
    x, y
        Doubles or arrays of them, of magnitudes at which neither the product nor 2^27 x overflows.

    Returns
    -------
    float or array
        x y - fl(x y).
    """
    product = x * y
    a = _half(x)
    b = _half(y)
    return (((a * b - product) + a * (y - b)) + (x - a) * b) + (x - a) * (y - b)


def _half(x: Operand) -> Operand:
    """Return the upper half of the digits of doubles."""
    big = 134217729 * x  # 2^27 + 1 (Veltkamp 1968)
    return big - (big - x)


@formula
def dot(a: Vector, b: Vector) -> Operand:
    """Return the scalar product a.b."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@formula
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@formula
def times(k: Operand, a: Vector) -> Vector:
    """Return the vector k a, of a number k."""
    return Vector(k * a.x, k * a.y, k * a.z)


@formula
def plus(a: Vector, b: Vector) -> Vector:
    """Return the sum a + b (a NamedTuple's own `+` would join the two)."""
    return Vector(a.x + b.x, a.y + b.y, a.z + b.z)


@formula
def minus(a: Vector, b: Vector) -> Vector:
    """Return the difference a - b."""
    return Vector(a.x - b.x, a.y - b.y, a.z - b.z)


def leaves(record: Any) -> list:
    """Return the numbers of a record of records, in the order in which `refill` takes them.

    Parameters
    ----------
    record
        A NamedTuple whose fields are numbers, arrays, expressions or such records.

    Returns
    -------
    list
        The numbers, depth first.
    """
    return [
        leaf
        for field in record
        for leaf in (leaves(field) if isinstance(field, tuple) else [field])
    ]


def refill(record: Any, values: Any) -> Any:
    """Return the same record of records with other leaves.

    Parameters
    ----------
    record
        The pattern.
    values
        An iterator with as many values as the record has leaves.

    Returns
    -------
    record
        Of the same types.
    """
    make = getattr(record, "_make", tuple)
    return make(refill(f, values) if isinstance(f, tuple) else next(values) for f in record)


def kinds(record: Any) -> tuple:
    """Return the types of a record and of the records in it, depth first.

    Tuples compare by their numbers alone, so caches take these types as a part of their keys.
    """
    return type(record), *(kinds(field) for field in record if isinstance(field, tuple))


def select(choose: Callable[[Any], Callable]) -> Callable:
    """Return a formula that is chosen by the kind of its last argument, a NamedTuple.

    It works in Python and inside numba.

    Parameters
    ----------
    choose
        choose(record) -> the formula, by the type of the record and by the fields that it has or
        leaves empty: inside numba its leaves are types.

    Returns
    -------
    function
        Called with the arguments of the formulas.
    """

    def selected(*arguments: Operand) -> Operand:
        """Return the result of the formula for the kind of the last argument."""
        return choose(arguments[-1])(*arguments)

    def for_numba(*arguments: Any) -> Callable:
        """Return the formula that numba compiles for arguments of these types."""
        record = arguments[-1]
        return choose(record.instance_class._make(record.types))

    selected.for_numba = for_numba  # type: ignore[attr-defined]
    _teach(selected)
    return selected


def teach_numba() -> None:
    """Make every formula callable inside numba.njit.

    numba calls this itself, before its first compilation; where it was imported before, this module
    does.
    """
    global _teach
    if _teach != _untaught.append:
        return
    from numba import types
    from numba.extending import intrinsic, overload, register_jitable

    def teach(function: Callable) -> None:
        """Let numba compile the formula, or the version that its attribute `for_numba` returns.

        for_numba(*types of the arguments) -> the function to compile for them.
        """
        choice = getattr(function, "for_numba", None)
        if choice is None:
            # numpy's error model: a division does not test for zero, 3.1 ns per V instead of 5.7
            register_jitable(error_model="numpy", forceinline=True)(function)
        else:

            @overload(function, jit_options={"error_model": "numpy"})
            def _(*arguments):
                """Return the formula that numba compiles for these arguments."""
                chosen = choice(*arguments)
                return lambda *arguments: chosen(*arguments)

    @intrinsic
    def fma(typing, x, y, z):
        """Declare fma(x, y, z) for numba: the instruction x y + z, which rounds once.

        An intrinsic returns its signature and the function that writes its instructions.
        """
        return types.float64(
            types.float64, types.float64, types.float64
        ), lambda _, builder, __, a: builder.fma(*a)

    @intrinsic
    def plain(typing, record):
        """Declare plain(record) for numba: the conversion of a NamedTuple to a plain tuple."""
        whole = types.Tuple(record.types)
        return whole(record), lambda context, builder, _, a: context.make_tuple(
            builder, whole, [builder.extract_value(a[0], k) for k in range(len(record))]
        )

    @overload(operator.add)  # of a record with a star before other arguments
    def _(before, record):
        """Return how numba adds a record to a tuple: as plain tuples, for calls such as f(*record,
        x).
        """
        if isinstance(before, types.BaseTuple) and isinstance(record, types.BaseNamedTuple):
            return lambda before, record: before + plain(record)  # type: ignore[call-arg]
        return None

    @overload(product_error)
    def _(x, y):
        """Return `product_error` by one fma."""
        return lambda x, y: fma(x, y, -(x * y))  # type: ignore[call-arg]

    _teach = teach
    for function in _untaught:
        teach(function)


if "numba" in sys.modules:  # it may have begun
    teach_numba()
