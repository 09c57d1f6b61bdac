"""`--overwrite`: an existing store is removed, unless it is being written or tippetop did not write
it.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path


def remove_store(path: Path) -> None:
    """Removes a store, if there is one.

    Raises StoreError: no store of tippetop, being written, not writable.
    """
    from ..errors import StoreError
    from ..store import files, root

    if path.is_symlink():
        raise StoreError(f"`{path}` is a link: it is not overwritten; name the store itself.")
    if not path.exists():
        return
    root.refuse_foreign(path)  # a damaged one may be overwritten
    with files.writing(path), files.lock_of(path):  # raises StoreError, naming the writer
        old = files.scratch_name(path)
        os.rename(
            path, old
        )  # gone at once: what is killed from here on leaves no half store under its name
        shutil.rmtree(old, ignore_errors=True)
