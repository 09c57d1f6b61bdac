"""Formulas written as a program in another language, by an operand that records operations.

Fed symbols, a formula gives symbols, and `Program` has a line for each sub-expression, once. So
the C++ of the benchmarks and the JavaScript of the pages are the formulas of this package.
"""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin


class Language(NamedTuple):
    """The syntax of a program: the start of a line, numbers, and functions by their names in
    NumPy."""

    begin: str
    number: Callable[[float], str]
    functions: dict[str, str]


def _functions(prefix: str, **others: str) -> dict[str, str]:
    """Return the names in a library of functions of NumPy: the same ones behind `prefix`.

    `others` are further functions of NumPy, and their names without prefix.
    """
    names = {name: name for name in ("sqrt", "sin", "cos", "exp")} | {"arctan2": "atan2", **others}
    return {name: prefix + word for name, word in names.items()}


CPP = Language(
    "const double ",
    float.hex,
    _functions("std::", rint="rint", absolute="fabs", maximum="fmax", minimum="fmin"),
)
JAVASCRIPT = Language(
    "const ",
    json.dumps,  # with Infinity and NaN
    _functions("Math.", rint="round", absolute="abs", maximum="max", minimum="min"),
)
SIGNS = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}


@dataclass
class Program:
    """A program without branches: lines of text in order, each sub-expression once.

    `lines.Program` is another one, of numbers for the loop.
    """

    language: Language
    # text -> name
    names: dict[str, str] = field(default_factory=dict)
    # name -> names that its line reads
    needs: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def new(self, text: str, needs: Iterable[str] = ()) -> "Symbol":
        """Return the symbol of an expression `text`, which reads the names `needs`.

        An equal text gives the same symbol: each sub-expression gets one line.
        """
        name = self.names.setdefault(text, f"v{len(self.names)}")
        self.needs.setdefault(name, tuple(needs))
        return Symbol(self, name)

    def of(self, value: Any) -> "Symbol":
        """Return a number or a symbol, as a symbol; a number gets no line."""
        if isinstance(value, Symbol):
            return value
        return Symbol(self, self.language.number(float(value)), float(value))

    def combined(self, a: "Symbol", sign: str, b: "Symbol") -> "Symbol":
        """Return a sum, difference, product or quotient, by its `sign`, without needless lines.

        Numbers are computed here, 0 and 1 fold, and a + b is the same expression as b + a.
        """
        x = a.number
        y = b.number
        if x is not None and y is not None and not (sign == "/" and y == 0):
            # all four are computed, hence `or 1` for y = 0
            return self.of({"+": x + y, "-": x - y, "*": x * y, "/": x / (y or 1)}[sign])
        if (sign == "+" and x == 0) or (sign == "*" and x == 1):
            return b
        if (sign in "+-" and y == 0) or (sign in "*/" and y == 1):
            return a
        if (sign in "*/" and x == 0) or (sign == "*" and y == 0):
            return self.of(0.0)
        if sign in "+*" and b.name < a.name:
            a, b = b, a
        right = f"({b.name})" if b.name.startswith("-") else b.name
        return self.new(f"{a.name} {sign} {right}", (a.name, b.name))

    def lines(self, results: Sequence[Any]) -> list[str]:
        """Return the lines that the results need, in order; each ends with a semicolon."""
        wanted = [self.of(result).name for result in results]
        alive: set[str] = set()
        while wanted:
            name = wanted.pop()
            if name in self.needs and name not in alive:
                alive.add(name)
                wanted += self.needs[name]
        return [
            f"{self.language.begin}{name} = {text};"
            for text, name in self.names.items()
            if name in alive
        ]


@dataclass(frozen=True, eq=False)
class Symbol(NDArrayOperatorsMixin):
    """An operand that records the operations on it. 0 and 1 fold."""

    program: Program
    name: str
    number: float | None = None  # its value, if it is a number

    def __repr__(self) -> str:
        return self.name

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any) -> Any:
        """Record a function of NumPy, which arithmetic is too: one of the program's language."""
        name = ufunc.__name__
        program = self.program
        if name == "power":
            return _power(*inputs)
        a, *others = map(program.of, inputs)
        if name in SIGNS:
            return program.combined(a, SIGNS[name], *others)
        if name == "negative":
            if a.number is not None:
                return program.of(-a.number)
            return program.new(f"-{a.name}", (a.name,))
        if name not in program.language.functions:
            raise TypeError(f"a formula must not use `{name}`, nor branch")
        names = [a.name, *(other.name for other in others)]
        return program.new(f"{program.language.functions[name]}({', '.join(names)})", names)

    def __bool__(self) -> bool:
        raise TypeError("a formula must not branch")


def _power(base: Symbol, power: float) -> Any:
    """Return a symbol to the power 1/2, or to a positive whole one as products; others fail.

    Powers of the languages would round in another way.
    """
    if power == 0.5:
        return np.sqrt(base)
    assert power == int(power) > 0, "the formulas' powers are whole"
    return math.prod([base] * int(power), start=base.program.of(1.0))


def function(
    language: Language, inputs: Sequence[str], formula: Callable[[list[Symbol]], Sequence[Any]]
) -> tuple[list[str], list[str]]:
    """Return the lines and the results of a formula.

    Parameters
    ----------
    language
        Of the program.
    inputs
        The expressions that the program has for its inputs.
    formula
        formula(symbols) -> results; a symbol for each input.

    Returns
    -------
    lines : list of str
    results : list of str
        The expression of each result.
    """
    program = Program(language)
    results = [program.of(value) for value in formula([program.new(text) for text in inputs])]
    return program.lines(results), [result.name for result in results]
