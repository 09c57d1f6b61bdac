"""Weighted draws of several numbers: the distribution of each, and of each pair.

`Posterior.plot` calls it.
"""

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.figure import Figure

from .style import LIGHT, figure, styled


# Bins of a histogram
BINS = 30
# Standard deviations that a panel shows on either side
SHOWN = 4.0


@styled()
def corner(
    draws: Mapping[str, np.ndarray],
    weights: np.ndarray,
    moments: Iterable[tuple[float, float]],
    text: str,
) -> Figure:
    """Draw the distribution of each number, and of each pair.

    Parameters
    ----------
    draws
        Label of each number -> its values in the n draws, (n,).
    weights
        The weight of each draw, (n,), of sum 1.
    moments
        Mean and standard deviation of each number.
    text
        A line below the panels.

    Returns
    -------
    Figure
        With k x k panels for k numbers: histograms on the diagonal, densities of pairs below it.
    """
    n = len(draws)
    fig = figure(1.5 + 2.1 * n, 1.5 + 2.1 * n)
    panels = fig.subplots(n, n, squeeze=False)
    limits = [(mean - SHOWN * size, mean + SHOWN * size) for mean, size in moments]
    columns = list(draws.items())
    for row, (label, y) in enumerate(columns):
        for column, (other, x) in enumerate(columns):
            panel = panels[row, column]
            if column > row:
                panel.set_visible(False)
                continue
            if row == column:
                panel.hist(
                    x, BINS, range=limits[column], weights=weights, color=LIGHT.run, alpha=0.8
                )
                panel.set(xlim=limits[column], xlabel=other, yticks=[])
            else:
                shown = limits[column], limits[row]
                panel.hist2d(
                    x, y, BINS, range=shown, weights=weights, cmap="Blues", rasterized=True
                )
                panel.set(xlabel=other, ylabel=label)
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_formatter("{x:.6g}")
            panel.locator_params(nbins=3)
            panel.tick_params(labelrotation=30)
            panel.label_outer()
    fig.align_labels()
    fig.supxlabel(text, x=0.02, ha="left", fontsize="small")
    return fig
