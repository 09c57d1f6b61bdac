"""A finished store for zarr: every chunk is there, so that one that is missing is damage and no chunk of NaN."""

import re
from typing import Any

from zarr.storage import LocalStore

from ..errors import StoreError


CHUNK = re.compile(r"(?:^|/)c(?:[/.]\d+)*$")


class SealedStore(LocalStore):
    """As zarr's, to be read. Raises StoreError where a chunk is gone since its seal was compared."""

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """The content of a file, None where there is none that is no chunk."""
        content = await super().get(key, prototype, byte_range)
        if content is None and CHUNK.search(key):
            raise StoreError(f"`{self.root}` must be whole, but `{key}` was removed after it was opened.")
        return content
