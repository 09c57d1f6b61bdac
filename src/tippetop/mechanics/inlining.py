"""Formulas of numbers as straight-line Python: every operation once, without calls and records in between.

The operations and their order are those of the formula, and so are the bits of the result; it takes a quarter of the time.
"""

import math
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar


F = TypeVar("F", bound=Callable)
PATIENCE = 16
"""Calls before a formula is traced, which takes as long as some hundred calls."""


class Term:
    """An operand that writes down the operations on it."""

    __slots__ = ("name", "trace")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, trace: "Trace", name: str):
        self.trace, self.name = trace, name

    def __bool__(self) -> bool:
        raise TypeError("a formula that branches has no trace")

    __eq__ = __lt__ = __le__ = __bool__  # type: ignore[assignment]

    def __neg__(self) -> "Term":
        return self.trace.term("-{}", self)

    def sqrt(self) -> "Term":
        """Return the square root; NumPy calls this and the next."""
        return self.trace.term("sqrt({0}) if {0} >= 0.0 else nan", self)


def _binary(symbol: str) -> None:
    def of(self: Term, other: Any) -> Term:
        return self.trace.term(f"{{}} {symbol} {{}}", self, other)

    def reflected(self: Term, other: Any) -> Term:
        return self.trace.term(f"{{}} {symbol} {{}}", other, self)

    name = {"+": "add", "-": "sub", "*": "mul", "/": "truediv", "**": "pow"}[symbol]
    setattr(Term, f"__{name}__", of)
    setattr(Term, f"__r{name}__", reflected)


for _symbol in ("+", "-", "*", "/", "**"):
    _binary(_symbol)


class Trace:
    """The operations of a formula: names by their texts, each text once."""

    def __init__(self) -> None:
        self.names: dict[str, tuple[str, tuple[str, ...]]] = {}
        self.constants: dict[str, Any] = {"sqrt": math.sqrt, "nan": math.nan, "new": tuple.__new__}

    def term(self, text: str, *operands: Any) -> Term:
        """Return the result of an operation."""
        of = tuple(map(self.text, operands))
        name, _ = self.names.setdefault(text.format(*of), (f"t{len(self.names)}", of))
        return Term(self, name)

    def argument(self, value: Any, name: str) -> Any:
        """Return an argument with terms in place of its numbers."""
        if not isinstance(value, tuple):
            return Term(self, name)
        parts = [self.argument(part, self.term(f"{name}[{k}]", Term(self, name)).name) for k, part in enumerate(value)]
        return tuple.__new__(type(value), parts)

    def text(self, value: Any) -> str:
        """Return a value as Python writes it."""
        if isinstance(value, Term):
            return value.name
        if type(value) in (int, float) and math.isfinite(value):
            return f"({value!r})" if value < 0 else repr(value)
        if isinstance(value, tuple | list):
            kind, parts = self.constant(type(value)), "".join(self.text(part) + ", " for part in value)
            return f"new({kind}, ({parts}))" if isinstance(value, tuple) else f"[{parts}]"
        return self.constant(value)

    def constant(self, value: Any) -> str:
        """Return the name of a constant."""
        name = next((name for name, known in self.constants.items() if known is value), f"c{len(self.constants)}")
        self.constants[name] = value
        return name

    def function(self, result: Any, arguments: int) -> Callable:
        """Return the function of a result; operations that it does not need are left out."""
        text, lines, needed = self.text(result), [], set()
        needed.update(names_in(result))
        for line, (name, operands) in reversed(self.names.items()):
            if name in needed:
                needed.update(operands)
                lines.append(f"    {name} = {line}")
        head = f"def inline({', '.join(f'a{k}' for k in range(arguments))}):"
        exec("\n".join([head, *lines[::-1], f"    return {text}"]), self.constants)
        return self.constants["inline"]


def names_in(value: Any) -> list[str]:
    """Return the names of the terms of a record of records."""
    if isinstance(value, tuple | list):
        return [name for part in value for name in names_in(part)]
    return [value.name] if isinstance(value, Term) else []


def inlined(formula: F) -> F:
    """Return a formula that soon takes less time with Python's floats; other operands take the formula itself.

    Parameters
    ----------
    formula
        Its arguments are numbers and records of numbers, and one trace serves all bodies under a law, the last argument. A
        formula that branches stays as it is.
    """
    known: dict[Any, Callable] = {}
    calls: dict[Any, int] = {}

    @wraps(formula)
    def chosen(*arguments: Any) -> Any:
        first = arguments[0]
        while isinstance(first, tuple):
            first = first[0]
        if type(first) is not float:
            return formula(*arguments)
        law = type(getattr(arguments[-1], "friction", None))
        if law in known:
            try:
                return known[law](*arguments)
            except ArithmeticError:
                return formula(*arguments)
        calls[law] = calls.get(law, 0) + 1
        if calls[law] == PATIENCE:
            known[law] = traced(formula, arguments)
        return formula(*arguments)

    return chosen  # type: ignore[return-value]


def traced(formula: Callable, arguments: tuple) -> Callable:
    """Return a formula of these arguments as straight-line Python; the formula itself, if it cannot be."""
    trace = Trace()
    try:
        result = formula(*(trace.argument(value, f"a{k}") for k, value in enumerate(arguments)))
    except Exception:  # whatever a formula does that a Term cannot
        return formula
    return trace.function(result, len(arguments))
