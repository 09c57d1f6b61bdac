"""Numbers as texts, "3/10", "2/5*m*R^2", "20 g": computed exactly, rounded once.

A formula with names must have the dimension of its number; literals in it are pure numbers, but a
sum may have one in SI units.

`ast` reads the arithmetic and pint the units, in fractions. They are not mixed, because `m`, `g`
and `R` are names of both: a text is arithmetic of numbers and names, or arithmetic of numbers
followed by a unit.
"""

import ast
import operator
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from itertools import zip_longest
from typing import Any, NoReturn

from ..errors import InputError, suggestion
from .units import RADIAN_PER_SECOND, Unit


PI = Fraction("3.14159265358979323846264338327950288419716939937510")
MOST_CHARACTERS = 200
MOST_POWER = 12
MOST_EXPONENT = 2048  # of ten in a literal: doubles have 324 at most
MOST_BITS = 1 << 16  # of an exact number: a power of powers may have billions
OPERATORS: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
MEASURED = re.compile(
    r"(?P<number>[-+0-9.eE/*() ]*[0-9.)])\s*"
    r"(?P<unit>(?![eE][-+]?\d)[^\W\d_].*|[°%].*)(?<![-*/+(^])",
    re.DOTALL,
)
UNIT = re.compile(r"[^\W\d_]\w*(\s*(\*\*|\^)\s*\(?-?\d{1,2}\)?(?!\d))?|[°%](?!\d)|[*/·()\s]")
"""One part of a unit. pint computes everything else in its argument, however large."""
POWER = re.compile(r"(?<=[^\W\d_])\s*(?:\*\*|\^)?\s*(\()?([-+]?)(\d{1,2})(?![\w.])(?(1)\))")
"""The power of a unit: m2, s-1, m^2, m**(-1)."""
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
HERTZ = re.compile(r"\b(k?Hz|k?hertz)\b")
Powers = tuple[int, ...]
"""Of kg, m and s; empty of a number without names."""
FORMS = (
    'be a number, arithmetic of numbers (and of parameters, where there are any: "2/5*m*R^2"), '
    'or a number with its unit ("20 g", "2 min")'
)


def number_of(text: str, key: str, unit: Unit, names: Mapping[str, Any] | None = None) -> float:
    """Return the number of a text in SI units.

    Parameters
    ----------
    text
        Arithmetic of numbers, pi and `names` (+ - * / ^ and brackets), or arithmetic of numbers and
        then a unit.
    key
        The dotted name of the number; the text of `parameters.R` must not depend on R.
    unit
        The unit of the result.
    names
        Pairs of a number, or a text, and its unit. They must not depend on themselves.

    Returns
    -------
    float
        The double that is nearest to the exact number.

    Raises
    ------
    InputError
        If the text is not a number, has an unknown name, or has another dimension.
    """
    reading = _Reading(text, key, unit, dict(names or {}), (key.removeprefix("parameters."),))
    try:
        return float(reading.exact())
    except ZeroDivisionError:
        reading.refuse("be a number", f'"{text}" divides by zero')
    except ArithmeticError:
        reading.refuse("be a number in the range of a double", f'"{text}" is not')


@dataclass
class _Reading:
    """A text that is being read as a number; `under` has the names whose numbers depend on it.

    The other fields are the arguments of `number_of`, which makes one; `named` makes one for each
    name in a text.
    """

    text: str
    key: str
    unit: Unit
    names: dict[str, Any]
    under: tuple[str, ...]

    def refuse(self, must: str, but: str = "", near: str = "") -> NoReturn:
        """Raise InputError with a sentence: what the number `must` be, and `but` is."""
        but = but or f'is "{self.text}"'
        raise InputError([f"`{self.key}` must {must}, but {but}.{near}"]) from None

    def exact(self) -> Fraction:
        """Return the number of the text, exactly, in SI units."""
        if len(self.text) > MOST_CHARACTERS:
            self.refuse(
                f"be at most {MOST_CHARACTERS} characters of arithmetic", f"has {len(self.text)}"
            )
        text = self.text.strip()
        measured = MEASURED.fullmatch(text)
        number = _tree(measured["number"]) if measured else None
        if measured is None or number is None:
            value, powers = self.term(_tree(text))
            if powers not in ((), self.unit.powers):
                self.refuse(f"be in {self.unit.symbol}", f'"{self.text}" is in {_symbol(powers)}')
            return value
        match number:
            case ast.BinOp(op=ast.Add() | ast.Sub(), col_offset=0):
                self.refuse("have its sum in brackets before a unit")
        return self.converted(self.term(number)[0], measured["unit"])

    def term(self, node: ast.expr | None) -> tuple[Fraction, Powers]:
        """Return the number of an expression, exactly in SI units, and its powers of kg, m and s.

        Raises InputError for numbers so long that arithmetic with them would take too long.
        """
        value, powers = self.computed(node)
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > MOST_BITS:
            self.refuse(f"be computed from numbers of at most {MOST_BITS} bits")
        return value, powers

    def computed(self, node: ast.expr | None) -> tuple[Fraction, Powers]:
        """Return the number of an expression, however long, and its powers; see `term`.

        Parts of it are taken by `term`, which limits their length.
        """
        match node:
            case ast.Constant(value=number) if type(number) is int:
                return Fraction(number), ()
            case ast.Constant(value=float()):
                literal = Decimal(ast.get_source_segment(_python(self.text), node) or "")
                if abs(literal.adjusted()) > MOST_EXPONENT:
                    raise OverflowError
                return Fraction(literal), ()
            case ast.Name(id="pi"):
                return PI, ()
            case ast.Name(id=name):
                return self.named(name), self.names[name][1].powers
            case ast.UnaryOp(op=ast.UAdd(), operand=inner):
                return self.term(inner)
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                value, powers = self.term(inner)
                return -value, powers
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
                (one, first), (other, second) = self.term(left), self.term(right)
                match op:
                    case ast.Pow():
                        if other.denominator != 1 or abs(other) > MOST_POWER:
                            self.refuse(f"have whole powers up to {MOST_POWER}")
                        powers = tuple(other.numerator * n for n in first)
                    case ast.Mult() | ast.Div():
                        sign = -1 if isinstance(op, ast.Div) else 1
                        both = zip_longest(first, second, fillvalue=0)
                        powers = tuple(n + sign * more for n, more in both)
                    case _:
                        if first and second and first != second:
                            words = f'"{self.text}" adds {_symbol(first)} to {_symbol(second)}'
                            self.refuse("add numbers of one unit", words)
                        powers = first or second
                return OPERATORS[type(op)](one, other), powers
        return self.refuse(FORMS)

    def named(self, name: str) -> Fraction:
        """Return the number of a name in an expression, exactly, in SI units. Raises InputError.

        A text is computed once, and replaced in `names`.
        """
        if name in self.under and name in self.names:
            raise InputError(
                [f'`parameters.{name}` must not depend on itself, but does, by "{self.text}".']
            )
        if name not in self.names:
            near = suggestion(name, self.names)
            if name == self.text.strip():
                self.refuse("be a number", f"is {self.text!r}", near)
            others = (
                f", pi and {', '.join(n for n in self.names if n not in self.under)}"
                if self.names
                else " and pi"
            )
            self.refuse(
                f"be a number, or arithmetic of numbers{others}",
                f'"{self.text}" has {name!r}',
                near,
            )
        value, unit = self.names[name]
        if isinstance(value, str):
            inner = _Reading(value, f"parameters.{name}", unit, self.names, (*self.under, name))
            value = inner.exact()
            self.names[name] = value, unit
        return value if isinstance(value, Fraction) else Fraction(str(value))

    def converted(self, value: Fraction, given: str) -> Fraction:
        """Return `value` in the unit `given` exactly in SI units. Raises InputError."""
        import pint

        symbol = self.unit.symbol
        must = "have no unit" if symbol == "1" else f"be in {symbol} or a unit of the same kind"
        if self.unit == RADIAN_PER_SECOND and HERTZ.search(given):
            self.refuse(
                "be in rad/s, deg/s or rpm", f'"{self.text}" could be turns or radians per second'
            )
        unit = _powers(given)
        if UNIT.sub("", unit):
            self.refuse(must, f'"{given}" is not a unit')
        try:
            measured = _registry().Quantity(value, unit)
            result = measured.to(_powers(symbol))
            parts, asked = (dict(q.to_root_units().unit_items()) for q in (measured, result))
        except pint.DimensionalityError:
            self.refuse(must)
        except pint.UndefinedUnitError:
            self.refuse(must, f'"{given}" is not a unit')
        except Exception:  # of many kinds, by the text
            self.refuse(FORMS)
        # pint takes angles and their powers for pure numbers; s-1 for rad s-1 is understood
        turned = parts.get("radian", 0)
        if "count" in parts or (turned != asked.get("radian", 0) and (turned or not parts)):
            self.refuse(must)
        return Fraction(result.magnitude)


def _symbol(powers: Powers) -> str:
    """Return the symbol of a unit with these powers of kg, m and s."""
    pairs = zip(("kg", "m", "s"), powers, strict=True)
    return " ".join(f"{name}{'' if n == 1 else n}" for name, n in pairs if n) or "1"


def _python(text: str) -> str:
    """Return a text with `^` as the power of Python."""
    return text.strip().replace("^", "**")


def _tree(text: str) -> ast.expr | None:
    """Return the syntax tree of the arithmetic in a text, or None."""
    try:
        return ast.parse(_python(text), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _powers(unit: str) -> str:
    """Return the text of a unit as pint reads it: "kg m2" or "kg m²" as "kg m**(2)"."""
    return POWER.sub(
        lambda power: f"**({power[2].strip('+')}{power[3]})", unit.translate(SUPERSCRIPTS)
    )


@lru_cache(maxsize=1)
def _registry() -> Any:
    """Return pint's units, with exact fractions."""
    import pint

    registry: Any = pint.UnitRegistry(non_int_type=Fraction)
    registry.define("@alias turn = rev")
    return registry


# --- tables -------------------------------------------------------------------------------------


def worked_out(
    tables: Mapping[str, Any], units: Mapping[str, Mapping[str, Unit]]
) -> dict[str, Any]:
    """Return tables with numbers in place of texts.

    Parameters
    ----------
    tables
        The tables of a scenario, or any others.
    units
        The unit of each number, by table and key; other keys are kept. Every table may name numbers
        of `parameters`.

    Returns
    -------
    dict
        The tables, with their keys in the same order.

    Raises
    ------
    InputError
        One sentence for each text that is not a number.
    """
    given = tables.get("parameters")
    of_body = units.get("parameters", {})
    result = dict(tables)
    faults = []
    for table, of_table in units.items():
        values = tables.get(table)
        for name, text in values.items() if isinstance(values, Mapping) else ():
            if isinstance(text, str) and name in of_table:
                key = f"{table}.{name}"
                names = {
                    name: (value, of_body[name])
                    for name, value in (given.items() if isinstance(given, Mapping) else ())
                    if name in of_body and (isinstance(value, str) or _is_number(value))
                }
                try:
                    number = number_of(text, key, of_table[name], names)
                    result[table] = {**result[table], name: number}
                except InputError as error:
                    faults += error.sentences
    if faults:
        raise InputError(faults)
    return result


def _is_number(value: Any) -> bool:
    """Return whether a value is a finite int or float, and no bool."""
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return plain and abs(value) <= sys.float_info.max
