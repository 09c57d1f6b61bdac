"""A progress bar on stderr: how much is done, how fast, and the time that is left."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any


FIRST_AFTER, AGAIN_AFTER = 0.4, 0.1  # [s]: what is sooner done needs no bar; nobody reads faster
# [s] after which a bar is there though nothing is done yet: the first thing may have to be compiled
SILENT = 2.0


STARTING = "starting (compiling)"


class Bar:
    """Follows work that can be counted or measured. A context; `update` is a progress callback.

    Nothing is drawn where stderr is not a terminal, nor where the environment variable
    TIPPETOP_QUIET is set.

    Parameters
    ----------
    things
        What is counted, or the unit of what is measured.
    count
        A format of how far it has come, with `done`, `of` and `things`.
    """

    def __init__(self, things: str, count: str = "{done}/{of} {things}"):
        self.things, self.count = things, count
        self.bar: Any = None
        self.visible = sys.stderr.isatty() and not os.environ.get("TIPPETOP_QUIET")
        self.began: float | None = None
        self._lock = threading.RLock()
        self._waits: threading.Timer | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self.visible = False  # a timer that is late draws nothing
            if self._waits is not None:
                self._waits.cancel()
            if self.bar is not None:
                self.bar.stop()

    def update(self, done: float, of: float, note: Callable[[], str] | None = None) -> None:
        """Says how much is done, and what else there is to say of it.

        What was done before the first call does not count for the rate.
        """
        if not self.visible:
            return
        now = time.monotonic()
        if self.began is None:
            self.first, self.began, self.due = done, now, now + FIRST_AFTER
            self._waits = threading.Timer(SILENT, self._starting, (done, of))
            self._waits.daemon = True
            self._waits.start()
        if now < self.due:
            return
        self.due = now + AGAIN_AFTER
        with self._lock:
            if self.bar is None:
                self._begin(of)
        rate = (done - self.first) / max(now - self.began, 1e-9)
        text = (
            f"{rate:.3g} {self.things}/s, {_clock((of - done) / rate)} left" if rate else STARTING
        )
        self._show(done, of, text + (f", {note()}" if note is not None else ""))

    def _show(self, done: float, of: float, note: str) -> None:
        count = self.count.format(done=done, of=of, things=self.things)
        self.bar.update(self.task, completed=done, total=of, count=count, note=note)

    def _starting(self, done: float, of: float) -> None:
        """Draws the bar of work of which nothing is done yet."""
        with self._lock:
            if not self.visible or self.bar is not None:
                return
            self._begin(of)
        self._show(done, of, STARTING)

    def _begin(self, of: float) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        columns = (
            TextColumn("{task.fields[count]}"),
            BarColumn(),
            TextColumn("{task.fields[note]}"),
        )
        self.bar = Progress(*columns, console=Console(stderr=True), transient=True)
        self.bar.start()
        self.task = self.bar.add_task("", total=of, count="", note="")


@contextlib.contextmanager
def reporting(
    progress: Callable[[int, int], None] | bool, things: str
) -> Iterator[Callable[[int, int], None]]:
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
