"""The numbers of one table, checked by themselves: what a body or a friction law made in Python goes through."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError

from ..arguments import finite
from ..errors import InputError
from ..mechanics.system import Parameter
from ..mechanics.units import Unit
from .quantities import number_of, worked_out
from .schema import table_model
from .sentences import error_sentence


def plain(value: Any) -> Any:
    """The value as TOML would give it: numpy's numbers and arrays, and tuples, become Python's numbers and lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if hasattr(value, "__array__") and not isinstance(value, str | Mapping):  # of pandas, of xarray
        return np.asarray(value).tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def measured(name: str, value: Any, unit: Unit) -> float:
    """An argument as a number in SI units; a text such as "1480 rpm" stands for one. Raises InputError."""
    return number_of(value, name, unit) if isinstance(value, str) else finite(name, value)


def measured_values(name: str, values: Any, unit: Unit) -> Any:
    """An argument that may be a number, a text, or an array of them: texts as numbers in SI units, and a single number
    finite; an array of numbers as it is. Raises InputError."""
    given = values.tolist() if isinstance(values, np.ndarray) and values.dtype.kind in "UO" else values
    if isinstance(given, list | tuple) and any(isinstance(value, str) for value in given):
        return [measured(name, value, unit) for value in given]
    return measured(name, given, unit) if isinstance(given, str) or np.ndim(given) == 0 else given


def within(name: str, values: Any, low: float, high: float, words: str) -> None:
    """Raises InputError if a number, or one of an array, lies outside an interval; NaN does not."""
    array = np.asarray(values)
    if array.dtype.kind in "fiu" and (beyond := array[(array < low) | (array > high)]).size:
        raise InputError([f"`{name}` must lie in {words}, but is {beyond[0]:g}."])


def checked(table: str, parameters: Mapping[str, Parameter], values: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of a table as floats. Raises InputError, which names every one that is wrong, as for TOML."""
    units = {table: {name: parameter.unit for name, parameter in parameters.items()}}
    values = worked_out({table: plain(values)}, units)[table]
    try:
        return _model(table, tuple(parameters.items())).model_validate(values).model_dump()
    except ValidationError as error:
        names = list(parameters)
        raise InputError(
            [
                error_sentence(e, f"{table}.{'.'.join(map(str, e['loc']))}", names)
                for e in error.errors(include_url=False)
            ]
        ) from None


@lru_cache
def _model(table: str, parameters: tuple[tuple[str, Parameter], ...]) -> type[BaseModel]:
    return table_model(table.title(), dict(parameters), required=True)
