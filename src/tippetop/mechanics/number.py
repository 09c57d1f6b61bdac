"""Numbers of the user, declared once with unit, meaning and interval; and records of them.

`Number`s are fields of a `Record`, such as a body or a law, and initial data of a system; values of
the user go in, checked floats in SI units come out.
"""

import contextlib
import inspect
import operator
from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from numbers import Rational, Real
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, cast, dataclass_transform

import numpy as np

from ..errors import InputError, refuse_unknown, sentence
from .caching import cached_property
from .described import Described
from .quantity import worked_out
from .readonly import ReadOnly
from .units import Unit


@dataclass(frozen=True)
class Number(metaclass=Described):
    """A number that users pass: its unit, its meaning, and its open or closed interval.

    Parameters
    ----------
    unit : Unit
        The SI unit; `tippetop.mechanics.units` contains those of the package.
    long_name : str
        The meaning, in words.
    above, least : float, optional
        It must be greater than `above`, at least `least`.
    below, most : float, optional
        It must be less than `below`, at most `most`.
    nonzero : bool
        Whether it must differ from 0.
    default : float or str, optional
        The value if the number is omitted, or arithmetic of the other numbers; without a default it
        is required.
    where_zero : tuple of str
        Numbers that must be 0 for the default to apply.
    symbol : str
        Symbol in figures, in TeX.
    optional : bool
        Whether the number may be omitted; the record is then of another class.
    kw_only : bool
        Whether type checkers accept it by name only.

    Raises
    ------
    InputError
        If the unit is not a Unit, or the default lies outside the interval.
    """

    unit: Unit
    long_name: str
    above: float | None = None  # must be greater than
    least: float | None = None  # must be at least
    below: float | None = None  # must be less than
    most: float | None = None  # must be at most
    default: float | str | None = None  # where it is left out; None: it must be given
    where_zero: tuple[str, ...] = ()
    nonzero: bool = False  # must not be 0
    symbol: str = ""
    optional: bool = False
    kw_only: bool = False

    if TYPE_CHECKING:  # a field of a Record is given as a number or a text, and read as a float

        def __get__(self, record: Any, owner: Any) -> float: ...

        def __set__(self, record: Any, value: float | str | None) -> None: ...

    def __post_init__(self) -> None:
        """Check that the unit is a Unit, and that the default lies in the interval."""
        of = f"of the number `{self.long_name}`"
        unit = cast(Any, self.unit)
        if not isinstance(unit, Unit):
            raise InputError([f"`unit` {of} must be a Unit, but is {unit!r:.60}."])
        if not isinstance(self.default, str | None) and self.broken(self.default):
            raise InputError([f"`default` {of} {self.must()}, but is {self.default:g}."])

    @cached_property
    def _bounds(self) -> list[tuple[str, float, Callable]]:
        """Return the bounds that are set.

        Each is the requirement in words, the limit, and the comparison that violates it.
        """
        bounds = (
            ("other than", 0.0 if self.nonzero else None, operator.eq),
            ("greater than", self.above, operator.le),
            ("at least", self.least, operator.lt),
            ("less than", self.below, operator.ge),
            ("at most", self.most, operator.gt),
        )
        return [
            (words, float(limit), breaks) for words, limit, breaks in bounds if limit is not None
        ]

    def broken(self, values: Any) -> Any:
        """Return a mask of the values that lie outside the interval or are not finite.

        Parameters
        ----------
        values
            A number or an array, in SI units.

        Returns
        -------
        bool or array of bool
            True where the value is not allowed.
        """
        broken = ~np.isfinite(values)
        for _, limit, breaks in self._bounds:
            broken = broken | breaks(values, limit)
        return broken

    def must(self, value: float | None = None) -> str:
        """Return the requirement, as in "must be finite, greater than 0".

        With a value, the first requirement that it violates.
        """
        if value is None:
            return f"must be finite{self._interval()}"
        broken = [
            f"{words} {type(value)(limit)}"  # a whole number has a whole limit
            for words, limit, breaks in self._bounds
            if breaks(value, limit)
        ]
        return (
            f"must be {broken[0]}" if broken and np.isfinite(value) else "must be a finite number"
        )

    def _interval(self) -> str:
        """Return the bounds in words, each after a comma."""
        return "".join(f", {words} {limit:g}" for words, limit, _ in self._bounds)

    def fault(self, key: str, value: float) -> str:
        """Return the message on a value that is not allowed, for the dotted name `key`."""
        return f"`{key}` {self.must()}, but is {value:.17g}."

    def read(self, key: str, value: Any) -> float:
        """Return the user's value of the number `key` as a float. Raises InputError."""
        value = _scalar(value)
        number = None
        if isinstance(value, Real | int) and value is not True and value is not False:
            with contextlib.suppress(OverflowError):
                number = float(value)
        if number is None:
            raise InputError([sentence(key, "must be a number", value)])
        if self.broken(number):
            raise InputError([sentence(key, self.must(number), value)])
        return number

    def described(self) -> str:
        """Return its type, meaning, unit and interval, for a docstring."""
        unit = "without unit" if self.unit.symbol == "1" else f"[{self.unit.symbol}]"
        kind = "float" if self.default is None and not self.optional else "float, optional"
        meaning = f"{self.long_name[:1].upper()}{self.long_name[1:]}"
        return f"{kind}\n    {meaning} {unit}{self._interval()}."


number = Number
"""Declares a number of a body or a law as a field of its class: `mu: Number = number(ONE, "friction
coefficient")`."""


def reuse(rule: Number, *, default: Any = None, **changes: Any) -> Any:
    """Return the Number of another record as a field.

    Type checkers read `default` and `kw_only`.
    """
    return replace(rule, **changes | ({} if default is None else {"default": default}))


def with_defaults(given: Mapping[str, Any], rules: Mapping[str, Number]) -> dict[str, Any]:
    """Return numbers by name, with the defaults of those that are omitted or None.

    If one without a default is omitted too, nothing is filled in: defaults may be arithmetic of the
    others, and the caller reports the missing one. The keys of `given` keep their order, because
    `Record.__new__` makes the record by position.
    """
    omitted = {key: rule.default for key, rule in rules.items() if given.get(key) is None}
    return {**given} if None in omitted.values() else {**given, **omitted}


def omission_faults(
    given: Mapping[str, Any], numbers: Mapping[str, float], rules: Mapping[str, Number]
) -> list[str]:
    """Return a sentence for each omitted number whose default does not apply to the others.

    `given` are the user's values, `numbers` the floats with defaults.
    """
    return [
        f"`parameters.{key}` must be given where {name} is not 0, but is missing: its default is "
        "that of a uniform body."
        for key, rule in rules.items()
        for name in rule.where_zero
        if given.get(key) is None and numbers[name]
    ]


@dataclass_transform(frozen_default=True, field_specifiers=(number, reuse))
class RecordType(Described):
    """A class of records: named tuples of the Numbers in its body, which `parameters` contains.

    An `abstract` class has no records: its Numbers are `parts`, optional keywords of the
    classes below it.
    """

    parameters: Mapping[str, Number]
    parts: Mapping[str, Number]

    def __new__(
        mcs, name: str, bases: tuple[type, ...], body: dict[str, Any], abstract: bool = False
    ) -> Any:
        """Make a class of records: fields, signature and docstring are those of its Numbers."""
        own = {key: value for key, value in body.items() if isinstance(value, Number)}
        parts = {key: rule for base in bases for key, rule in getattr(base, "parts", {}).items()}
        # a number that the class does not repeat is not inherited
        before = [key for base in bases for key in getattr(base, "parameters", ())]
        body = {"__slots__": (), **dict.fromkeys(before), **body}
        if abstract:
            body = {key: value for key, value in body.items() if key not in own}
            return super().__new__(mcs, name, bases, body | {"parts": own})
        record = namedtuple(name, own)  # type: ignore[misc]
        body |= {
            key: vars(record)[key]
            for key in (*own, "_fields", "_make", "_replace", "_asdict", "__match_args__")
        }
        taken = own | parts | own  # own numbers first, and by their own rules
        fields = [_field(key, rule, key in own) for key, rule in taken.items()]
        body |= {"parameters": ReadOnly(own), "__signature__": inspect.Signature(fields)}
        described = [f"{key} : {rule.described()}" for key, rule in taken.items()]
        sections = ["Parameters\n----------", *described] if described else []
        body["__doc__"] = "\n".join(
            [inspect.cleandoc(body.get("__doc__") or ""), "", *sections]
        ).rstrip()
        return super().__new__(mcs, name, bases, body)


def _field(name: str, rule: Number, own: bool) -> inspect.Parameter:
    """Return a field of a record (`own`), or one of its parts, as a parameter of its signature.

    A part, such as mu_r of a law, must be given by name.
    """
    parameter = inspect.Parameter
    kind = parameter.POSITIONAL_OR_KEYWORD if own else parameter.KEYWORD_ONLY
    default: Any = None
    if not rule.optional:
        default = parameter.empty if rule.default is None else rule.default
    return parameter(name, kind, default=default)


class Record(tuple, metaclass=RecordType, abstract=True):
    """Numbers for formulas, checked if all are plain: floats, or texts such as "20 g".

    Operands of formulas (arrays, expressions, wide numbers) pass unchecked. So do the arguments of
    `_make`, `_replace`.
    """

    table: ClassVar[str]
    """The table of a scenario that contains them."""
    face: ClassVar[RecordType]
    """The class that is called; its records may be of a class below it."""

    def __init_subclass__(cls) -> None:
        if "parameters" in vars(cls):
            cls.face = getattr(cls, "face", cls)

    if TYPE_CHECKING:
        # for type checkers: `RecordType` copies these from a named tuple of the Numbers
        _fields: ClassVar[tuple[str, ...]]

        def _asdict(self) -> dict[str, Any]: ...

        @classmethod
        def _make(cls, values: Any) -> Any: ...

        def _replace(self, **values: Any) -> Any: ...

    else:

        def __new__(cls, *values: Any, **named: Any) -> Any:
            """Return a record of `given`'s class, checked unless a number is an operand.

            Numbers that are omitted have their defaults.
            """
            refuse_unknown(cls.__name__, named, cls.__signature__.parameters)
            given = dict(zip(cls._fields, values, strict=False)) | named
            kind = cls.given([key for key, value in given.items() if value is not None])
            rules = kind.parameters
            operands = any(map(_is_operand, given.values()))
            # a default that is a text, such as "2/5*m*R^2", is computed of plain numbers only
            no_default = (type(None), str) if operands else type(None)
            needed = [key for key, rule in rules.items() if isinstance(rule.default, no_default)]
            missing = ", ".join(f"`{key}`" for key in needed if key not in given)
            if missing or len(given) < len(values) + len(named):
                found = f"lacks {missing}" if missing else "was given too many arguments"
                raise TypeError(f"{cls.__name__}({', '.join(cls._fields)}) {found}.")
            # as `_make` takes them, by position
            in_order = {key: given.get(key) for key in rules}
            numbers = with_defaults(in_order, rules) if operands else kind.checked(in_order)
            return kind._make(numbers.values())

    @classmethod
    def given(cls, names: Any) -> Any:
        """Return the class of the record of these numbers.

        Friction laws have several, see `FrictionLaw`.
        """
        return cls

    @staticmethod
    def faults(parameters: Mapping[str, float]) -> list[str]:
        """Return one sentence for each condition that the numbers violate together.

        There are none here; bodies have some.
        """
        return []

    @classmethod
    def checked(cls, values: Mapping[str, Any]) -> dict[str, float]:
        """Return the numbers by name as floats, in the order of `values`, which is that of fields.

        Callers make a record of them by position. Raises InputError with a sentence for each that
        is wrong.
        """
        rules = cls.parameters
        faults = []
        read = {}
        units = {cls.table: {key: rule.unit for key, rule in rules.items()}}
        whole = with_defaults(values, rules)
        for key, value in worked_out({cls.table: whole}, units)[cls.table].items():
            try:
                read[key] = rules[key].read(f"{cls.table}.{key}", value)
            except InputError as error:
                faults += error.sentences
        if faults := faults or omission_faults(values, read, rules) or cls.faults(read):
            raise InputError(faults)
        return read

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and tuple.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash((type(self), *self))

    def __reduce__(self) -> Any:
        return type(self)._make, (tuple(self),)

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={value!r}" for key, value in self._asdict().items())
        return f"{type(self).face.__name__}({values})"


def _is_operand(value: Any) -> bool:
    """Return whether only a formula can take a value."""
    plain = isinstance(_scalar(value), float | Rational | Decimal)
    return not plain and hasattr(value, "__sub__") and hasattr(value, "__mul__")


def _scalar(value: Any) -> Any:
    """Return a number of NumPy, or an array of dimension 0, as a number of Python.

    Any other value is returned unchanged.
    """
    return value.item() if getattr(value, "ndim", None) == 0 else value


class Alternative(NamedTuple):
    """An initial datum that replaces `others`: it must be given without any of them."""

    name: str
    others: tuple[str, ...]
    flag: bool = False  # true or false, not a number

    def fault(self, verb: str) -> str:
        """Return the message on initial data that exclude each other.

        `verb` is that of the others: "is given", or "varies".
        """
        others = " or ".join(f"`initial.{other}`" for other in self.others)
        return f"`initial.{self.name}` must be given alone, but {others} {verb} too."
