"""`tippetop help, new, completion`: what may be written, a scenario to begin with, the completion
of words.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ..errors import InputError, suggestion


if TYPE_CHECKING:
    from ..scenario.reference import Section


EXIT_CODES = {
    0: "done",
    1: "a bug: please report it",
    2: "usage or configuration: each sentence says what must hold and what was found",
    3: "the physics stopped it: a fall, or a number that is not finite; a liftoff is an "
    "ordinary end",
    4: "the accuracy contract is broken: a conserved quantity drifted by more than is promised",
    5: "the store or the disk",
    6: "some chunks of a sweep failed; the same command tries them again",
    130: "interrupted by Ctrl-C; what was written to disk stays",
    143: "terminated; what was written to disk stays",
}


def topics() -> dict[str, Any]:
    """What can be asked for: name -> a function that gives the sections."""
    from ..scenario.reference import TOPICS
    from ..sweeps.reference import plan

    return {**TOPICS, "plan": plan, "exit-codes": _exit_codes}


def _exit_codes() -> list[Section]:
    from ..scenario.reference import Section

    rows = [(str(code), text) for code, text in EXIT_CODES.items()]
    return [Section("Exit codes", "", ("code", "what it says"), rows)]


def sections(topic: str) -> list[Section]:
    """The tables of a topic. Raises InputError."""
    known = topics()
    if topic not in known:
        raise InputError(
            f"a topic must be of {', '.join(known)}, but is `{topic}`.{suggestion(topic, known)}"
        )
    return list(known[topic]())


def help(topic: str | None = None, *, markdown: bool = False) -> int:
    """Print what may be written in a scenario or a plan, and what a run says.

    Parameters
    ----------
    topic
        scenario, friction, systems, events, columns, plan or exit-codes; without one the topics.
    markdown
        Print it as Markdown.
    """
    if topic is None:
        print(
            f"tippetop help TOPIC, of {', '.join(topics())}; tippetop COMMAND --help for a command."
        )
        return 0
    tables = sections(topic)
    if markdown:
        print(as_markdown(tables))
        return 0
    from rich.table import Table

    from .text import console

    out = console()
    for number, section in enumerate(tables):
        if number:
            out.print()
        out.print(section.title, style="bold")
        if section.text:
            out.print(section.text)
        table = Table(*section.head, box=None, pad_edge=False, header_style="italic")
        for row in section.rows:
            table.add_row(*row)
        if section.rows:
            out.print(table)
    return 0


def as_markdown(tables: list[Section], level: int = 2) -> str:
    """Sections as tables of Markdown, below headings of a level."""
    parts = []
    for section in tables:
        parts += [f"{'#' * level} {_escaped(section.title)}", _escaped(section.text)]
        if section.rows:
            rows = [
                [_escaped(_unbroken(c, at)) for c, at in zip(row, section.head, strict=True)]
                for row in section.rows
            ]
            lines = [section.head, ["---"] * len(section.head), *rows]
            parts.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
    return "\n\n".join(part for part in parts if part)


def _unbroken(text: str, head: str) -> str:
    """A unit stays on one line."""
    return (
        text.replace(" ", "\N{NO-BREAK SPACE}").replace("-", "\N{NON-BREAKING HYPHEN}")
        if head == "unit"
        else text
    )


def _escaped(text: str) -> str:
    """As Markdown; what stands in backticks is written as it is, but for the bars of a table."""
    plain = str.maketrans({"|": r"\|", "*": r"\*", "<": "&lt;", "[": r"\[", "_": r"\_"})
    parts = text.split("`")
    return "`".join(
        part.replace("|", r"\|") if i % 2 else part.translate(plain) for i, part in enumerate(parts)
    )


def new(system: str = "tippe-top", *, out: Path | None = None, overwrite: bool = False) -> int:
    """Write a scenario with all its keys, what each is and what it must be; it runs as it is.

    Parameters
    ----------
    system
        One of `tippetop systems`, or a preset.
    out
        The TOML file to write; printed where it is left out.
    overwrite
        Replace an existing file.
    """
    from ..scenario.template import template

    text = template(system)
    if out is None:
        print(text, end="")
        return 0
    from ..store import files

    if out.suffix != ".toml":
        raise InputError(f"--out must end with .toml, but is `{out}`.")
    files.write_text(out, text, overwrite=overwrite)
    print(f"file  {out}")
    return 0


def completion(shell: Literal["bash", "zsh", "fish"]) -> int:
    """Print what makes a shell complete the commands and options, such as: source <(tippetop
    completion bash).

    Parameters
    ----------
    shell
        bash, zsh or fish.
    """
    from .application import app_of
    from .overview import COMMANDS

    sys.stdout.write(app_of(COMMANDS).generate_completion(shell=shell))
    return 0
