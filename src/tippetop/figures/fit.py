"""A fit that is read at once: what was measured, the curve that fits, and what is left."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .labels import quantity
from .style import QUIET, RUN, UPPER, dashes, figure, styled


NAMES = {
    "theta": ("inclination θ", "rad"),
    "phi": ("angle φ", "rad"),
    "omega3": ("angular velocity ω₃", "rad s⁻¹"),
    "place": ("place", "m"),
    "marker": ("marker", "m"),
    "axis": ("axis", ""),  # what is left is an angle
    "orientation": ("inclination θ", "rad"),
}
"""Of measurements: what stands at the axis, and the unit."""
PARTS = "xyz"


@styled()
def fit(
    t: np.ndarray,
    measured: dict[str, np.ndarray],
    predicted: tuple[np.ndarray, dict[str, np.ndarray]],
    residuals: dict[str, np.ndarray],
    text: list[str],
) -> Figure:
    """For each kind of measurement: the data and the curve, the residuals and their histogram.

    Parameters
    ----------
    t
        (rows,) [s].
    measured, residuals
        Name -> (rows, parts); NaN in gaps. Of an orientation, the inclination of its axis is shown.
    predicted
        Times [s], (n,), and name -> what is predicted then, as it is shown, (n, parts).
    text
        Lines that stand below: the numbers.
    """
    times, curves = predicted
    fig = figure(9.5, 1.3 + 3.6 * len(measured) + 0.2 * len(text))
    boxes: Any = fig.subplots(
        2 * len(measured),
        2,
        width_ratios=[4, 1],
        height_ratios=[2, 1] * len(measured),
        squeeze=False,
    )
    for k, (name, seen) in enumerate(measured.items()):
        (above, words), (below, counts) = boxes[2 * k], boxes[2 * k + 1]
        off = residuals[name]
        seen_as, unit = NAMES.get(name, (name, ""))
        angle = "rad" if name == "axis" else unit
        colors = (RUN, UPPER, "#6d28d9", "#0f766e")
        for i, curve in enumerate(curves[name].T):
            above.plot(t, seen[:, i], ".", ms=4, color=QUIET, label="measured" if not i else None)
            label = f"fit {PARTS[i]}" if seen.shape[1] > 1 else "fit"
            above.plot(
                times, curve, color=colors[i % len(colors)], ls=dashes(i), lw=0.8, label=label
            )
        for i in range(off.shape[1]):
            color = colors[i % len(colors)]
            below.plot(t, off[:, i], ".", ms=2.5, color=color)
            counts.hist(
                off[np.isfinite(off[:, i]), i],
                bins=30,
                orientation="horizontal",
                color=color,
                alpha=0.6,
            )
        size = float(np.sqrt(np.nanmean(off**2)))
        below.axhspan(-2 * size, 2 * size, color=QUIET, alpha=0.15, lw=0)
        below.set(
            ylabel=_labelled("what is left", angle),
            xlabel="time t (s)",
            ylim=(-4.5 * size, 4.5 * size),
        )
        counts.set(ylim=(-4.5 * size, 4.5 * size), xticks=[], yticklabels=[])
        above.set(ylabel=_labelled(seen_as, unit), xticklabels=[])
        above.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, borderaxespad=0.2)
        words.set_axis_off()
        spread = f"root mean square\nof what is left:\n{quantity(size, angle or '1', 3)}"
        words.text(
            0, 0.5, f"{spread}\n{np.isfinite(off).sum()} numbers", va="center", fontsize="small"
        )
    fig.supxlabel("\n".join(text), x=0.02, ha="left", fontsize="small", family="monospace")
    return fig


def _labelled(words: str, unit: str) -> str:
    return f"{words} ({unit})" if unit else words
