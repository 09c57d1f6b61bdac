"""Compare the results of `python -m bench.simulators DIR OUT` with the exact motions.

`python -m bench.simulators.report DIR OUT` writes OUT/results.json and OUT/results.md, and a figure
of the error against the step.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

import tippetop as tt
from tippetop.figures import style


LOOKS = dict(
    zip(
        ("mujoco", "pybullet", "drake", "dart", "newton", "genesis"),
        (style.RUN, style.UPPER, style.LOWER, style.QUIET, "tab:purple", "tab:olive"),
        strict=True,
    )
)
NUMBERS = ("attitude", "theta", "place", "spin")


def compared(files: list[Path], scenario: Path) -> list[dict[str, Any]]:
    """Return the numbers of each file, the largest step first."""
    with tempfile.TemporaryDirectory() as folder:
        moved = []
        for file in files:
            rows = pd.read_csv(file)
            moved.append(Path(folder) / file.name)
            rows.loc[:, ~rows.columns.str.startswith("force")].to_csv(moved[-1], index=False)
        result = tt.compare(moved, scenario)
    orders = {pair["steps"][1]: pair.get("attitude") for pair in result.orders}
    made = []
    for motion in sorted(result.motions, key=lambda motion: -motion.step):
        n = motion.numbers
        made.append(
            {
                "step": motion.step,
                "until": float(motion.t[-1]),
                "largest": {name: n[name]["max"] for name in NUMBERS if name in n},
                "leaves": n["attitude"]["leaves"],
                "order": orders.get(motion.step),
                "jellett_drift": n.get("jellett_drift"),
                "energy_drift": n.get("energy_drift"),
            }
        )
    return made


def read(exported: Path, out: Path) -> dict[str, dict[str, list]]:
    """Return the numbers by case, and by engine and setting."""
    results: dict[str, dict[str, list]] = {}
    for folder in sorted(out.glob("*/*/*/")):
        engine, setting, case = folder.relative_to(out).parts
        files = sorted(folder.glob("dt=*.csv"))
        scenario = exported / case / "scenario.toml"
        try:
            found = compared(files, scenario)
        except tt.errors.InputError as error:
            print(f"{folder}: {error}")
            continue
        results.setdefault(case, {})[f"{engine}/{setting}"] = found
    return results


def _markdown(rows: list[list[str]]) -> str:
    head, *body = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([head, "|" + " --- |" * len(rows[0]), *body])


def _cell(steps: list[dict] | None, case: str, folder: Path) -> str:
    """Return the largest errors of the attitude and of theta at the smallest step [rad]."""
    if not steps:
        return ""
    last = steps[-1]
    whole = tt.load(folder / case / "scenario.toml").until
    until = "" if last["until"] > 0.99 * whole else f" (to {last['until']:.2g} s)"
    return f"{last['largest']['attitude']:.1e}, {last['largest']['theta']:.1e}{until}"


def table(results: dict[str, dict[str, list]], exported: Path) -> str:
    """Return a Markdown table: case by engine, with the setting `best` and `default`."""
    rows = [["case", "setting", *LOOKS]]
    for case, engines in results.items():
        for setting in ("best", "default"):
            cells = [_cell(engines.get(f"{name}/{setting}"), case, exported) for name in LOOKS]
            rows.append([case, setting, *cells])
    return _markdown(rows)


def scans(results: dict[str, dict[str, list]], exported: Path) -> str:
    """Return a Markdown table of the contact models at a fixed step."""
    rows = [["case", "engine", "setting", "step [s]", "attitude, theta: largest errors [rad]"]]
    for case, engines in results.items():
        for name, steps in engines.items():
            engine, _, setting = name.partition("/")
            if "=" in setting:
                step = f"{steps[-1]['step']:g}"
                rows.append([case, engine, setting, step, _cell(steps, case, exported)])
    return _markdown(rows)


def draw(results: dict[str, dict[str, list]], path: Path) -> None:
    """Draw the largest error of theta against the step, one panel a case."""
    rows = -(-len(results) // 3)
    figure = Figure(figsize=(10, 2.6 * rows), layout="constrained")
    panels = figure.subplots(rows, 3, squeeze=False).ravel()
    for axes, (case, engines) in zip(panels, results.items(), strict=False):
        for name, steps in engines.items():
            engine, _, setting = name.partition("/")
            if setting not in ("default", "best"):
                continue
            axes.loglog(
                [row["step"] for row in steps],
                [max(row["largest"]["theta"], 1e-16) for row in steps],
                marker="o" if setting == "best" else "x",
                ls="-" if setting == "best" else ":",
                color=LOOKS[engine],
                label=f"{engine}, {setting}",
            )
        axes.set_title(case, fontsize=9)
        axes.set_xlabel("step [ms]")
        axes.set_ylabel("largest error of theta [rad]", fontsize=7)
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks([1e-4, 2.5e-4, 5e-4, 1e-3], ["0.1", "0.25", "0.5", "1"])
        low, high = axes.get_ylim()
        axes.set_ylim(low / 2, high * 2)
    for axes in panels[len(results) :]:
        axes.axis("off")
    handles = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=6, fontsize=7)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Write the table and the figure."""
    parser = argparse.ArgumentParser(prog="python -m bench.simulators.report")
    parser.add_argument("exported", type=Path, metavar="DIR")
    parser.add_argument("out", type=Path, metavar="OUT")
    given = parser.parse_args()
    results = read(given.exported, given.out)
    (given.out / "results.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    text = f"{table(results, given.exported)}\n\n{scans(results, given.exported)}\n"
    (given.out / "results.md").write_text(text, encoding="utf-8")
    draw(results, given.out / "error-against-step.png")


if __name__ == "__main__":
    main()
