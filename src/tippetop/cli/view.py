"""`tippetop view`: a store becomes one HTML file in which its body moves."""

from __future__ import annotations

from pathlib import Path

from ..awaiting import awaited
from ..errors import InputError
from .values import Place, Seconds


def view(
    store: Place | None = None,
    *,
    playground: bool = False,
    out: Place | None = None,
    from_: Seconds | None = None,
    until: Seconds | None = None,
    overwrite: bool = False,
) -> int:
    """Write one HTML file that shows a run in motion, or the map of a sweep, without a network.

    Parameters
    ----------
    store
        A store that `run` or `replay` wrote, finished, with rows and their orientation; or one of
        `sweep`.
    playground
        Instead of a store: a tippe top whose numbers are changed in the page, which integrates it.
    out
        The file to write; by default the name of the store, or playground, with the ending .html.
    from_
        Show a run from this time on [s].
    until
        Show it up to this time [s].
    overwrite
        Replace an existing file.
    """
    from ..store import files

    if (store is None) != playground:
        raise InputError("nothing to show: pass a store or `--playground`.")
    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out must end with .html, but is `{out}`.")
    if playground and (from_, until) != (None, None):
        raise InputError("`--from` and `--until` cannot be used with `--playground`.")
    place = out or Path(f"{store.resolve().stem if store else 'playground'}.html")
    files.refuse_existing(place, overwrite)
    text = awaited(lambda: _text(store, from_, until), "the page is being made")
    files.write_text(place, text, overwrite=overwrite)
    print(f"{place}: {len(text.encode()) / 1e6:.1f} MB, for a browser with WebGL2")
    return 0


def _text(store: Path | None, start: float | None, until: float | None) -> str:
    """Return the HTML of the page of a store, or of the playground if `store` is None.

    `start` and `until` [s] are the options `--from` and `--until`; `view` has refused both for the
    playground. `page_of_store` refuses a store that is neither a run nor a sweep.
    """
    if store is None:
        from ..views.playground import playground

        return playground()
    from ..store import root
    from ..views.run_page import page_of_store

    attrs = root.attributes(store)
    if attrs.get("content") != "sweep":
        return page_of_store(store, attrs, start, until)
    from ..views.sweep_page import page_of_sweep

    if (start, until) != (None, None):
        raise InputError(f"`--from` and `--until` require a run, but `{store}` is a sweep.")
    return page_of_sweep(store)
