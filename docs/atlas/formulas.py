"""The list of everything numbered in the source, with the name that reaches it; a test checks that each name exists."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from errata import short

import tippetop as tt


HERE = Path(__file__).parent
RANGES = {"2": 40, "3": 67, "4": 40, "5": 77, "6": 23, "A": 12}
"""How many numbered equations each chapter has."""

OTHERS = {
    "section": "1 2.1 2.1.1 2.2 3.1 3.2 3.3 3.3.1 3.3.2 3.3.3 4.1 4.2 5.1 5.2 5.3 5.4 5.5 6 6.1 A",
    "theorem": "2.1.1 3.3.1 3.3.2 3.3.3 3.3.4",
    "proposition": "3.1.1 3.3.1 3.3.2 5.4.1 5.5.1 A.0.1",
    "lemma": "1",
    "figure": "2.1 2.2 2.3 3.1 3.2 3.3 4.1 5.1 5.2 6.1",
}


class Entry(NamedTuple):
    """A line of the list: a number, a range of equations, or a section, theorem, figure."""

    what: str
    subject: str
    names: tuple[str, ...]
    status: str

    def numbers(self) -> list[str]:
        """The equations that it covers, or its own name."""
        if " " in self.what:
            return [self.what]
        first, _, last = self.what.partition("-")
        chapter, start = first.split(".")
        end = (last or first).split(".")[1]
        return [f"{chapter}.{n}" for n in range(int(start), int(end) + 1)]


def entries() -> list[Entry]:
    """The lines of `formulas.txt`."""
    rows = []
    for line in (HERE / "formulas.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            what, subject, names, *status = (part.strip() for part in line.split("|"))
            rows.append(
                Entry(
                    what,
                    subject,
                    tuple(n.strip() for n in names.split(",")),
                    *(status or ["holds"]),
                )
            )
    return rows


def wanted() -> Iterator[str]:
    """All that the source numbers."""
    for chapter, last in RANGES.items():
        yield from (f"{chapter}.{n}" for n in range(1, last + 1))
    for kind, names in OTHERS.items():
        yield from (f"{kind} {name}" for name in names.split())


def exists(name: str) -> bool:
    """Whether there is what a name names."""
    if name == "text":
        return True
    if name.startswith("mechanics."):
        module, _, attribute = f"tippetop.{name}".rpartition(".")
        return hasattr(import_module(module), attribute)
    if name.startswith("tt."):
        *face, public = name[3:].split(".")
        return public in dir(getattr(tt, face[0], None) if face else tt)
    kind, _, rest = name.partition(" ")
    if kind == "tippetop":
        from tippetop.cli.application import COMMANDS

        return rest in COMMANDS
    if kind == "column":
        return any(rest in columns(system) for system in tt.extending.SYSTEMS.values())
    if kind == "docs":
        return (HERE.parent / f"{rest}.md").is_file()
    if kind in ("erratum", "claim"):
        return any(
            f"({kind}-{rest})=" in page.read_text(encoding="utf-8") for page in HERE.glob("*.md")
        )
    system, _, form = name.partition(" form ")
    return system in tt.extending.SYSTEMS and form in tt.extending.SYSTEMS[system].forms


def columns(system: Any) -> set[str]:
    """The columns that a run of a system can have."""
    quantities = (*system.quantities, *system.on_request)
    return {
        *system.angles._fields,
        *system.vectors,
        *(q.name for q in quantities),
        "psi",
        "orientation",
    }


def _link(name: str) -> str:
    """A name as it stands on the page."""
    kind, _, rest = name.partition(" ")
    if kind in ("erratum", "claim"):
        return f"[{name}](#{kind}-{rest})"
    if kind == "docs":
        page = rest.removeprefix("atlas/")
        return f"[{page}](#{'atlas' if page == 'index' else f'atlas-{page}'})"
    if name == "text":
        return "a step of the text"
    if kind == "column":
        return f"column `{rest}`"
    if " form " in name:
        system, _, form = name.partition(" form ")
        return f'`{system}`, `form="{form}"`'
    return (
        f"`{name.removeprefix('mechanics.')}`" if not name.startswith("mechanics.") else f"`{name}`"
    )


def table(chapter: str) -> Any:
    """The lines of a chapter, for a page."""
    from holding import worst
    from IPython.display import Markdown

    evaluated = worst()
    lines = ["| | subject | reached by | | residual |", "|---|---|---|---|---|"]
    for entry in entries():
        number = "5.0" if entry.what == "lemma 1" else entry.what.rpartition(" ")[2]
        if number.partition(".")[0] != chapter:
            continue
        found = [f"({n}) {short(evaluated[n])}" for n in entry.numbers() if n in evaluated]
        what = entry.what if " " in entry.what else f"({entry.what.replace('-', ') to (')})"
        lines.append(
            f"| {what} | {entry.subject} | {', '.join(map(_link, entry.names))} | {entry.status} | {', '.join(found)} |"
        )
    return Markdown("\n".join(lines))


def counts() -> Any:
    """How much of what holds, for a page."""
    from IPython.display import Markdown

    tally: dict[str, int] = {}
    for entry in entries():
        if " " not in entry.what:
            tally[entry.status] = tally.get(entry.status, 0) + len(entry.numbers())
    total = sum(tally.values())
    rest = ", ".join(f"{status} {n}" for status, n in tally.items() if status != "holds")
    return Markdown(
        f"Of the source's {total} numbered formulas {tally['holds']} hold as printed; of the others: {rest}."
    )
