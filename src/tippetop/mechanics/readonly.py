"""Immutable mappings: the content of a record is checked once.

Fields of `System` and `Phase` are such mappings.
"""

from collections.abc import Mapping
from typing import Any, NoReturn


class ReadOnly(dict):
    """A dict that refuses to be changed; `|` and `copy` give a plain dict."""

    def _refused(self, *_: Any, **__: Any) -> NoReturn:
        """Raise TypeError; every method that changes a dict is this one."""
        raise TypeError(
            "a record cannot be changed: make a changed copy, as dataclasses.replace does."
        )

    __setitem__ = __delitem__ = __ior__ = _refused
    clear = pop = popitem = setdefault = update = _refused

    def __reduce__(self) -> tuple[Any, ...]:
        return ReadOnly, (dict(self),)


def freeze(record: Any, *names: str) -> None:
    """Make mappings among the fields of a frozen record read-only.

    Other values stay as they are; a later check names them.
    """
    for name in names:
        value = getattr(record, name)
        if isinstance(value, Mapping) and not isinstance(value, ReadOnly):
            object.__setattr__(record, name, ReadOnly(value))
