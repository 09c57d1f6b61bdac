"""What is printed for people: the summary of a run, and the progress of one."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from ..runs import cost
from ..runs.reporting import RunProgress
from ..runs.summary import lines
from .streams import report, visible


if TYPE_CHECKING:
    from .console import Console


WIDE = 160  # columns of what is no terminal


def console() -> Console:
    """Standard output; no colour when it is not a terminal, and then wide unless COLUMNS says
    otherwise.
    """
    from .console import Console

    return Console(highlight=False, markup=False, width=None if _narrow() else WIDE)


def _narrow() -> bool:
    return sys.stdout.isatty() or "COLUMNS" in os.environ


def warn(sentences: list[str]) -> list[str]:
    """Prints what is allowed, but hardly meant, on standard error; gives it back."""
    for sentence in sentences:
        report(f"warning: {sentence}")
    return sentences


def following() -> AbstractContextManager[Callable[[RunProgress], None]]:
    """Provide a run's progress callback: it draws a bar and warns of a long run."""
    return cost.following(lambda sentence: warn([sentence]))


def summary(
    headline: str, info: Mapping[str, Any], seconds: dict[str, float], places: dict[str, Any]
) -> None:
    """Prints a run in a few lines, without rich: to import it takes longer than to integrate."""
    heading(headline)
    table(
        [
            *lines(info, seconds),
            *((name, str(place)) for name, place in places.items() if place is not None),
        ]
    )


def heading(text: str) -> None:
    """Print a line, bold on a terminal."""
    coloured = (
        sys.stdout.isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    )
    print(f"\x1b[1m{visible(text)}\x1b[0m" if coloured else visible(text))


def table(rows: Iterable[tuple[str, str]]) -> None:
    """Print names and texts in two columns; long texts are wrapped."""
    rows = [(visible(name), visible(" ".join(text.split()))) for name, text in rows]
    indent = max(len(name) for name, _ in rows) + 2
    width = max(shutil.get_terminal_size().columns if _narrow() else WIDE, indent + 20)
    for name, text in rows:
        first, *more = wrap(text, width - indent, break_on_hyphens=False) or [""]
        print(f"{name:<{indent}}{first}", *(" " * indent + line for line in more), sep="\n")
