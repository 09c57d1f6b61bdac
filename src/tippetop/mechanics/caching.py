"""Cached properties that take no lock."""

import functools
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from functools import cached_property as cached_property
else:

    class cached_property(functools.cached_property):
        """Compute without a lock, as Python 3.12 does: a fork may inherit a locked lock of 3.11."""

        def __get__(self, instance: Any, owner: Any = None) -> Any:
            if instance is None:
                return self
            value = instance.__dict__[self.attrname] = self.func(instance)
            return value
