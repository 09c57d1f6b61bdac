"""Measurements with the fitted curves and their residuals.

`Fitted.plot` calls it.
"""

from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .style import COLOURS, LIGHT, draw_curves, figure, styled


NAMES = {
    "theta": ("inclination θ", "rad"),
    "phi": ("angle φ", "rad"),
    "omega3": ("angular velocity ω₃", "rad s⁻¹"),
    "omega": ("angular velocity", "rad s⁻¹"),
    "gyroscope": ("gyroscope", "rad s⁻¹"),
    "accelerometer": ("accelerometer", "m s⁻²"),
    "place": ("place", "m"),
    "marker": ("marker", "m"),
    "axis": ("axis", ""),  # its residual is an angle
    "orientation": ("inclination θ", "rad"),
}
"""Label and unit of each kind of measurement."""
PARTS = "xyz"
# Characters in a line of text below the panels
WIDTH = 115


@styled()
def fit(
    t: np.ndarray,
    measured: dict[str, np.ndarray],
    predicted: tuple[np.ndarray, dict[str, np.ndarray]],
    residuals: dict[str, np.ndarray],
    text: list[str],
) -> Figure:
    """Draw measurements with the fitted curves, and residuals with two standard deviations.

    Parameters
    ----------
    t
        (rows,) [s].
    measured, residuals
        Name -> (rows, parts); NaN in gaps. Of an orientation, the inclination of its axis is shown.
    predicted
        Times [s], (n,), and name -> predictions at these times, (n, parts).
    text
        Lines below the panels.
    """
    times, curves = predicted
    text = [part for line in text for part in wrap(line, WIDTH, subsequent_indent="  ")]
    fig = figure(9.5, 1.3 + 3.6 * len(measured) + 0.2 * len(text))
    panels: Any = fig.subplots(2 * len(measured), sharex=True, height_ratios=[2, 1] * len(measured))
    for above, below, (name, seen) in zip(panels[::2], panels[1::2], measured.items(), strict=True):
        off = residuals[name]
        words, unit = NAMES.get(name, (name, "rad"))
        dots, *_ = above.plot(t, seen, ".", ms=4, color=LIGHT.quiet)
        dots.set_label("measured")
        parts = [f"fit {part}" for part in PARTS] if seen.shape[1] > 1 else ["fit"]
        fitted = zip(parts, curves[name].T, strict=False)
        draw_curves(above, [(label, times, curve) for label, curve in fitted])
        for part, color in zip(off.T, COLOURS, strict=False):
            below.plot(t, part, ".", ms=2.5, color=color)
        size = float(np.sqrt(np.nanmean(off**2)))
        below.axhspan(-2 * size, 2 * size, color=LIGHT.quiet, alpha=0.15, lw=0)
        below.set(ylabel=f"residual ({unit or 'rad'})", ylim=(-4.5 * size, 4.5 * size))
        above.set_ylabel(f"{words} ({unit})" if unit else words)
        above.legend(ncols=4, loc="lower left", bbox_to_anchor=(0, 1))
    panels[-1].set_xlabel("time t (s)")
    fig.supxlabel("\n".join(text), x=0.02, ha="left", fontsize="small", family="monospace")
    return fig
