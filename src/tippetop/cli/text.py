"""What is printed for people: the summary of a run, and the progress of one."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rich.table import Table

from ..runs.patience import Patience
from ..runs.summary import lines
from .streams import Console


if TYPE_CHECKING:
    from ..progress import Bar


def console() -> Console:
    """Standard output; no colour when it is not a terminal, and then wide unless COLUMNS says otherwise."""
    narrow = sys.stdout.isatty() or "COLUMNS" in os.environ
    return Console(highlight=False, markup=False, width=None if narrow else 160)


def warn(sentences: list[str]) -> list[str]:
    """Prints what is allowed, but hardly meant, on standard error; gives it back."""
    for sentence in sentences:
        print(f"tippetop: warning: {sentence}", file=sys.stderr)
    return sentences


def following(bar: Bar) -> Callable[[Any], None]:
    """A run's progress callback, which tells a bar how far the integration has come, and warns of a long one."""

    def note(report: dict[str, Any]) -> str:
        drift = max(report["drift"].values(), default=0.0)
        turnings = report["event_counts"].get("turning", 0)
        return f"theta {report['theta_end']:.4f}, {turnings} turnings, drift {drift:.0e}"

    patience = Patience(lambda sentence: warn([sentence]))

    def follow(integration: Any) -> None:
        bar.update(integration.t_end, integration.problem.until, lambda: note(integration.report()))
        patience(integration)

    return follow


def summary(headline: str, info: Mapping[str, Any], seconds: dict[str, float], places: dict[str, Any]) -> None:
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
