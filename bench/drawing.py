"""The figures of bench/README.md."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from tippetop.figures import style
from tippetop.figures.style import LIGHT


LOOKS = {  # colour, marker, line
    "tippetop, motion alone": (LIGHT.run, "D", "-"),
    "tippetop, motion, turnings, liftoff": (LIGHT.run, "D", "--"),
    "tippetop, equations only": (LIGHT.run, "o", "-"),
    "tippetop, lanes": (LIGHT.run, "o", "-"),
    "tippetop, lanes, motion alone": (LIGHT.run, "s", "--"),
    "tippetop, events on": (LIGHT.run, "s", "--"),
    "tippetop, whole run without rows": (LIGHT.run, "v", ":"),
    "tippetop, whole run with rows": (LIGHT.run, "^", ":"),
    "tippetop, whole run with rows and orientation": (LIGHT.run, "P", ":"),
    "heyoka by hand": (LIGHT.lower, "o", "-"),
    "heyoka by hand, events on": (LIGHT.lower, "s", "--"),
    "DOP853, C++": (LIGHT.upper, "o", "-"),
    "DOP853, numbalsoda": (LIGHT.upper, "s", "--"),
    "Dopri8, diffrax": (LIGHT.upper, "^", ":"),
    "DOP853, SciPy": (LIGHT.quiet, "D", "-"),
}


def draw(results: dict[str, Any], folder: Path) -> None:
    """Writes a figure for every result that has one."""
    folder.mkdir(exist_ok=True)
    with style.styled():
        for name, result in results.items():
            if "contestants" in result:
                style.save(precision(result), folder / f"{name}.png", overwrite=True)
        if "scaling" in results:
            style.save(scaling(results["scaling"]), folder / "scaling.png", overwrite=True)
        if "startup" in results:
            style.save(startup(results["startup"]), folder / "startup.png", overwrite=True)


def precision(result: dict[str, Any]) -> Figure:
    """Error against processor time, a line per contestant."""
    made = style.figure(9.5, 5.2)
    axes = made.add_subplot()
    for name, entry in result["contestants"].items():
        found = sorted(entry.get("points", []), key=lambda p: p["seconds"])
        if found:
            colour, marker, line = LOOKS.get(name, (LIGHT.alarm, "x", "-"))
            ms, errors = [1e3 * p["seconds"] for p in found], [p["error"] for p in found]
            axes.loglog(
                ms, errors, color=colour, marker=marker, ls=line, ms=4.5, mfc="white", label=name
            )
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("processor time [ms]")
    axes.set_ylabel("largest error of theta [rad]")
    axes.set_title(f"{result['title']}, {result['until']:g} s")
    made.legend(loc="outside right center")
    return made


def scaling(result: dict[str, Any]) -> Figure:
    """Four panels: span, tops, grid, tolerance."""
    made = style.figure(9.5, 7.0)
    panels = made.subplots(2, 2)
    for axes, name in zip(panels.flat, ("span", "tops", "grid"), strict=False):
        rows = result[name]["rows"]
        for extrapolated, look in ((False, "o-"), (True, "o:")):
            chosen = [r for r in rows if bool(r.get("extrapolated")) == extrapolated]
            if extrapolated and chosen:
                chosen = [rows[len(rows) - len(chosen) - 1], *chosen]
            label = (
                "extrapolated, not run"
                if extrapolated
                else f"measured, exponent {result[name]['exponent']:.2f}"
            )
            sizes, cost = [r["size"] for r in chosen], [r["seconds"] for r in chosen]
            if chosen:
                axes.loglog(
                    sizes,
                    cost,
                    look,
                    color=LIGHT.quiet if extrapolated else LIGHT.run,
                    ms=4,
                    label=label,
                )
        axes.set_xlabel(result[name]["what"])
        axes.set_ylabel("processor time [s]")
        axes.legend(loc="upper left")
    axes = panels.flat[3]
    for precision, colour in (("double", LIGHT.run), ("longdouble", LIGHT.upper)):
        chosen = [r for r in result["tolerance"]["rows"] if r["precision"] == precision]
        label = (
            f"{precision}, exponent of the digits {result['tolerance']['exponents'][precision]:.2f}"
        )
        ms = [1e3 * r["seconds"] for r in chosen]
        axes.loglog([r["tolerance"] for r in chosen], ms, "o-", color=colour, ms=4, label=label)
    axes.set_ylim(top=8 * axes.get_ylim()[1])
    axes.invert_xaxis()
    axes.set_xlabel("tolerance")
    axes.set_ylabel("processor time [ms]")
    axes.legend(loc="upper left")
    for axes, title in zip(
        panels.flat,
        ("heavy top", "ensemble, 10 s", "minimal surface F", "canonical inversion, 8 s"),
        strict=True,
    ):
        axes.set_title(title)
    return made


def startup(result: dict[str, Any]) -> Figure:
    """Where a start goes, cold and warm: one bar each."""
    made = style.figure(9.5, 2.8)
    axes = made.add_subplot()
    stages = list(result["cold"]["stages"])
    colours = [LIGHT.quiet, "#aab3bd", "#cfd5db", LIGHT.lower, LIGHT.upper, LIGHT.run]
    for y, name in enumerate(("warm", "cold")):
        left = 0.0
        for stage, colour in zip(stages, colours, strict=False):
            width = result[name]["stages"][stage]
            axes.barh(y, width, left=left, color=colour, label=stage if y else None)
            left += width
        axes.text(left, y, f"  wall clock {result[name]['wall']:.2f} s", va="center")
    axes.set_xlim(right=1.4 * axes.get_xlim()[1])
    axes.set_yticks([0, 1], ["warm", "cold"])
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("processor time [s]")
    axes.set_title(result["title"].replace("`", ""))
    made.legend(loc="outside right center")
    return made
