"""Functions of numbers as straight-line Python, without calls and records between their operations.

The operations and their order are those of the function, and so are the bits of the result; it
takes a fraction of the time. A function that branches is copied as it runs for some arguments; other
arguments, for which a comparison turns out otherwise, take the function itself.
"""

import math
from collections.abc import Callable
from functools import wraps
from itertools import islice
from typing import Any, TypeVar

import numpy as np

from .operand import leaves
from .writing import Language, Program, Symbol


F = TypeVar("F", bound=Callable)

PATIENCE = 16
"""Calls before a formula is written down, which takes as long as some hundred calls."""

MOST_COPIES = 4
"""Copies of a function, each of which takes other branches."""


class OtherBranchError(ArithmeticError):
    """A comparison in a copy turns out otherwise than when it was written."""


def missed() -> Any:
    """Leave a copy."""
    raise OtherBranchError


FUNCTIONS: dict[str, Callable] = {
    "sqrt": lambda x: math.sqrt(x) if x >= 0 else math.nan,
    "sin": lambda x: float(np.sin(x)),
    "cos": lambda x: float(np.cos(x)),
    "arctan2": lambda y, x: float(np.arctan2(y, x)),
    "absolute": abs,
}
PYTHON = Language("", repr, {name: name for name in FUNCTIONS}, powers=True)


class Trace(Program):
    """The program of one run of a function, whose symbols have values: it takes the branches that
    these values take.
    """

    def __init__(self) -> None:
        super().__init__(PYTHON)
        self.values: dict[str, Any] = {**FUNCTIONS, "record": tuple.__new__, "missed": missed}
        self.values |= {"inf": math.inf, "nan": math.nan}
        self.expected: list[Symbol] = []
        self.executed = 0

    def value(self, symbol: Symbol) -> Any:
        """Return the value of a symbol, after executing the lines that are new."""
        new = islice(self.names.items(), self.executed, None)
        exec("\n".join(f"{name} = {text}" for text, name in new), self.values)
        self.executed = len(self.names)
        return self.values.get(symbol.name, symbol.number)

    def branch(self, symbol: Symbol) -> bool:
        """Return whether a comparison is true, and expect that it is so."""
        is_true = bool(self.value(symbol))
        text = f"{'' if is_true else 'not '}{symbol.name} or missed()"
        self.expected.append(self.new(text, [symbol.name]))
        return is_true

    def call(self, name: str, arguments: tuple) -> Any:
        """Return what a function returns that is called as it is."""
        needs = [name, *(one.name for one in leaves(arguments) if isinstance(one, Symbol))]
        text = f"{name}({', '.join(map(self.written, arguments))})"
        made = self.new(text, needs)
        return self.symbols(self.value(made), made.name)

    def symbols(self, value: Any, text: str) -> Any:
        """Return the same record of symbols, of an expression and its value; words are expected."""
        if value is None:
            return None
        if isinstance(value, tuple):
            parts = (self.symbols(part, f"{text}[{k}]") for k, part in enumerate(value))
            return tuple.__new__(type(value), parts)
        symbol = self.new(text, [text.partition("[")[0]])
        if isinstance(value, str):
            self.branch(self.new(f"{text} == {value!r}", [text.partition("[")[0]]))
            return value
        return symbol

    def constant(self, value: Any) -> str:
        """Return the name of an object that is no number."""
        name = f"k{id(value)}"
        self.values[name] = value
        return name

    def written(self, value: Any) -> str:
        """Return the expression of a record of symbols."""
        if isinstance(value, Symbol | float):
            return self.of(value).name
        if not isinstance(value, tuple | list):
            return self.constant(value)
        parts = "".join(f"{self.written(part)}, " for part in value)
        if type(value) in (list, tuple):
            return f"[{parts}]" if isinstance(value, list) else f"({parts})"
        return f"record({self.constant(type(value))}, ({parts}))"


def straight(function: Callable, arguments: tuple) -> Callable:
    """Return the straight-line copy of a function as it runs for such arguments; the function
    itself, if it cannot be written.
    """
    trace, names = Trace(), [f"a{k}" for k in range(len(arguments))]
    trace.values.update(zip(names, arguments, strict=True))
    try:
        result = function(*map(trace.symbols, arguments, names))
        listed = leaves(tuple(result) if isinstance(result, list) else [result])
        wanted = [one for one in listed if isinstance(one, Symbol)]
        lines = [*trace.lines([*trace.expected, *wanted]), f"return {trace.written(result)}"]
    except Exception:  # whatever a function does that a symbol cannot
        return function
    used = {"k", *FUNCTIONS, "record", "missed", "inf", "nan"}
    known = {name: one for name, one in trace.values.items() if {name, name[0]} & used}
    trace.values = known  # of the arguments nothing
    exec("\n    ".join([f"def copy({', '.join(names)}):", *lines]), known)
    copy = known["copy"]
    copy.trace, copy.result = trace, result
    return copy


def whole(function: F) -> F:
    """Return a function that copies call as it is: not a formula, but a function of numbers."""

    @wraps(function)
    def called(*arguments: Any) -> Any:
        trace = next((one.program for one in leaves(arguments) if isinstance(one, Symbol)), None)
        return trace.call(trace.constant(function), arguments) if trace else function(*arguments)

    called.plain = function  # type: ignore[attr-defined]
    return called  # type: ignore[return-value]


@whole
def unit_of(*values: Any) -> float:
    """Return a power of two near the largest of some numbers."""
    return math.ldexp(1.0, math.frexp(max(map(abs, map(float, values))))[1])


def inlined(function: F) -> F:
    """Return a function that soon takes less time with Python's floats; other operands take the
    function itself.

    Parameters
    ----------
    function
        Its arguments are numbers and records of numbers, the last of them the body; it gives such a
        record, a list or a number.
    """
    # by the records of the body and of the friction law
    known: dict[tuple[type, type], list[Callable]] = {}
    calls: dict[tuple[type, type], int] = {}

    @wraps(function)
    def chosen(*arguments: Any) -> Any:
        first = arguments[0]
        while isinstance(first, tuple):
            first = first[0]
        if type(first) is not float:
            return function(*arguments)
        body = arguments[-1]
        kinds = type(body), type(getattr(body, "friction", None))
        copies = known.get(kinds, ())
        for copy in copies:
            try:
                result = copy(*arguments)
                chosen.used = copy  # type: ignore[attr-defined]
                return result
            except ArithmeticError:
                pass
        if len(copies) < MOST_COPIES:
            calls[kinds] = calls.get(kinds, 0) + 1
            if calls[kinds] == PATIENCE:
                calls[kinds] = 0
                known[kinds] = [*copies, straight(function, arguments)]
        return function(*arguments)

    chosen.plain = function  # type: ignore[attr-defined]
    return chosen  # type: ignore[return-value]
