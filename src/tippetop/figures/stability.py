"""The asymptotic states of a tippe top in the plane of lambda and cos(theta): the source's figure 3.3, any body."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .style import LOWER, QUIET, RUN, UPPER, figure


COLOURS = {"upright": LOWER, "tumbling": RUN, "inverted": UPPER}
NAMES = {"upright": "upright spin", "tumbling": "tumbling", "inverted": "inverted spin"}


def phase(branches: list[Any], marks: dict[str, float], path: tuple[np.ndarray, float] | None = None) -> Figure:
    """Branches of asymptotic states, stable ones solid, unstable ones dashed; `marks` are values of lambda that are
    named on the axis; `path` is cos(theta) of a run and its lambda."""
    fig = figure(8.0, 5.2)
    axes = fig.add_subplot()
    for kind, colour in COLOURS.items():
        axes.plot([], [], color=colour, lw=2.6, label=NAMES[kind])
    for branch in branches:
        style: dict[str, Any] = {"lw": 2.6, "ls": "-"} if branch.stable else {"lw": 1.3, "ls": (0, (4, 3))}
        axes.plot(branch.lam * 1e6, branch.z, color=COLOURS[branch.kind], **style, clip_on=False)
    for name, value in marks.items():
        axes.axvline(value * 1e6, color=QUIET, lw=0.8, ls=":")
        axes.annotate(
            name,
            (value * 1e6, 0.1),
            xycoords=("data", "axes fraction"),
            xytext=(3, 0),
            color=QUIET,
            textcoords="offset points",
        )
    if path is not None:
        z, lam = path
        line = np.full(len(z), abs(lam) * 1e6)
        axes.plot(line, z, color=QUIET, lw=4, alpha=0.35, label="this run", solid_capstyle="butt")
        axes.plot(line[[0]], z[[0]], "o", color="black", ms=5, zorder=5, label="its start")
        axes.plot(line[[-1]], z[[-1]], "D", color="black", mfc="white", ms=6, zorder=5, label="its end")
    axes.set_xlabel(r"Jellett's integral $|\lambda|$  [$10^{-6}$ kg m$^3$ s$^{-1}$]")
    axes.set_ylabel(r"$\cos\theta$")
    axes.set_ylim(-1.06, 1.06)
    most = max(float(np.nanmax(b.lam)) for b in branches if b.kind != "tumbling")
    axes.set_xlim(0, most * 1e6)
    axes.set_title("Asymptotic states: solid stable, dashed unstable", pad=10)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return fig
