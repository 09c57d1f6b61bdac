"""`tippetop view`: a store becomes one HTML file in which its body moves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def view(
    store: Path,
    *,
    out: Path | None = None,
    from_: Annotated[float | None, Parameter(name="--from")] = None,
    until: float | None = None,
    overwrite: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Write one HTML file that shows a run in motion, in any browser, without a network.

    Parameters
    ----------
    store
        A store that `run` or `replay` wrote, finished, with rows and their orientation.
    out
        The file to write; by default the name of the store with the ending .html, in the current folder.
    from_
        Show the run from this time on [s].
    until
        Show it up to this time [s].
    overwrite
        Replace an existing file.
    """
    from ..awaiting import awaited
    from ..store import root
    from ..views import pages
    from ..views.run import page_of_store

    place = out if out is not None else Path(f"{store.resolve().stem}.html")
    pages.check(place, overwrite=overwrite)
    attrs = root.attributes(store)
    root.refuse_other_rows(store, attrs)
    text = awaited(lambda: page_of_store(store, attrs, from_, until), "the page is being made")
    pages.write(text, place, overwrite=overwrite)
    print(f"{place}: {len(text.encode()) / 1e6:.1f} MB, for any browser")
    return 0


COMMANDS = [view]
