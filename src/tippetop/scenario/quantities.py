"""Numbers as people have them: "3/10", "2/5*m*R^2", "20 g", "5.7 deg", "1480 rpm"; worked out exactly, rounded once."""

import ast
import math
import operator
import re
import sys
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any

from ..errors import InputError, suggestion
from ..mechanics.units import RADIAN_PER_SECOND, Unit


PI = Fraction("3.14159265358979323846264338327950288419716939937510")
LONGEST = 200  # characters
LARGEST_POWER = 12
MOST_BITS = 8192  # of numerator and denominator: doubles need 1075 at most
BINARY: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
MEASURED = re.compile(
    r"\s*(?P<number>[-+0-9.eE/*() ]*[0-9.)])\s*(?P<unit>(?![eE][-+]?\d)[^\W\d_].*|°.*|%.*)", re.DOTALL
)
UNIT = re.compile(r"[^\W\d_]\w*(\s*(\*\*|\^)\s*\(?-?\d{1,2}\)?(?!\d))?|[°%](?!\d)|[*/·()\s]")  # one part of a unit
EXPONENT = re.compile(r"[eE]([-+]?[\d_]+)$")
POWER = re.compile(r"(?<=[^\W\d_])\s*(?:\*\*|\^)?\s*(\()?([-+]?)(\d{1,2})(?![\w.])(?(1)\))")  # m2, s-1, m^2, m**(-1)
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
HERTZ = re.compile(r"\b(k?Hz|k?hertz)\b")


def number_of(text: str, key: str, unit: Unit, names: Mapping[str, Any] | None = None, own: str = "") -> float:
    """The number that a text stands for, in SI units.

    Parameters
    ----------
    text
        Arithmetic of numbers, pi and `names` (+ - * / ^ and brackets), or arithmetic of numbers and then a unit.
    key
        Where it stands, dotted: for the sentence.
    unit
        What the number must measure.
    names
        Numbers by name, or texts that stand for numbers: worked out too. Must not lead back to themselves.
    own
        The name among them that the text is the number of, if it is one.

    Returns
    -------
    float
        The double that is nearest to the exact number.

    Raises
    ------
    InputError
        If it is no such text, names what is not there, or has another dimension.
    """
    try:
        return float(_exact(text, key, unit, dict(names or {}), (own,) if own else ()))
    except ZeroDivisionError:
        raise InputError([f'`{key}` must be a number, but "{text}" divides by zero.']) from None
    except OverflowError:
        raise InputError([f'`{key}` must be a number in the range of a double, but "{text}" is not.']) from None


def _exact(text: str, key: str, unit: Unit, names: dict[str, Any], under: tuple[str, ...]) -> Fraction:
    if len(text) > LONGEST:
        raise InputError([f"`{key}` must be at most {LONGEST} characters of arithmetic, but has {len(text)}."])
    measured = MEASURED.fullmatch(text)
    if measured and not text.rstrip().endswith(tuple("*/+-(^")) and measured["unit"].strip() != "":
        head = _tree(measured["number"], key, text, quiet=True)
        if head is not None:
            if isinstance(head, ast.BinOp) and isinstance(head.op, ast.Add | ast.Sub) and head.col_offset == 0:
                raise InputError([f'`{key}` must have its sum in brackets before a unit, but is "{text}".'])
            return _converted(_value(head, key, text, {}, ()), measured["unit"].strip(), key, text, unit)
    tree = _tree(text, key, text)
    assert tree is not None
    return _value(tree, key, text, names, under)


def _tree(source: str, key: str, text: str, quiet: bool = False) -> ast.expr | None:
    """The arithmetic of a text."""
    try:
        return ast.parse(source.strip().replace("^", "**"), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        if quiet:
            return None
        raise InputError([_wrong(key, text)]) from None


def _wrong(key: str, text: str) -> str:
    return (
        f'`{key}` must be a number, arithmetic of numbers (and of parameters, where there are any: "2/5*m*R^2"), '
        f'or a number with its unit ("20 g", "2 min"), but is "{text}".'
    )


def _value(node: ast.expr, key: str, text: str, names: dict[str, Any], under: tuple[str, ...]) -> Fraction:
    """What an expression is worth."""
    match node:
        case ast.Constant(value=bool()):
            pass
        case ast.Constant(value=int() | float()):
            literal = ast.get_source_segment(text.strip().replace("^", "**"), node) or str(node.value)
            exponent = EXPONENT.search(literal)
            if exponent and abs(int(exponent[1])) > MOST_BITS // 4:
                raise OverflowError
            try:
                return Fraction(literal)
            except ValueError:
                return Fraction(str(node.value))
        case ast.Name(id=name):
            return _named(name, key, text, names, under)
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=inner):
            value = _value(inner, key, text, names, under)
            return -value if isinstance(sign, ast.USub) else value
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            power = _value(right, key, text, names, under)
            if power.denominator != 1 or abs(power) > LARGEST_POWER:
                raise InputError([f'`{key}` must have whole powers up to {LARGEST_POWER}, but is "{text}".'])
            base = _value(left, key, text, names, under)
            _small(base, abs(int(power)))
            return base ** int(power)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in BINARY:
            return _small(BINARY[type(op)](*(_value(part, key, text, names, under) for part in (left, right))))
    raise InputError([_wrong(key, text)])


def _small(value: Fraction, power: int = 1) -> Fraction:
    """The number. Raises OverflowError where its power has more digits than can matter."""
    if max(value.numerator.bit_length(), value.denominator.bit_length()) * power > MOST_BITS:
        raise OverflowError
    return value


def _named(name: str, key: str, text: str, names: dict[str, Any], under: tuple[str, ...]) -> Fraction:
    """What a name in an expression is worth."""
    if name == "pi":
        return PI
    if name not in names:
        if name == text.strip():
            raise InputError([f"`{key}` must be a number, but is {text!r}.{suggestion(name, names)}"])
        known = f", pi and {', '.join(n for n in names if n not in under)}" if names else " and pi"
        raise InputError(
            [
                f'`{key}` must be a number, or arithmetic of numbers{known}, but "{text}" has {name!r}.'
                f"{suggestion(name, names)}"
            ]
        )
    if name in under:
        raise InputError([f'`parameters.{name}` must not depend on itself, but does, by "{text}".'])
    value = names[name]
    if isinstance(value, tuple):  # a text, and what it measures
        value = names[name] = _exact(value[0], f"parameters.{name}", value[1], names, (*under, name))
    return value if isinstance(value, Fraction) else Fraction(str(value))


# --- units ------------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def _registry() -> Any:
    """pint's units, with exact fractions."""
    import pint

    registry: Any = pint.UnitRegistry(non_int_type=Fraction)
    registry.define("@alias turn = rev")
    return registry


def _must(unit: Unit) -> str:
    return "have no unit" if unit.symbol == "1" else f"be in {unit.symbol} or what can be converted to it"


def _converted(value: Fraction, given: str, key: str, text: str, unit: Unit) -> Fraction:
    """The number in SI units."""
    import pint

    words = given
    wanted = re.sub(r"([A-Za-z])(-?\d+)", r"\1**(\2)", unit.symbol).replace(" ", "*") if unit.symbol != "1" else ""
    if unit == RADIAN_PER_SECOND and HERTZ.search(given):
        raise InputError(
            [f'`{key}` must be in rad/s, deg/s or rpm, but "{text}" could be turns or radians per second.']
        )
    given = POWER.sub(lambda power: f"**({power[2].strip('+')}{power[3]})", given.translate(SUPERSCRIPTS))
    if UNIT.sub("", given):  # numbers and other operations: pint would work them out, however large
        raise InputError([f'`{key}` must {_must(unit)}, but "{words}" is no unit.'])
    registry = _registry()
    try:
        measured = registry.Quantity(value, given)
        number = Fraction(measured.to(wanted or "dimensionless").magnitude)
        parts, asked = (dict(registry.Quantity(1, u).to_root_units().unit_items()) for u in (given, wanted))
    except pint.DimensionalityError:
        raise InputError([f'`{key}` must {_must(unit)}, but is "{text}".']) from None
    except pint.UndefinedUnitError:
        raise InputError([f'`{key}` must {_must(unit)}, but "{words}" is no unit.']) from None
    except (pint.PintError, ValueError, TypeError, AttributeError, SyntaxError, AssertionError, RecursionError):
        raise InputError([_wrong(key, text)]) from None
    # pint takes angles and their powers for pure numbers; who writes s-1 for rad s-1 is understood
    turned = parts.get("radian", 0)
    if "count" in parts or (turned != asked.get("radian", 0) and (turned or not parts)):
        raise InputError([f'`{key}` must {_must(unit)}, but is "{text}".'])
    return number


# --- tables -----------------------------------------------------------------------------------------------------------


def worked_out(tables: Mapping[str, Any], units: Mapping[str, Mapping[str, Unit]]) -> dict[str, Any]:
    """The tables with numbers in place of the texts that stand for numbers.

    Parameters
    ----------
    tables
        Of a scenario, or any others.
    units
        What each number measures, by table and key; other keys stay as they are. The numbers of `parameters` may be
        named in every table.

    Returns
    -------
    dict
        Raises InputError with the fault of every text that stands for none.
    """
    given, faults = tables.get("parameters"), []
    of_body = units.get("parameters", {})
    names = {
        name: (value, of_body[name]) if isinstance(value, str) else value
        for name, value in (given.items() if isinstance(given, Mapping) else ())
        if name in of_body and (isinstance(value, str) or _is_number(value))
    }
    result = dict(tables)
    for table, its in units.items():
        values = tables.get(table)
        if not isinstance(values, Mapping) or not any(isinstance(values.get(name), str) for name in its):
            continue
        result[table] = dict(values)
        for name, unit in its.items():
            if isinstance(values.get(name), str):
                own = name if table == "parameters" else ""
                try:
                    result[table][name] = number_of(values[name], f"{table}.{name}", unit, names, own)
                except InputError as error:
                    faults += error.sentences
    if faults:
        raise InputError(faults)
    return result


def _is_number(value: Any) -> bool:
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) <= sys.float_info.max
    return isinstance(value, float) and math.isfinite(value)
