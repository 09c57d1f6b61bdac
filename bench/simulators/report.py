"""Tables and a figure of the score: `python -m bench.simulators.report OUT`.

OUT holds the results of `python -m bench.simulators DIR OUT`. Writes results.json, results.md and
error-against-step.png there.
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


LOOKS = {
    "mujoco": LIGHT.run,
    "pybullet": LIGHT.upper,
    "drake": LIGHT.lower,
    "dart": LIGHT.quiet,
    "newton": "tab:purple",
    "genesis": "tab:olive",
}


def _markdown(rows: list[list[str]]) -> str:
    head, *body = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([head, "|" + " --- |" * len(rows[0]), *body])


def _cell(steps: list[dict] | None) -> str:
    """Return the largest errors at the smallest step, and whether the outcome is right."""
    if not steps:
        return ""
    last = steps[-1]
    largest = last["largest"]
    errors = f"{largest['attitude']:.1g} rad, {1e3 * largest['position']:.1g} mm"
    judged = {True: "", False: " (wrong)", None: " (not judged)"}[last["outcome_is_right"]]
    return errors + judged


def tables(results: dict[tuple[str, str, str], list[dict]]) -> str:
    """Return case by engine, and the contact models varied at a fixed step, as Markdown."""
    rows = [["case", "setting", *LOOKS]]
    for case in dict.fromkeys(case for case, _, _ in results):
        for setting in ("best", "default"):
            cells = [_cell(results.get((case, engine, setting))) for engine in LOOKS]
            rows.append([case, setting, *cells])
    scans = [["case", "engine", "setting", "step [s]", "errors"]]
    for (case, engine, setting), steps in results.items():
        if "=" in setting:
            scans.append([case, engine, setting, f"{steps[-1]['step']:g}", _cell(steps)])
    return f"{_markdown(rows)}\n\n{_markdown(scans)}\n"


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
        best = setting == "best"
        moved = "attitude" if steps[0]["largest"]["attitude"] else "position"
        (handles[f"{engine}, {setting}"],) = panels[case].loglog(
            [row["step"] for row in steps],
            [row["largest"][moved] for row in steps],
            marker="o" if best else "x",
            ls="-" if best else ":",
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
    out = parser.parse_args().out
    scored = benchmark.score(out).to_dict()
    for row in scored:
        del row["file"]
    names = [(row["case"], row["engine"], row["setting"]) for row in scored]
    results: dict[tuple[str, str, str], list[dict]] = {name: [] for name in names}
    for name, row in zip(names, scored, strict=True):
        results[name].append(row)
    (out / "results.json").write_text(json.dumps(scored, indent=1) + "\n", encoding="utf-8")
    (out / "results.md").write_text(tables(results), encoding="utf-8")
    draw(results, out / "error-against-step.png")


if __name__ == "__main__":
    main()
