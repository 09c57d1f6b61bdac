"""What `tippetop`, `tippetop --help` and `--version` print: the commands, each with its module and
one sentence.

A command's module is imported when it is called. The sentences are the first ones of the commands'
docstrings.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence


PURPOSE = (
    "Tippe tops, heavy tops and eccentric cylinders that roll and glide on a plane: integrated "
    "to rounding, with "
    "their events, stored, checked and drawn.",
    "A first run: `tippetop run inverting --figure inverting.png`. `tippetop presets` lists the "
    "scenarios to start "
    "from, `tippetop new` writes one with every key, `tippetop help` explains them. The manual "
    "is README.md and docs/ "
    "of the source.",
)
SENTENCES = {
    "run": {
        "run": "Integrate a scenario: a TOML file or the name of a preset.",
        "resume": (
            "Continue an interrupted run, or a finished one to a later end; the store equals "
            "that of one run, bit by bit."
        ),
        "replay": (
            "Integrate a part of a stored run again, from its nearest keyframe: the rows it "
            "would have stored, bit by bit."
        ),
    },
    "landscape": {
        "surface": (
            "The minimal surface F(D, lambda) of a tippe top over a grid of any size; the same "
            "command continues an unfinished one."
        ),
        "potential": "The effective potential V(z; D, lambda) of a tippe top, and its minimum.",
    },
    "sweep": {
        "sweep": (
            "Run the many tops of a plan into a store; the same command continues an unfinished "
            "one: the same bits."
        ),
    },
    "plot": {
        "plot": (
            "Draw a store to a PNG, SVG or PDF file; several runs in one panel; of a scenario "
            "its diagram of states."
        ),
    },
    "show": {
        "info": (
            "Print what is in a store: status, events, inversion, drift of the invariants, "
            "provenance."
        ),
        "check": (
            "Validate a scenario: invariants at the start, thresholds, expected fate; cost, by "
            "the first steps of the run."
        ),
        "export": (
            "Write a store as one netCDF, CSV or Parquet file, or the body of a scenario for a "
            "simulator (MJCF, URDF)."
        ),
        "systems": (
            "List the systems: forms, parameters and initial keys with their units, friction "
            "laws, integrals, events."
        ),
        "presets": "List the built-in scenarios with their sources.",
    },
    "view": {
        "view": (
            "Write one HTML file that shows a run in motion, or the map of a sweep, in a "
            "browser, without a network."
        ),
    },
    "benchmark": {
        "benchmark": (
            "Export reference cases for contact simulators, and score the results of an engine."
        ),
    },
    "exchange": {
        "compare": (
            "Hold another program's motion against the exact one: tippetop compare OTHER.csv "
            "... REFERENCE."
        ),
        "fit": (
            "Fit numbers of a scenario to a measured motion: tippetop fit DATA SCENARIO --free "
            "friction.mu,initial.omega3."
        ),
    },
    "reconstruct": {
        "reconstruct": (
            "Solve the main equation for theta(t) by a run's D(t) and E~(t), or L_z(t) and "
            "E~(t), and compare it with the run."
        ),
    },
    "reference": {
        "new": (
            "Write a scenario with all its keys, what each is and what it must be; it runs as "
            "it is."
        ),
        "help": "Print what may be written in a scenario or a plan, and what a run says.",
        "completion": (
            "Print what makes a shell complete the commands and options, such as: source "
            "<(tippetop completion bash)."
        ),
    },
}
"""By module: its commands, and what each does."""

MODULES = {name: module for module, commands in SENTENCES.items() for name in commands}
COMMANDS = {
    name: sentence for commands in SENTENCES.values() for name, sentence in commands.items()
}
WITHOUT_ENGINE = {"export", "systems", "presets", "new", "help", "completion"}
FLAGS = {
    "--help (-h)": "Display this message, or that of a command, and exit.",
    "--version": "Display the version.",
}


def answer(words: Sequence[str]) -> str | None:
    """What words that call no command ask for; None where a command, or nothing that there is, is
    called.
    """
    if not words or list(words) in (["--help"], ["-h"]):
        return text(min(max(shutil.get_terminal_size().columns, 40), 120))
    if list(words) == ["--version"]:
        return version()
    return None


def version() -> str:
    """The version of the package."""
    from importlib.metadata import version

    return version("tippetop")


def text(width: int) -> str:
    """The commands, in lines of a width."""
    from textwrap import wrap

    lines = ["Usage: tippetop COMMAND", ""]
    for paragraph in PURPOSE:
        lines += [*wrap(paragraph, width, break_on_hyphens=False), ""]
    entries = dict(sorted(COMMANDS.items())) | FLAGS
    indent = max(map(len, entries)) + 4
    lines.append("Commands:")
    for name, sentence in entries.items():
        first, *more = wrap(sentence, width - indent, break_on_hyphens=False)
        lines += [f"  {name:<{indent - 2}}{first}", *(" " * indent + line for line in more)]
    return "\n".join(lines)
