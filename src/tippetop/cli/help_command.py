"""`tippetop help, new, completion`: the keys of scenarios and plans, and a first scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from ..errors import InputError, suggestion
from .values import Place


if TYPE_CHECKING:
    from ..scenario.scenario_reference import Section


EXIT_CODES = {
    0: "done",
    1: "a bug: please report it",
    2: "usage or configuration: each sentence gives the requirement and the value found",
    3: "the motion could not be continued: a non-finite state, or steps that became too short",
    4: "the accuracy contract is broken: a conserved quantity drifted by more than is promised; or "
    "a result fails in benchmark score --fail-above",
    5: "the store or the disk",
    6: "some chunks of a sweep failed; the same command without --overwrite tries them again",
    130: "interrupted by Ctrl-C; data on the disk are kept",
    143: "terminated; data on the disk are kept",
}


def topics() -> dict[str, Any]:
    """Return the topics of `tippetop help`: name -> a function that returns the sections.

    The docstring of `help` lists the names.
    """
    from ..scenario.scenario_reference import TOPICS, Section
    from ..sweeps.plan_reference import plan

    def measurements() -> list[Section]:
        """Return the columns that a table of measurements may have, with their units."""
        from ..exchange.headers import KINDS, LEAN, SCALARS

        columns = [(name, unit.symbol, text) for name, (unit, text) in SCALARS.items()]
        columns += [(", ".join(n.split()), unit.symbol, text) for n, unit, text in KINDS.values()]
        head = "The header of a table names columns and units; any unit of the same kind is read."
        return [Section("Measurements", head, ("column", "unit", "meaning"), [*columns, LEAN])]

    rows = [(str(code), text) for code, text in EXIT_CODES.items()]
    codes = Section("Exit codes", "", ("code", "meaning"), rows)
    return {**TOPICS, "measurements": measurements, "plan": plan, "exit-codes": lambda: [codes]}


def help(topic: str | None = None, *, markdown: bool = False) -> int:
    """Print the keys of a scenario or a plan, and the columns and events of a run.

    Parameters
    ----------
    topic
        scenario, friction, systems, events, columns, measurements, plan or exit-codes; by default a
        list of them.
    markdown
        Print it as Markdown.
    """
    known = topics()
    if topic is None:
        print(f"tippetop help TOPIC, of {', '.join(known)}; tippetop COMMAND --help for a command.")
        return 0
    if topic not in known:
        raise InputError(
            f"a topic must be of {', '.join(known)}, but is `{topic}`.{suggestion(topic, known)}"
        )
    sections = known[topic]()
    if markdown:
        print(as_markdown(sections))
        return 0
    from rich.table import Table

    from .text import console

    out = console()
    for section in sections:
        out.print(section.title, style="bold")
        if section.text:
            out.print(section.text)
        table = Table(*section.head, box=None, pad_edge=False, header_style="italic")
        for row in section.rows:
            table.add_row(*row)
        out.print(*[table] if section.rows else [], end="\n\n")
    return 0


def as_markdown(sections: list[Section]) -> str:
    """Return sections as headings and tables of Markdown."""
    parts = []
    for section in sections:
        rows = [section.head, ["---"] * len(section.head), *section.rows]
        lines = [f"| {' | '.join(map(_escaped, row))} |" for row in rows if section.rows]
        parts += [f"## {_escaped(section.title)}", _escaped(section.text), "\n".join(lines)]
    return "\n\n".join(part for part in parts if part)


def _escaped(text: str) -> str:
    """Return text as Markdown; between backticks only the bars of a table are escaped."""
    plain = str.maketrans({"|": r"\|", "*": r"\*", "<": "&lt;", "[": r"\[", "_": r"\_"})
    parts = text.split("`")
    return "`".join(
        part.replace("|", r"\|") if i % 2 else part.translate(plain) for i, part in enumerate(parts)
    )


def new(system: str = "tippe-top", *, out: Place | None = None, overwrite: bool = False) -> int:
    """Write a scenario with all its keys, explained in comments; it runs as it is.

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
    """Print a script that completes commands and options: source <(tippetop completion bash).

    Parameters
    ----------
    shell
        bash, zsh or fish.
    """
    from ..figures.catalogue import FIGURES, SWEEP_KINDS
    from ..scenario.reading import presets
    from .application import COMMANDS, application

    app = application()
    scenarios: Any = Literal[tuple(presets())] | str
    kinds: Any = Literal[tuple(FIGURES | SWEEP_KINDS)] | str
    for command in COMMANDS:  # this process reads no further command line
        hints = app[command].default_command.__annotations__
        hints.update(scenario=scenarios, system=scenarios, words=kinds)
    # where bash knows no word it completes files: scenarios and stores
    print(app.generate_completion(shell=shell).replace("complete -F", "complete -o default -F"))
    return 0
