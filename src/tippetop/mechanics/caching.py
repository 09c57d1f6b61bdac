"""Cached properties that take no lock."""

import functools
from typing import Any


class cached_property(functools.cached_property):
    """As in Python 3.12 and later; the lock of 3.11 stays taken in a process forked while a thread computes."""

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        if instance is None:
            return self
        value = instance.__dict__[self.attrname] = self.func(instance)
        return value
