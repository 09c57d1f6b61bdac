"""What a person reads: the summary of a run, and the progress bar in a terminal."""

from __future__ import annotations

import os
import sys
import time
from typing import Any

from rich.console import Console
from rich.table import Table

from tippetop.report import lines


def console() -> Console:
    """Standard output; no colour when it is not a terminal."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else 160)


class Progress:
    """A bar on stderr while a run lasts longer than half a second; nothing when stderr is not a terminal."""

    def __init__(self, until: float):
        self.until, self.task = until, None
        self.bar: Any = None
        self.shown = sys.stderr.isatty() and not os.environ.get("TIPPETOP_QUIET")
        self.began = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, t: float, report: dict[str, Any]) -> None:
        """Called after every slice with the time reached [s]."""
        if not self.shown or time.monotonic() - self.began < 0.5:
            return
        if self.bar is None:
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("t = {task.completed:.4g} s"), BarColumn(), TextColumn("{task.fields[note]}"))
            self.bar = Bar(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task("", total=self.until, note="")
        drift = max(report["drift"].values(), default=0.0)
        note = f"{report['steps']} steps, {report['events']} events, drift {drift:.0e}"
        self.bar.update(self.task, completed=t, note=note)


def summary(headline: str, info: dict[str, Any], seconds: dict[str, float], places: dict[str, Any]) -> None:
    """Prints a run in a few lines."""
    out = console()
    out.print(headline, style="bold")
    table = Table.grid(padding=(0, 2))
    for name, text in lines(info, seconds):
        table.add_row(name, text)
    for name, place in places.items():
        if place is not None:
            table.add_row(name, str(place))
    out.print(table)
