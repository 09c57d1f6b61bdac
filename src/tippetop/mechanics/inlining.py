"""Formulas of numbers as straight-line Python, without calls and records between their operations.

The operations and their order are those of the formula, and so are the bits of the result; it takes
a fraction of the time.
"""

import math
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from .operand import leaves
from .writing import Language, Program


F = TypeVar("F", bound=Callable)

PATIENCE = 16
"""Calls before a formula is written down, which takes as long as some hundred calls."""

FUNCTIONS: dict[str, Callable] = {
    "sqrt": lambda x: math.sqrt(x) if x >= 0 else math.nan,
    "sin": lambda x: float(np.sin(x)),
    "cos": lambda x: float(np.cos(x)),
    "arctan2": lambda y, x: float(np.arctan2(y, x)),
}
PYTHON = Language("", repr, {name: name for name in FUNCTIONS}, powers=True)


def inlined(formula: F) -> F:
    """Return a formula that soon takes less time with Python's floats; other operands take the
    formula itself.

    Parameters
    ----------
    formula
        Its arguments are numbers and records of numbers, the last of them the body; it gives such a
        record, a list or a number. One that branches stays as it is.
    """
    known: dict[
        tuple[type, type], Callable
    ] = {}  # by the records of the body and of the friction law
    calls: dict[tuple[type, type], int] = {}

    @wraps(formula)
    def chosen(*arguments: Any) -> Any:
        first = arguments[0]
        while isinstance(first, tuple):
            first = first[0]
        if type(first) is not float:
            return formula(*arguments)
        body = arguments[-1]
        kinds = type(body), type(getattr(body, "friction", None))
        if kinds in known:
            try:
                return known[kinds](*arguments)
            except ArithmeticError:
                return formula(*arguments)
        calls[kinds] = calls.get(kinds, 0) + 1
        if calls[kinds] == PATIENCE:
            known[kinds] = straight(formula, arguments)
        return formula(*arguments)

    chosen.plain = formula  # type: ignore[attr-defined]
    return chosen  # type: ignore[return-value]


def straight(formula: Callable, arguments: tuple) -> Callable:
    """Return the straight-line function of a formula of such arguments; the formula itself, if it
    cannot be written.
    """
    program = Program(PYTHON)
    names: dict[str, Any] = {**FUNCTIONS, "record": tuple.__new__}

    def symbols(value: Any, text: str) -> Any:
        if not isinstance(value, tuple):
            return program.new(text)
        return tuple.__new__(
            type(value), [symbols(part, f"{text}[{k}]") for k, part in enumerate(value)]
        )

    def written(value: Any) -> str:
        if not isinstance(value, tuple | list):
            return program.of(value).name
        parts = "".join(f"{written(part)}, " for part in value)
        if isinstance(value, list):
            return f"[{parts}]"
        names[name := f"kind{len(names)}"] = type(value)
        return f"record({name}, ({parts}))"

    try:
        result = formula(*(symbols(value, f"a{k}") for k, value in enumerate(arguments)))
        lines = program.lines(leaves(tuple(result) if isinstance(result, list) else [result]))
    except Exception:  # whatever a formula does that a symbol cannot
        return formula
    head = f"def function({', '.join(f'a{k}' for k in range(len(arguments)))}):"
    exec("\n    ".join([head, *lines, f"return {written(result)}"]), names)
    return names["function"]
