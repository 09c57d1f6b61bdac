"""The results of engines on one case: error against step, and theta with the reference.

Where no attitude differs from that of the reference, the error is that of the position.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from . import style


EXACT = 1e-16
"""Errors below this are drawn as this."""

UPRIGHT = 1e-3
"""Least range of theta that is drawn [rad]."""


def errors_by_step(title: str, results: Sequence[Any]) -> Figure:
    """Draw the results of one case.

    Parameters
    ----------
    title
        The case.
    results
        Each has `engine`, `setting`, `compared`, by engine and setting; the largest step first.
    """
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    turned = any(result.compared.numbers["attitude"]["max"] for result in results)
    moved, unit = ("attitude", "rad") if turned else ("position", "m")
    by_setting: dict[str, list[Any]] = {}
    for result in results:
        by_setting.setdefault(f"{result.engine} {result.setting}", []).append(result.compared)
    for k, (label, compared) in enumerate(by_setting.items()):
        stepped = [c for c in compared if c.step and moved in c.numbers]
        errors = [max(c.numbers[moved]["max"], EXACT) for c in stepped]
        look = {"color": f"C{k % 10}", "ls": ("-", "--", ":")[k // 10 % 3], "label": label}
        left.plot([c.step for c in stepped], errors, marker="o", **look)
        finest = compared[-1]
        right.plot(finest.t, finest.theta, lw=1, **look)
    last = max((c for group in by_setting.values() for c in group), key=lambda c: c.t[-1])
    right.plot(last.t, last.reference, color=style.RUN, lw=1.6, zorder=0, label="reference")
    steps = sorted({c.step for group in by_setting.values() for c in group if c.step})
    if steps:
        left.set(xscale="log", yscale="log", xlabel="step [s]")
        left.set_ylabel(f"largest error of {moved} [{unit}]")
        low, high = np.log10(left.get_ylim())
        left.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
        left.set_xticks(steps, [f"{step:g}" for step in steps], rotation=45)
        for axis in (left.xaxis, left.yaxis):
            axis.set_minor_formatter(NullFormatter())
    else:
        left.set_axis_off()
        left.text(0.5, 0.5, "no file name contains dt=STEP", ha="center")
    right.set(xlabel="t [s]", ylabel="theta [rad]")
    if max(map(abs, right.get_ylim())) < UPRIGHT:
        right.set_ylim(-UPRIGHT, UPRIGHT)
    figure.suptitle(title)
    figure.legend(*right.get_legend_handles_labels(), loc="outside right upper", fontsize="small")
    return figure
