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
    return Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 160)


class Progress:
    """A bar on stderr while a run lasts longer than half a second; nothing when stderr is not a terminal."""

    def __init__(self, until: float):
        self.until, self.task = until, None
        self.bar: Any = None
        self.shown = sys.stderr.isatty() and not os.environ.get("TIPPETOP_QUIET")
        self.began = self.drawn = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, course: Any) -> None:
        """Called after every slice with the run on its way."""
        if not self.shown or time.monotonic() - max(self.began + 0.4, self.drawn) < 0.1:
            return
        self.drawn = time.monotonic()
        if self.bar is None:
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("t = {task.completed:.4g} s"), BarColumn(), TextColumn("{task.fields[note]}"))
            self.bar = Bar(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task("", total=self.until, note="")
        report = course.report()
        rate = course.t_end / (self.drawn - self.began)
        drift = max(report["drift"].values(), default=0.0)
        turnings = report["event_counts"].get("turning", 0)
        note = f"{rate:.3g} s/s, theta {report['theta_end']:.4f}, {turnings} turnings, drift {drift:.0e}"
        self.bar.update(self.task, completed=course.t_end, note=note)


def told(attrs: dict[str, Any]) -> dict[str, Any]:
    """What `run --json` and `info --json` say of a run, from the root attributes of its store."""
    from tippetop import assess, results, scenario
    from tippetop.archive import finite

    return results.info(attrs) | finite(assess.remarks(scenario.problem(scenario.tables_of(attrs))))


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
