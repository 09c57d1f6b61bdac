"""A progress bar on stderr: how many are done, how fast, and the time that is left."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from rich.console import Console


class Bar:
    """Counts things; nothing is drawn where stderr is not a terminal. A context; `update` is a progress callback."""

    def __init__(self, things: str):
        self.things = things
        self.bar: Any = None
        self.shown = sys.stderr.isatty() and not os.environ.get("TIPPETOP_QUIET")

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, done: int, of: int) -> None:
        """Says how many are done. What was done before the first call does not count for the rate."""
        if not self.shown:
            return
        now = time.monotonic()
        if self.bar is None:
            self._begin(of)
            self.first, self.began, self.drawn = done, now, 0.0
        if now - self.drawn < 0.1 and done < of:
            return
        self.drawn = now
        rate = (done - self.first) / max(now - self.began, 1e-9)
        note = f"{rate:.3g} {self.things}/s, {_clock((of - done) / rate)} left" if rate else "starting"
        self.bar.update(self.task, completed=done, note=note)

    def _begin(self, of: int) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (MofNCompleteColumn(), TextColumn(self.things), BarColumn(), TextColumn("{task.fields[note]}"))
        bar = Progress(*columns, console=Console(stderr=True), transient=True)
        bar.start()
        self.bar, self.task = bar, bar.add_task("", total=of, note="")


@contextlib.contextmanager
def shown(progress: Callable[[int, int], None] | bool, things: str) -> Iterator[Callable[[int, int], None]]:
    """A progress callback: the given one, or a bar's (True), or one that does nothing (False)."""
    if progress is True:
        with Bar(things) as bar:
            yield bar.update
    else:
        yield progress or (lambda *_: None)


def _clock(seconds: float) -> str:
    """h:mm:ss"""
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"


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
