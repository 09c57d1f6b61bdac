"""Writes the tables and figures of bench/README.md, and the README's one table, from
results/*.json.

    python -m bench.report [--results FOLDER]

A table stands between `<!-- bench:NAME -->` and `<!-- /bench:NAME -->`; no number is typed.
"""

import argparse
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .equal import common, least, ratio, seconds


HERE = Path(__file__).parent
RESULTS, PAGE, FRONT, FIGURES = (
    HERE / "results",
    HERE / "README.md",
    HERE.parent / "README.md",
    HERE / "figures",
)
BARE, ERROR = "tippetop, motion alone", 1e-13
FIVE = (BARE, "heyoka by hand", "DOP853, C++", "DOP853, numbalsoda", "DOP853, SciPy")
COMPARISONS = ("inversion", "rolling", "heavy-top", "cylinder", "ensemble")
ENGINE = (
    "equations only",
    "events on",
    "whole run without rows",
    "whole run with rows",
    "whole run with rows and orientation",
)


def read(folder: Path) -> dict[str, Any]:
    """The results that are there, by case."""
    found = {
        path.stem: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(folder.glob("*.json"))
    }
    return {name: result for name, result in found.items() if result.get("case") == name}


def table(head: list[str], rows: list[list[str]]) -> str:
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
    return f"{said}\n\n" + table(["case", "", "took [s]", "load average before", "processor"], rows)


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
    return table(head, rows)


def _one(x: float) -> str:
    return f"{x:.0e}"


def _milliseconds(x: float) -> str:
    return number(1e3 * x) if x < float("inf") else "-"


def front(results: dict[str, Any]) -> str:
    """Return the table of the README: one canonical inversion by five solvers, at equal error."""
    if "inversion" not in results:
        return "Not run."
    contestants = results["inversion"]["contestants"]
    ours, rows = contestants[BARE], []
    for name, entry in ((name, contestants[name]) for name in FIVE):
        if "points" in entry:
            at = common(ERROR, entry, ours)
            times = [_milliseconds(seconds(each, at)) for each in (entry, ours)]
            rows.append([name, f"{at:.1e}", *times, number(ratio(entry, ours, at))])
    head = ["solver", "error of theta [rad]", "CPU time [ms]", "tippetop at this error [ms]"]
    return table([*head, "ratio"], rows)


def events(results: dict[str, Any]) -> str:
    """What events, confirmation and rows add to the equations, to rounding, in ms."""
    rows = []
    there = [results[name]["contestants"] for name in COMPARISONS[:-1] if name in results]
    parts = [part for part in ENGINE if any(f"tippetop, {part}" in found for found in there)]
    for name in COMPARISONS[:-1]:
        if name in results:
            found = results[name]["contestants"]
            last = [
                found[f"tippetop, {part}"]["points"][-1]["seconds"]
                if f"tippetop, {part}" in found
                else math.inf
                for part in parts
            ]
            rows.append(
                [
                    f"{results[name]['title']}, {results[name]['until']:g} s",
                    *(_milliseconds(x) for x in last),
                    number(last[1] / last[0]),
                ]
            )
    return table(["", *parts, "events on / equations only"], rows)


def formulations(result: dict[str, Any]) -> str:
    """Every way that was tried."""
    rows = [
        [
            name,
            *(str(w[k]) for k in ("terms", "products", "order", "steps")),
            _milliseconds(w["seconds"]),
            _one(w["error"]),
        ]
        for name, w in result["ways"].items()
    ]
    return table(["", "terms", "products", "order", "steps", "ms", "error of cos(theta)"], rows)


def storing(result: dict[str, Any]) -> str:
    """Seconds of runs at 1 kHz."""
    words = {"bare": "equations only", "followed": "followed", "keyframes": "with keyframes"}
    words |= {"three": "three columns", "stored": "all columns"}
    ways = [way for way in words if all(way in r["seconds"] for r in result["runs"].values())]
    rows = [
        [
            name,
            str(r["rows"]),
            *(number(r["seconds"][way]) for way in ways),
            *(number(r[f"{way} / bare"]) for way in ways[2:]),
        ]
        for name, r in result["runs"].items()
    ]
    head = [f"{words[way]} [s]" for way in ways] + [
        f"{words[way]} / equations only" for way in ways[2:]
    ]
    found = table(["run", "rows", *head], rows)
    if "long" not in result:
        return found
    bounds = [
        [
            name,
            *(number(r["zarr alone"][way] / r["seconds"]["bare"]) for way in ("three", "stored")),
            number(result["long"][name]["until"]),
            *(number(result["long"][name][f"{way} / bare"]) for way in ("followed", "keyframes")),
        ]
        for name, r in result["runs"].items()
    ]
    beside = [
        "zarr alone, three columns / equations only",
        "zarr alone, all / equations only",
        "a longer span [s]",
    ]
    beside += ["followed / equations only", "with keyframes / equations only"]
    return f"{found}\n\n{table(['run', *beside], bounds)}"


def whole(result: dict[str, Any]) -> str:
    """What runs cost beside their motion."""
    inner = {
        "equations / motion": "with its integrals / motion",
        "loop / motion": "compiled loop / motion",
    }
    ways = [way for way in inner if all(way in r for r in result["runs"].values())]
    ways += ["whole / motion", "rows / motion", "processor / wall"]
    rows = [
        [
            f"{name}, {r['form']} form",
            *(_milliseconds(r["seconds"][way]) for way in ("motion", "whole", "rows")),
            *(number(r[way]) for way in ways),
        ]
        for name, r in result["runs"].items()
    ]
    head = [
        "motion alone [ms]",
        "whole run [ms]",
        "with rows in memory [ms]",
        *(inner.get(way, way) for way in ways),
    ]
    beside = table(["run", *head], rows)
    if "hops" not in result:
        return beside
    hops = result["hops"]
    each = (f"{_milliseconds(seconds)} (`{name}`)" for name, seconds in hops["seconds"].items())
    text = (
        f"A second of motion with its rows [ms]: {' and '.join(each)}, "
        f"{number(hops['ratio'])} times as much;"
    )
    return f"{beside}\n\n{text} in the first the contact changes its phase {hops['changes']} times."


def sweep(result: dict[str, Any]) -> str:
    """Return the table of what the store adds, and a sentence on the efficiency of two workers."""
    rows = [
        [way, number(w["seconds"]), f"{w['wall']:.3f}", f"{w['processor']:.3f}"]
        for way, w in result["ways"].items()
    ]
    head = [
        f"{result['title']}: {result['tops']} tops",
        "seconds",
        "wall time / plain",
        "processor time / plain",
    ]
    one, two = result["seconds_by_1_and_2_workers"]
    efficiency = f"efficiency {result['efficiency_of_2_workers']:.2f}"
    if "efficiency_by_processor" in result:
        efficiency += f", by processor time {result['efficiency_by_processor']:.2f}"
    said = (
        f"With smaller chunks, which two workers can share: {number(one)} s with one worker, "
        f"{number(two)} s with two, {efficiency}."
    )
    return f"{table(head, rows)}\n\n{said}"


def surface(result: dict[str, Any]) -> str:
    """Nanoseconds per point."""
    errors, best = result["largest_relative_error"], result["best_ns_per_point"]
    rows = [
        [name, number(ns), number(best[name]), f"{errors[name]:.1e}" if name in errors else ""]
        for name, ns in result["ns_per_point"].items()
    ]
    return table(["", "ns a point, median", "best", "largest relative error"], rows)


def startup(result: dict[str, Any]) -> str:
    """Cold and warm, and where it goes."""
    cold, warm = result["cold"], result["warm"]
    rows = [
        [stage, number(cold["stages"][stage]), number(warm["stages"][stage])]
        for stage in cold["stages"]
    ]
    rows += [
        ["**the command, wall clock**", number(cold["wall"]), number(warm["wall"])],
        ["the command, processor", number(cold["processor"]), number(warm["processor"])],
        *(
            [["`tippetop run inverting`, wall clock", "", number(result["alone"]["wall"])]]
            if "alone" in result
            else []
        ),
        ["`tippetop --help`, wall clock", "", number(result["help"]["wall"])],
        ["`python -c pass`, wall clock", "", number(result["interpreter"]["wall"])],
    ]
    return table(["stage, processor time", "cold [s]", "warm [s]"], rows)


def scaling(result: dict[str, Any]) -> str:
    """Cost by size, and the exponents."""
    parts = []
    for name in ("span", "tops", "grid"):
        found = result[name]
        rows = [
            [
                number(r["size"]),
                number(r["seconds"]),
                "extrapolated, not run" if r.get("extrapolated") else "",
            ]
            for r in found["rows"]
        ]
        exponent = f"fitted exponent over the last decades: {found['exponent']:.2f}"
        parts.append(table([found["what"], "seconds", exponent], rows))
    rows = [
        [f"{r['tolerance']:.0e}", r["precision"], _milliseconds(r["seconds"]), f"{r['error']:.1e}"]
        for r in result["tolerance"]["rows"]
    ]
    exponents = ", ".join(
        f"{x:.2f} in {name}" for name, x in result["tolerance"]["exponents"].items()
    )
    parts.append(
        table(
            [
                "tolerance",
                "precision",
                "ms",
                f"error of theta; exponent of the digits: {exponents}",
            ],
            rows,
        )
    )
    if "streamed" in result:
        s = result["streamed"]
        parts.append(
            f"Into a store: {number(s['points'])} points in {number(s['seconds'])} s, "
            f"{number(s['stored_MB'])} MB."
        )
    return "\n\n".join(parts)


def sections(results: dict[str, Any]) -> dict[str, str]:
    """Return every table by the name of its place; "Not run." for a case without results."""
    ways: dict[str, Callable[[dict[str, Any]], str]] = {
        **dict.fromkeys(COMPARISONS, comparison),
        "formulations": formulations,
        "storing": storing,
        "whole": whole,
        "sweep": sweep,
        "surface": surface,
        "startup": startup,
        "scaling": scaling,
    }
    made = {
        name: way(results[name]) if name in results else "Not run." for name, way in ways.items()
    }
    return made | {
        "machine": machine(results),
        "events": events(results),
        "front": front(results),
    }


def filled(text: str, made: dict[str, str]) -> str:
    """A page with its tables; KeyError for a place that no table belongs to."""

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
