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
            """Raise the BrokenPipeError that rich has caught."""
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


def units_of(tables: dict[str, Any]) -> dict[str, str]:
    """Return the units of the keys of a scenario; none if its system is unknown here.

    A key has the same unit in every table that has it.
    """
    from ..mechanics.systems import find
    from ..scenario import build

    system = find(tables["system"])
    units = build.units_of(system, tables).values() if system is not None else ()
    return {name: unit.symbol for table in units for name, unit in table.items()}


def plain(value: Any, units: dict[str, str]) -> str:
    """Return a value as text: numbers have eight digits, tables are written as `entries`."""
    if isinstance(value, dict):
        return entries(value, units)
    if isinstance(value, list):
        return ", ".join(plain(each, units) for each in value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def entries(table: Any, units: dict[str, str]) -> str:
    """Return a table of a scenario, or of quantities, on one line: key = value unit."""
    return ", ".join(f"{key} = {_with_unit(value, units.get(key))}" for key, value in table.items())


def _with_unit(entry: Any, unit: str | None) -> str:
    """Return a number with its unit: `entry` is the number, or a record of value and unit."""
    if isinstance(entry, dict):
        entry, unit = entry["value"], entry["unit"]
    bare = unit in ("1", None) or isinstance(entry, bool | str)
    return plain(entry, {}) if bare else f"{plain(entry, {})} {unit}"
