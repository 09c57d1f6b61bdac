"""The asymptotic states of a tippe top in the plane of lambda and cos(theta): the source's figure
3.3, any body.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .labels import end_of
from .style import compact, ink, legend, mark_ends, panel


NAMES = {"upright": "upright spin", "tumbling": "tumbling", "inverted": "inverted spin"}
LARGEST = 1e6  # of the axis of lambda: 10^-6 kg m^3/s


def states(
    branches: list[Any],
    marks: dict[str, float],
    title: str = "",
    path: tuple[np.ndarray, np.ndarray] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Branches of asymptotic states, stable ones solid, unstable ones dashed; `marks` are values of
    lambda that are named on the axis; `path` is cos(theta) of a run and its lambda.
    """
    ink_ = ink()
    ax = panel(ax, 8.4, 5.4)
    colours = {"upright": ink_.lower, "tumbling": ink_.run, "inverted": ink_.upper}
    for kind in (name for name in NAMES if any(branch.kind == name for branch in branches)):
        ax.plot([], [], color=colours[kind], lw=2.6, label=NAMES[kind])
    for branch in branches:
        style: dict[str, Any] = (
            {"lw": 2.6, "ls": "-"} if branch.stable else {"lw": 1.3, "ls": (0, (4, 3))}
        )
        ax.plot(branch.lam * LARGEST, branch.z, color=colours[branch.kind], **style)
    most = max(float(np.nanmax(b.lam)) for b in branches if b.kind != "tumbling") * LARGEST
    for name, value in marks.items():
        ax.axvline(value * LARGEST, color=ink_.quiet, lw=0.8, ls=":")
        ax.annotate(
            name,
            (value * LARGEST, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            color=ink_.quiet,
            textcoords="offset points",
            ha="center",
        )
    if path is not None:
        z, lam = path[0], np.abs(path[1]) * LARGEST
        ax.plot(lam, z, color=ink_.quiet, lw=4, alpha=0.4, label="this run", solid_capstyle="butt")
        mark_ends(ax, lam, z, last=end_of(z), sizes=(8, 5))
    ax.set_xlabel("Jellett's integral |λ| (10⁻⁶ kg m³ s⁻¹)")
    ax.set_ylabel("cos θ")
    ax.set_ylim(-1.06, 1.06)
    ax.set_xlim(0, most)
    heading = "Asymptotic states: solid stable, dashed unstable"
    ax.set_title(
        f"{title}\n{heading}" if title and not compact() else heading, pad=16 if marks else 6
    )
    legend(ax, "lower center" if compact() else "right center", ncols=3 if compact() else 1)
    return ax
