"""The commands by module, and what `tippetop --help` prints: nothing else is imported for it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path


PURPOSE = (
    "Tippe tops, heavy tops and eccentric cylinders that roll and glide on a plane: integrated "
    "to rounding, with their events, stored, checked and drawn.",
    "A first run: `tippetop run inverting --figure inverting.png`. `tippetop presets` lists the "
    "scenarios to start from, `tippetop new` writes one with every key, `tippetop help` explains "
    "them. The manual is README.md and docs/ of the source.",
)
_NAMES = {
    "run": "run resume replay",
    "landscape": "surface potential",
    "sweep": "sweep",
    "plot": "plot",
    "show": "info check export systems presets",
    "view": "view",
    "benchmark": "benchmark",
    "exchange": "compare fit",
    "reconstruct": "reconstruct",
    "reference": "new help completion",
}
COMMANDS = {name: module for module, names in _NAMES.items() for name in names.split()}
"""The module of each command."""
WITHOUT_ENGINE = {"export", "systems", "presets", "new", "help", "completion"}
FLAGS = {
    "--help (-h)": "Display this message, or that of a command, and exit.",
    "--version": "Display the version.",
}


def answer(words: Sequence[str]) -> str | None:
    """Return what words that name no command print; None for others."""
    first = words[0] if words else "--help"
    if first in ("--help", "-h"):
        return text(min(max(shutil.get_terminal_size().columns, 40), 120))
    return version() if first == "--version" else None


def version() -> str:
    """Return the version of the package."""
    from importlib.metadata import version

    return version("tippetop")


def summary(name: str) -> str:
    """Return the summary of a command: the first line of its docstring, without its module."""
    source = Path(__file__).with_name(f"{COMMANDS[name]}.py").read_text(encoding="utf-8")
    return re.findall(rf'^def {name}\(.*?"""([^\n]+)', source, re.MULTILINE | re.DOTALL)[0]


def text(width: int) -> str:
    """Return the overview in lines of a width."""
    from textwrap import wrap

    lines = ["Usage: tippetop COMMAND", ""]
    for paragraph in PURPOSE:
        lines += [*wrap(paragraph, width, break_on_hyphens=False), ""]
    entries = {name: summary(name) for name in sorted(COMMANDS)} | FLAGS
    indent = max(map(len, entries)) + 4
    lines.append("Commands:")
    for name, sentence in entries.items():
        first, *more = wrap(sentence, width - indent, break_on_hyphens=False)
        lines += [f"  {name:<{indent - 2}}{first}", *(" " * indent + line for line in more)]
    return "\n".join(lines)
