"""What a command will write: refused before the work rather than after it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from ..errors import InputError, StoreError, refuse_without
from ..figures import catalogue
from ..store import files, root
from ..store.ledger import Ledger


def check_picture(path: Path | None, option: str, overwrite: bool = False) -> None:
    """Refuse a picture before the run rather than after it; `option` gives its file."""
    if path is None:
        return
    refuse_without("matplotlib")
    if path.suffix.lower() not in catalogue.ENDINGS:
        raise InputError(f"{option} must end with .png, .svg or .pdf, but is `{path}`.")
    if not path.parent.is_dir():
        raise StoreError(f"`{path}` cannot be written: `{path.parent}` is not a folder.")
    files.refuse_inside(path)
    files.refuse_existing(path, overwrite)


def finished(store: Path, overwrite: bool) -> bool:
    """Return whether a store exists and is finished; with `overwrite` remove it.

    Raises StoreError if it is not a store of tippetop, is being written, or is not writable.
    """
    if not overwrite:
        return store.is_dir() and root.attributes(store, whole=False).get("status") == "finished"
    if store.is_symlink():
        raise StoreError(f"`{store}` is a link: it is not overwritten; name the store itself.")
    if store.exists():
        root.refuse_foreign(store)  # a damaged one may be overwritten
        with files.writing(store), Ledger.locked(store):  # raises StoreError, naming the writer
            old = files.scratch_name(store)
            os.rename(store, old)  # immediately: a kill leaves no half store under its name
            shutil.rmtree(old, ignore_errors=True)
    return False
