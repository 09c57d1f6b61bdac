"""Text for people: headings, tables, warnings, and the progress of a run."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable
from textwrap import wrap
from typing import Any, NoReturn

from .streams import report, visible


WIDE = 160  # columns of an output that is not a terminal


def width() -> int:
    """Return the columns of the output: COLUMNS, those of the terminal, or WIDE."""
    narrow = sys.stdout.isatty() or "COLUMNS" in os.environ
    return shutil.get_terminal_size().columns if narrow else WIDE


def console() -> Any:
    """Return rich's console, for help and for tables of several columns."""
    from rich.console import Console

    class Quiet(Console):
        def on_broken_pipe(self) -> NoReturn:
            raise  # the BrokenPipeError, for `cli.outcome`

    return Quiet(highlight=False, markup=False, width=width())


def warn(sentences: list[str]) -> list[str]:
    """Print warnings on standard error and return them."""
    for sentence in sentences:
        report(f"warning: {sentence}")
    return sentences


def table(rows: Iterable[tuple[str, str]]) -> None:
    """Print names and texts in two columns; long texts are wrapped."""
    rows = [(visible(name), visible(" ".join(text.split()))) for name, text in rows]
    indent = max(len(name) for name, _ in rows) + 2
    for name, text in rows:
        first, *more = wrap(text, max(width() - indent, 20), break_on_hyphens=False) or [""]
        print(f"{name:<{indent}}{first}", *(" " * indent + line for line in more), sep="\n")
