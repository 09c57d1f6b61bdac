"""A progress bar: how much is done, and the time that is left.

Calls that take long pass `update(done, of)` of a bar down as their progress callback.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from .arguments import instance


Report = Callable[[int, int], None]
"""A progress callback: the number of things that are done, and of all."""

# Time before the first drawing [s].
FIRST_AFTER = 0.4
# Time between two drawings [s].
AGAIN_AFTER = 0.1


class Bar:
    """Follow work that can be counted or measured. A context; `update` is a progress callback.

    It is drawn on stderr if that is a terminal, and as a line of text in a notebook. Nothing is
    drawn elsewhere, nor where the environment variable TIPPETOP_QUIET is set.

    Parameters
    ----------
    things
        The counted thing, or the unit of the measured one.
    count
        A format of how far it has come, with `done`, `of` and `things`.
    """

    def __init__(self, things: str, count: str = "{done}/{of} {things}"):
        """Decide whether a bar is shown: in a notebook or at a terminal, unless TIPPETOP_QUIET."""
        self.things = things
        self.count = count
        self.bar: Any = None  # of rich, or the display of a notebook; None before the first drawing
        self.notebook = _notebook()
        seen = self.notebook is not None or sys.stderr.isatty()
        self.visible = seen and not os.environ.get("TIPPETOP_QUIET")
        self.due = time.monotonic() + FIRST_AFTER

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None and self.notebook is not None:
            self._show("")
        elif self.bar is not None:
            self.bar.stop()

    def update(self, done: float, of: float) -> None:
        """Show how much is done, `done` of `of`; it draws a few times per second at most."""
        if not self.visible or time.monotonic() < self.due:
            return
        self.due = time.monotonic() + AGAIN_AFTER
        count = self.count.format(done=done, of=of, things=self.things)
        if self.notebook is not None:
            self._show(f"{count} ({done / of:.0%})")
            return
        if self.bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            self.bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TimeRemainingColumn(),
                console=Console(stderr=True),
                transient=True,
            )
            self.bar.start()
            self.task = self.bar.add_task("", total=of, completed=done)
        self.bar.update(self.task, completed=done, total=of, description=count)

    def _show(self, text: str) -> None:
        """Show a line of text in the notebook, instead of the one before."""
        line = {"text/plain": text}
        if self.bar is None:
            self.bar = self.notebook(line, raw=True, display_id=True)
        else:
            self.bar.update(line, raw=True)


def _notebook() -> Any:
    """Return the function that displays in a notebook; None elsewhere."""
    ipython = sys.modules.get("IPython")
    if ipython is None or not hasattr(ipython.get_ipython(), "kernel"):
        return None
    return ipython.display.display


@contextlib.contextmanager
def reporting(progress: Report | bool, things: str) -> Iterator[Report]:
    """Provide a progress callback: the given one, that of a bar (True), or none (False).

    `things` are counted in the bar. Raises InputError for any other `progress`.
    """
    instance("progress", progress, bool | Callable, "a function or a bool")
    if progress is True:
        with Bar(things) as bar:
            yield bar.update
    else:
        yield progress or (lambda *_: None)
