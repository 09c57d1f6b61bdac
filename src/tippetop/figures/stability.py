"""The asymptotic states of a tippe top over lambda, as figure 3.3 of the source, for any body.

Branches of `theory.tumbling` go in, Axes come out.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .style import compact, ink, legend, mark_ends, panel


LARGEST = 1e6  # lambda is shown in 10^-6 kg m^3/s


def states(
    branches: list[Any],
    marks: dict[str, float],
    title: str = "",
    path: tuple[np.ndarray, np.ndarray] | None = None,
) -> Axes:
    """Draw branches of asymptotic states: cos(theta) over lambda, stable solid, unstable dashed.

    `branches` and `marks`, named values of lambda, are those of `run_landscape.diagram`; `path` is
    cos(theta) of a run and its lambda, NaN while the run is not on its sphere.
    """
    colours = ink()
    ax = panel(8.4, 5.4)
    for kind, label, color in (
        ("upright", "upright spin", colours.lower),
        ("tumbling", "tumbling", colours.run),
        ("inverted", "inverted spin", colours.upper),
    ):
        for branch in branches:
            if branch.kind == kind:
                style = {"lw": 2.6} if branch.stable else {"lw": 1.3, "ls": (0, (4, 3))}
                ax.plot(branch.lam * LARGEST, branch.z, color=color, label=label, **style)
    most = max(float(np.nanmax(b.lam)) for b in branches if b.kind != "tumbling") * LARGEST
    for name, value in marks.items():
        ax.axvline(value * LARGEST, color=colours.quiet, lw=0.8, ls=":")
        ax.annotate(
            name,
            (value * LARGEST, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            color=colours.quiet,
            textcoords="offset points",
            ha="center",
        )
    if path is not None:
        z = path[0]
        lam = np.abs(path[1]) * LARGEST
        ax.plot(
            lam, z, color=colours.quiet, lw=4, alpha=0.4, label="this run", solid_capstyle="butt"
        )
        mark_ends(ax, lam, z)
    words = "Jellett's integral |λ| (10⁻⁶ kg m³ s⁻¹)"
    ax.set(xlabel=words, ylabel="cos θ", xlim=(0, most), ylim=(-1.06, 1.06))
    heading = "Asymptotic states: solid stable, dashed unstable"
    ax.set_title(
        f"{title}\n{heading}" if title and not compact() else heading, pad=16 if marks else 6
    )
    legend(ax, "lower center", ncols=5)
    return ax
