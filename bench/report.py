"""Writes the tables and figures of bench/README.md, and the README's one table, from
results/*.json.

    python -m bench.report [--results FOLDER]

A table stands between `<!-- bench:NAME -->` and `<!-- /bench:NAME -->`; no number is typed.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

from .equal import common, least, ratio, seconds


HERE = Path(__file__).parent
RESULTS = HERE / "results"
PAGE = HERE / "README.md"
FRONT = HERE.parent / "README.md"
FIGURES = HERE / "figures"
BARE, ERROR = "tippetop, motion alone", 1e-13
SOLVERS = (
    BARE,
    "tippetop, whole run with rows and orientation",
    "heyoka by hand",
    "DOP853, C++",
    "DOP853, SciPy",
)


def read(folder: Path) -> dict[str, Any]:
    """The results that are there, by case."""
    found = {
        path.stem: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(folder.glob("*.json"))
    }
    return {name: result for name, result in found.items() if result.get("case") == name}


def table(head: list[str], *rows: list[str]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines
    )


def number(x: float) -> str:
    """Three digits."""
    if 100 <= abs(x) < 1e5:
        return f"{x:.0f}"
    return f"{x:.3g}" if 1e-3 <= abs(x) < 100 else f"{x:.1e}"


def machine(results: dict[str, Any]) -> str:
    """What it was measured on, and how long each case took."""
    any_of = max(results.values(), key=lambda result: len(result["machine"]["versions"]))["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in any_of["versions"].items())
    rows = [
        [
            name,
            "quick" if result["quick"] else "full",
            f"{result['took']:.0f}",
            ", ".join(map(str, result["machine"]["load_average"])),
            result["machine"]["processor"],
        ]
        for name, result in results.items()
    ]
    said = f"{any_of['processors']} processors; Python {any_of['python']}, {versions}."
    if any(
        result["machine"]["load_average"][0] > result["machine"]["processors"]
        for result in results.values()
    ):
        said += (
            "\nWhere the load average is above the number of processors the machine was shared: "
            "compare processor times there, not wall times."
        )
    return f"{said}\n\n" + table(
        ["case", "", "took [s]", "load average before", "processor"], *rows
    )


def comparison(result: dict[str, Any]) -> str:
    """Every contestant: milliseconds at three errors, its smallest error, and its time relative to
    ours.
    """
    contestants = result["contestants"]
    ours = contestants.get(BARE) or contestants["tippetop, lanes"]
    errors = (1e-7, 1e-10, 1e-13)
    rows = []
    for name, entry in contestants.items():
        if "missing" in entry:
            rows.append([name, *[""] * (len(errors) + 1), "could not run"])
            continue
        at = common(ERROR, entry, ours)
        rows.append(
            [
                name,
                *(_milliseconds(seconds(entry, error)) for error in errors),
                f"{least(entry):.1e}: {_milliseconds(seconds(entry, least(entry)))}",
                f"{number(ratio(entry, ours, at))} at {at:.1e}"
                + (f"; stops {entry['stopped']}" if "stopped" in entry else ""),
            ]
        )
    head = [
        "",
        *(f"ms at {error:.0e}" for error in errors),
        "smallest error: ms",
        "time relative to tippetop, at equal error",
    ]
    return table(head, *rows)


def _milliseconds(x: float) -> str:
    return number(1e3 * x) if x < float("inf") else "-"


def front(results: dict[str, Any]) -> str:
    """Return the table of the README: one inversion by several solvers, at equal error."""
    if "inversion" not in results:
        return "Not run."
    contestants = results["inversion"]["contestants"]
    ours, rows = contestants[BARE], []
    for name, entry in ((name, contestants[name]) for name in SOLVERS):
        if "points" in entry:
            at = common(ERROR, entry, ours)
            times = [_milliseconds(seconds(each, at)) for each in (entry, ours)]
            rows.append([name, f"{at:.1e}", *times, number(ratio(entry, ours, at))])
    head = ["solver", "error of theta [rad]", "CPU time [ms]", "tippetop at this error [ms]"]
    return table([*head, "ratio"], *rows)


def measured(result: dict[str, Any]) -> str:
    """The numbers of a case, a row for each thing that was measured."""
    rows = result["rows"]
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    cells = [
        [number(row[name]) if name in row else "" for name in columns] for row in rows.values()
    ]
    return table(["", *columns], *([name, *row] for name, row in zip(rows, cells, strict=True)))


def sections(results: dict[str, Any]) -> dict[str, str]:
    """Return every table by the name of its place; "Not run." for a case without results."""
    made = {
        name: comparison(result) if "contestants" in result else measured(result)
        for name, result in results.items()
    }
    made |= {"machine": machine(results), "front": front(results)}
    return defaultdict(lambda: "Not run.", made)


def filled(text: str, made: dict[str, str]) -> str:
    """A page with its tables."""

    def put(match: re.Match) -> str:
        return f"<!-- bench:{match[1]} -->\n{made[match[1]]}\n<!-- /bench:{match[1]} -->"

    return re.sub(r"<!-- bench:([\w-]+) -->\n.*?<!-- /bench:\1 -->", put, text, flags=re.DOTALL)


def main() -> None:
    """Writes the pages and the figures."""
    from .drawing import draw

    parser = argparse.ArgumentParser(
        prog="python -m bench.report", description="Writes the tables and figures."
    )
    parser.add_argument(
        "--results", type=Path, default=RESULTS, metavar="FOLDER", help="where the JSON files are"
    )
    options = parser.parse_args()
    results = read(options.results)
    if not results:
        parser.error("--results must hold what `python -m bench` wrote, but holds nothing of it.")
    made = sections(results)
    for page in (PAGE, FRONT):
        page.write_text(filled(page.read_text(encoding="utf-8"), made), encoding="utf-8")
    draw(results, FIGURES)


if __name__ == "__main__":
    main()
