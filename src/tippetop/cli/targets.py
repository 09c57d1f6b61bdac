"""What a command will write: refused before the work rather than after it."""

from __future__ import annotations

from pathlib import Path

from ..errors import StoreError, refuse_without
from ..figures import catalogue
from ..store import files


def check_picture(path: Path | None, overwrite: bool) -> None:
    """Refuse a picture before the run rather than after it."""
    if path is None:
        return
    refuse_without("matplotlib")
    catalogue.check_format(path)
    if not path.parent.is_dir():
        raise StoreError(f"`{path}` cannot be written: `{path.parent}` is not a folder.")
    files.refuse_inside(path)
    files.refuse_existing(path, overwrite)
