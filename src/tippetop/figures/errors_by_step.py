"""The results of engines on one case: error against step, and theta with the reference."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from .style import COLOURS, DASHES, LIGHT, figure, legend, styled


EXACT = 1e-16
"""Errors below this are drawn as this."""

UPRIGHT = 1e-3
"""Least range of theta that is drawn [rad]."""


@styled()
def errors_by_step(title: str, results: Sequence[Any]) -> Figure:
    """Draw the results of one case; the errors of positions if no attitude differs.

    Parameters
    ----------
    title
        The case.
    results
        Each has `engine`, `setting`, `compared`, by engine and setting; the largest step first.
    """
    fig = figure(10, 4.8)
    left, right = fig.subplots(1, 2)
    turned = any(result.compared.numbers["attitude"]["max"] for result in results)
    moved, unit = ("attitude", "rad") if turned else ("position", "m")
    by_setting: dict[str, list[Any]] = {}
    for result in results:
        by_setting.setdefault(f"{result.engine} {result.setting}", []).append(result.compared)
    for k, (label, compared) in enumerate(by_setting.items()):
        stepped = [c for c in compared if c.step and moved in c.numbers]
        errors = [max(c.numbers[moved]["max"], EXACT) for c in stepped]
        look = {"color": COLOURS[k % len(COLOURS)], "ls": DASHES[k % len(DASHES)], "label": label}
        left.loglog([c.step for c in stepped], errors, marker="o", **look)
        right.plot(compared[-1].t, compared[-1].theta, **look)
    last = max((group[-1] for group in by_setting.values()), key=lambda c: c.t[-1])
    reference = {"color": LIGHT.run, "lw": 1.6, "zorder": 0, "label": "reference"}
    right.plot(last.t, last.reference, **reference)
    left.set(xlabel="step [s]", ylabel=f"largest error of {moved} [{unit}]")
    right.set(xlabel="t [s]", ylabel="theta [rad]")
    if max(map(abs, right.get_ylim())) < UPRIGHT:
        right.set_ylim(-UPRIGHT, UPRIGHT)
    fig.suptitle(title)
    legend(right, "lower center", ncols=4)
    return fig
