"""Tables and a figure of the score: `python -m bench.simulators.report OUT`.

OUT holds the results of `python -m bench.simulators DIR OUT`. Writes results.json, results.md and
error-against-step.png there. `--recorded` adds the rows of an earlier results.json for engines that
OUT lacks.
"""

import argparse
import itertools
import json
import math
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator

from tippetop import benchmark
from tippetop.figures.style import LIGHT

from ..report import table


LOOKS = {
    "mujoco": LIGHT.run,
    "pybullet": LIGHT.upper,
    "drake": LIGHT.lower,
    "dart": LIGHT.quiet,
    "newton": "tab:purple",
    "genesis": "tab:olive",
}


def _cell(row: dict, note: str = "") -> str:
    """Return the largest errors of a result, its setting and step, and whether it is right."""
    largest = row["largest"]
    errors = f"{largest['attitude']:.2g} rad, {1e3 * largest['position']:.2g} mm"
    judged = {True: "", False: " (wrong)", None: " (not judged)"}[row["outcome_is_right"]]
    return f"{errors}; {note}{1e3 * row['step']:g} ms{judged}"


def _goodness(row: dict) -> tuple:
    """Return a key that is smaller for better results: a right outcome first, then the errors."""
    largest = row["largest"]
    return row["outcome_is_right"] is not True, largest["attitude"], largest["position"]


def tables(results: dict[tuple[str, str, str], list[dict]]) -> str:
    """Return case by engine, and the contact models varied at a fixed step, as Markdown.

    Of each setting the smallest step counts; of the settings of an engine the best of the case.
    """
    last = {names: steps[-1] for names, steps in results.items()}
    rows = [["case", "setting", *LOOKS]]
    for case in dict.fromkeys(case for case, _, _ in results):
        best, default = [case, "best of all"], [case, "default"]
        for engine in LOOKS:
            of_engine = [row for names, row in last.items() if names[:2] == (case, engine)]
            found = min(of_engine, key=_goodness, default=None)
            best.append(_cell(found, f"{found['setting']}, ") if found else "")
            given = last.get((case, engine, "default"))
            default.append(_cell(given) if given else "")
        rows += [best, default]
    scans = [["case", "engine", "setting", "errors"]]
    for (case, engine, setting), row in last.items():
        if "=" in setting or setting == "exported":
            scans.append([case, engine, setting, _cell(row)])
    return f"{table(*rows)}\n\n{table(*scans)}\n"


def draw(results: dict[tuple[str, str, str], list[dict]], path: Path) -> None:
    """Draw the largest error against the step, one panel a case: of the attitude if it turns."""
    cases = list(dict.fromkeys(case for case, _, _ in results))
    rows = -(-len(cases) // 3)
    figure = Figure(figsize=(10, 2.5 * rows), layout="constrained")
    panels = dict(itertools.zip_longest(cases, figure.subplots(rows, 3, squeeze=False).ravel()))
    panels = {case: axes for case, axes in panels.items() if case or axes.set_axis_off()}
    handles = {}
    for (case, engine, setting), steps in results.items():
        if "=" in setting:
            continue
        marker, dashes = {"best": ("o", "-"), "exported": ("s", "--")}.get(setting, ("x", ":"))
        moved = "attitude" if steps[0]["largest"]["attitude"] else "position"
        (handles[f"{engine}, {setting}"],) = panels[case].loglog(
            [row["step"] for row in steps],
            [row["largest"][moved] for row in steps],
            marker=marker,
            ls=dashes,
            color=LOOKS[engine],
        )
    for case, axes in panels.items():
        axes.set_title(case, fontsize=9)
        axes.set_xlabel("step [ms]")
        axes.set_ylabel("position [m]" if case == "bounce" else "attitude [rad]", fontsize=8)
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks([1e-4, 2.5e-4, 5e-4, 1e-3], ["0.1", "0.25", "0.5", "1"])
        axes.set_xlim(8e-5, 1.25e-3)
        low, high = axes.get_ylim()
        axes.set_ylim(10 ** math.floor(math.log10(low)), 10 ** math.ceil(math.log10(high)))
        axes.yaxis.set_minor_formatter(NullFormatter())
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=6, fontsize=7)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Write the tables and the figure."""
    parser = argparse.ArgumentParser(prog="python -m bench.simulators.report")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--recorded", type=Path, metavar="RESULTS.json")
    given = parser.parse_args()
    out, scored = given.out, benchmark.score(given.out).to_dict()
    for row in scored:
        for name in ("file", "at", "rms", "mean"):
            del row[name]
    if given.recorded:
        fresh = {row["engine"] for row in scored}
        earlier = json.loads(given.recorded.read_text(encoding="utf-8"))
        scored += [row for row in earlier if row["engine"] not in fresh]
        scored.sort(key=lambda row: (row["case"], row["engine"], row["setting"], -row["step"]))
    names = [(row["case"], row["engine"], row["setting"]) for row in scored]
    results: dict[tuple[str, str, str], list[dict]] = {name: [] for name in names}
    for name, row in zip(names, scored, strict=True):
        results[name].append(row)
    (out / "results.json").write_text(json.dumps(scored, indent=1) + "\n", encoding="utf-8")
    (out / "results.md").write_text(tables(results), encoding="utf-8")
    draw(results, out / "error-against-step.png")


if __name__ == "__main__":
    main()
