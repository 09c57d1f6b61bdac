"""`--overwrite`: a store that exists gives way, unless somebody writes it or it is not ours."""

from __future__ import annotations

import contextlib
import os
import shutil
import uuid
from pathlib import Path


def remove_store(path: Path) -> None:
    """Removes a store, if there is one. Raises StoreError: no store of tippetop, being written, not writable."""
    from ..errors import StoreError
    from ..store import files, root

    if not path.exists() and not path.is_symlink():
        return
    if path.is_symlink():
        raise StoreError(f"`{path}` is a link: it is not overwritten; name the store itself.")
    root.attributes(path)
    try:
        lock = files.locked(path)  # raises StoreError, naming the writer
        try:
            old = path.with_name(f".{path.name}.old-{uuid.uuid4().hex[:8]}")
            os.rename(path, old)  # gone at once: what is killed from here on leaves no half store under its name
            shutil.rmtree(old)
        finally:
            with contextlib.suppress(OSError):
                os.close(lock)
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        raise StoreError(f"`{path}` cannot be overwritten: {error.strerror or error}.") from None
