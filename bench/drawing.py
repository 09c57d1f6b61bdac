"""The figures of bench/README.md."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from tippetop.figures import style
from tippetop.figures.style import LIGHT


LOOKS = {  # colour, marker, line
    "tippetop, motion alone": (LIGHT.run, "D", "-"),
    "tippetop, equations only": (LIGHT.run, "o", "-"),
    "tippetop, lanes": (LIGHT.run, "o", "-"),
    "tippetop, events on": (LIGHT.run, "s", "--"),
    "tippetop, whole run with rows and orientation": (LIGHT.run, "P", ":"),
    "heyoka by hand": (LIGHT.lower, "o", "-"),
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
                precision(result).savefig(folder / f"{name}.png", dpi=150)


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
