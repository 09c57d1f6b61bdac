"""Arguments of the library, checked one by one: a fault is one sentence that names the argument.

Each function takes the `name` of an argument, for messages, and what the caller gave for it; it
returns the checked value or raises InputError.
"""

import contextlib
import functools
import inspect
import math
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from .errors import InputError, StoreError, refuse_unknown, suggestion


if TYPE_CHECKING:
    import numpy as np

    from .mechanics.units import Unit


F = TypeVar("F", bound=Callable)
TOO_DEEP = "tables or lists are nested too deeply."
PlainData = dict[str, Any]
"""A table of what TOML and JSON contain: of a scenario, the attributes of a store, a report."""


def finite(name: str, value: Any) -> float:
    """Return an argument as a float. Raises InputError if it is not a finite number."""
    try:
        number = math.nan if isinstance(value, str | bytes | bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"`{name}` must be a finite number, but is {value!r:.60}.")
    return number


def numbers(name: str, values: Any) -> "np.ndarray":
    """Return an argument as an array of floats of any shape, NaN included.

    Raises InputError if it is not numeric.
    """
    import numpy as np

    try:
        array = np.asarray(values)
        if array.dtype.kind not in "fiu":
            raise TypeError
        return array.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"`{name}` must be a number or an array of numbers, but is {values!r:.60}."
        ) from None


def positive_integer(name: str, value: Any) -> int:
    """Return an argument, a whole number of any type, as an int. Raises InputError below 1."""
    try:
        number = finite(name, value)
    except InputError:
        number = 0.0
    if number < 1 or not number.is_integer():
        raise InputError(f"`{name}` must be a whole number, at least 1, but is {value!r:.60}.")
    return int(number)


def path_of(name: str, value: Any) -> Path:
    """Return an argument as a path. Raises InputError if it is not path-like."""
    if not isinstance(value, str | os.PathLike) or not str(value):
        raise InputError(f"`{name}` must be a path, but is {value!r:.60}.")
    return Path(value)


def instance(name: str, value: Any, kind: Any, words: str) -> None:
    """Raise InputError if an argument is not of this kind; `words` describe the kind."""
    if not isinstance(value, kind):
        raise InputError(f"`{name}` must be {words}, but is {value!r:.60}.")


def choice(name: str, value: Any, known: Collection[str]) -> None:
    """Raise InputError if an argument is not one of these words."""
    if not isinstance(value, str) or value not in known:
        raise InputError(not_among(name, value, known))


def not_among(name: str, value: Any, known: Collection[str]) -> str:
    """Return the sentence for a value that is not one of these words; None if it is missing."""
    near = suggestion(value, known) if isinstance(value, str) else ""
    given = "missing" if value is None else f"{value!r:.60}"
    return f"`{name}` must be one of {', '.join(known)}, but is {given}.{near}"


def names_of(argument: str, given: Any) -> tuple[str, ...]:
    """Return the names of numbers, from a list or a text with commas. Raises InputError."""
    names = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
    texts = isinstance(names, list | tuple) and all(isinstance(name, str) for name in names)
    if not (texts and names and all(names)):
        raise InputError(
            f"`{argument}` must be names such as friction.mu, parameters.I1, but is {given!r:.60}."
        )
    return tuple(names)


def flag(name: str, value: Any) -> None:
    """Raise InputError if an argument is neither True nor False: "no" would count as yes."""
    instance(name, value, bool, "True or False")


def measured(name: str, value: Any, unit: "Unit") -> float:
    """Return an argument, a finite number or a text such as "1480 rpm", in SI units.

    Raises InputError.
    """
    from .mechanics.quantity import number_of

    return number_of(value, name, unit) if isinstance(value, str) else finite(name, value)


def seconds(name: str, value: Any) -> float | None:
    """Return a time [s] that may be left out, as `measured` does. Raises InputError."""
    from .mechanics.units import SECOND

    return None if value is None else measured(name, value, SECOND)


def measured_values(name: str, values: Any, unit: "Unit") -> Any:
    """Return a number, a text or an array of them as numbers in SI units. Raises InputError."""
    import numpy as np

    array = np.asarray(values, dtype=object)  # takes ragged lists too
    if array.ndim == 0:
        return measured(name, values, unit)
    if any(isinstance(value, str) for value in array):
        values = [measured(name, value, unit) for value in array]
    return numbers(name, values)


def within(name: str, values: Any, low: float, high: float, words: str) -> None:
    """Raise InputError if a number, or one of an array, is outside an interval; NaN is not."""
    import numpy as np

    array = np.asarray(values)
    if array.dtype.kind in "fiu" and (beyond := array[(array < low) | (array > high)]).size:
        raise InputError(f"`{name}` must lie in {words}, but is {beyond[0]:g}.")


def plain(value: Any) -> Any:
    """Return a tree of mappings, lists and arrays as dicts and lists with numbers of Python.

    Other values are returned unchanged. Raises InputError for a tree that is too deep.
    """
    import numpy as np

    if hasattr(value, "__array__") and not isinstance(value, str | Mapping):
        return np.asarray(value).tolist()
    try:
        if isinstance(value, Mapping):
            return {str(key): plain(item) for key, item in value.items()}
        return [plain(item) for item in value] if isinstance(value, list | tuple) else value
    except RecursionError:
        raise InputError(TOO_DEEP) from None


def dotted_keys(names: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return names of numbers as dotted keys: `mu` as `friction.mu`, an unknown one as it is.

    Raises InputError for a name that several tables have, and for two names of one number.
    """
    given: dict[str, list[str]] = {}
    sentences = []
    known = list(known)
    for name in names:
        fits = [key for key in known if key == name or key.partition(".")[2] == name]
        if len(fits) > 1:
            sentences.append(
                f"`{name}` must be one of {' or '.join(fits)}: it occurs in several tables."
            )
        key = fits[0] if fits else str(name)
        given.setdefault(key, []).append(f"`{name}`")
    sentences += [
        f"`{key}` must be given once, but is given as {' and '.join(own)}."
        for key, own in given.items()
        if len(own) > 1
    ]
    if sentences:
        raise InputError(sentences)
    return list(given)


IN_TABLES = " Numbers are given by table, such as start=dict(omega3=155.0), friction=dict(mu=0.3)."


def takes(source: Callable, options: Callable[[], str] = str) -> Callable[[F], F]:
    """Replace the **keywords of a function by the keyword arguments of another: a decorator.

    An unknown keyword raises a TypeError that names the nearest one.

    Parameters
    ----------
    source
        The other function.
    options
        Makes the text that replaces `{options}` in the docstring; by default, `str`, an empty one.
        `{names}` in the docstring become the names of the keywords that are added.
    """

    def decorated(function: F) -> F:
        """Return the function with the other one's keywords in its signature and docstring.

        Only keyword-only arguments that it does not have itself are added.
        """
        own = inspect.signature(function)
        kept = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
        others = inspect.signature(source).parameters.values()
        added = [p for p in others if p.kind is p.KEYWORD_ONLY and p.name not in own.parameters]
        signature = own.replace(parameters=[*kept, *added])

        @functools.wraps(function)
        def called(*arguments: Any, **named: Any) -> Any:
            """Call the function; a keyword that it does not have raises a TypeError."""
            hint = IN_TABLES if "start" in signature.parameters else ""
            refuse_unknown(function.__name__, named, signature.parameters, hint)
            return function(*arguments, **named)

        called.__signature__ = signature  # type: ignore[attr-defined]
        # `{options}` is replaced by unindented lines; Python 3.13 removes the indent itself
        text = inspect.cleandoc(function.__doc__ or "")
        text = text.replace("{names}", ", ".join(p.name for p in added))
        called.__doc__ = text.replace("{options}", options())
        return called  # type: ignore[return-value]

    return decorated


OF_COMMANDS = (
    (r" \(--set [^)]*\)|--set ", ""),
    (r"run\.until =", "until ="),
    (r"(?<!unknown key )(?<!mean )`run\.(\w+)", r"`\1"),  # a key is that of a table
    (r"--accept-other-version", "accept_other_version=True"),
    (r"--overwrite", "overwrite=True"),
    (r"--group", "`group`"),
)
"""Patterns of words for the command line, and those for callers, which replace them in order."""


@contextlib.contextmanager
def in_python() -> Iterator[None]:
    """Rephrase errors for callers: options are arguments, --overwrite is overwrite=True."""
    try:
        yield
    except (InputError, StoreError) as error:
        words = str(error)
        for pattern, word in OF_COMMANDS:
            words = re.sub(pattern, word, words)
        error.args = (words,)
        raise
