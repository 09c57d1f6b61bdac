"""The numbers of one table, checked by themselves: what a body or a friction law made in Python goes through."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from pydantic import BaseModel, ValidationError

from ..arguments import plain
from ..errors import InputError
from ..mechanics.quantity import worked_out
from ..mechanics.system import Parameter
from .schema import table_model
from .sentences import error_sentence


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
