"""Cached properties that take no lock."""

import functools
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from functools import cached_property as cached_property
else:

    class cached_property(functools.cached_property):
        """As in Python 3.12: a fork may inherit the lock of 3.11 from a thread that it lacks."""

        def __get__(self, instance: Any, owner: Any = None) -> Any:
            if instance is None:
                return self
            value = instance.__dict__[self.attrname] = self.func(instance)
            return value
