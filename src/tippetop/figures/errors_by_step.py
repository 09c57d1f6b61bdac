"""The results of engines on one case: error against step, and theta with the reference.

`tippetop benchmark score` calls it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .style import COLOURS, DASHES, LIGHT, figure, legend, styled


EXACT = 1e-16
"""Errors below this are drawn as this."""

UPRIGHT = 1e-3
"""Least range of theta that is drawn [rad]; the height is drawn where no motion leaves it."""


@styled()
def errors_by_step(title: str, results: Sequence[Any]) -> Figure:
    """Draw the results of one case; errors of positions and heights if it only moves upright.

    Parameters
    ----------
    title
        The case.
    results
        `benchmark.score.Result`s of the case, by engine and setting, the largest step first: the
        last one of each setting is drawn over time.
    """
    fig = figure(10, 4.8)
    left, right = fig.subplots(1, 2)
    tilts = any(np.max([r.compared.theta, r.compared.reference]) > UPRIGHT for r in results)
    upright = not tilts and all(np.isfinite(r.heights[0]).all() for r in results)
    moved, unit = ("position", "m") if upright else ("attitude", "rad")
    by_setting: dict[str, list[Any]] = {}
    for result in results:
        by_setting.setdefault(f"{result.engine} {result.setting}", []).append(result)
    for k, (label, group) in enumerate(by_setting.items()):
        stepped = [r.compared for r in group if r.compared.step and moved in r.compared.numbers]
        errors = [max(c.numbers[moved]["max"], EXACT) for c in stepped]
        look = {"color": COLOURS[k % len(COLOURS)], "ls": DASHES[k % len(DASHES)], "label": label}
        left.loglog([c.step for c in stepped], errors, marker="o", **look)
        c = group[-1].compared
        right.plot(c.t, group[-1].heights[0] if upright else c.theta, **look)
    last = max((group[-1] for group in by_setting.values()), key=lambda r: r.compared.t[-1])
    exact = last.heights[1] if upright else last.compared.reference
    reference = {"color": LIGHT.run, "lw": 1.6, "zorder": 0, "label": "reference"}
    right.plot(last.compared.t, exact, **reference)
    left.set(xlabel="step [s]", ylabel=f"largest error of {moved} [{unit}]")
    right.set(
        xlabel="t [s]", ylabel="height of the centre of mass [m]" if upright else "theta [rad]"
    )
    low, high = right.get_ylim()
    if high - low < UPRIGHT:
        right.set_ylim(low - UPRIGHT, high + UPRIGHT)
    fig.suptitle(title)
    legend(right, "lower center", ncols=4)
    return fig
