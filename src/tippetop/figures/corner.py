"""Weighted draws of several numbers: the distribution of each, and of each pair.

`Posterior.plot` calls it.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from .style import LIGHT, figure, styled


# Bins of a histogram
BINS = 30
# Standard deviations that a panel shows on either side
SHOWN = 4.0


@styled()
def corner(draws: Mapping[str, np.ndarray], weights: np.ndarray, text: str) -> Figure:
    """Draw the distribution of each number, and of each pair.

    Parameters
    ----------
    draws
        Label of each number -> its values in the n draws, (n,).
    weights
        The weight of each draw, (n,), of sum 1.
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
    limits = []
    for values in draws.values():
        mean = weights @ values
        size = np.sqrt(weights @ (values - mean) ** 2)
        limits.append((mean - SHOWN * size, mean + SHOWN * size))
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
                panel.set_yticks([])
            else:
                count, *edges = np.histogram2d(
                    x, y, BINS, range=(limits[column], limits[row]), weights=weights
                )
                panel.pcolormesh(*edges, count.T, cmap="Blues", rasterized=True)
                panel.set_ylim(limits[row])
            panel.set_xlim(limits[column])
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_formatter("{x:.6g}")
            panel.locator_params(nbins=3)
            panel.tick_params(
                labelbottom=row == n - 1, labelleft=column == 0 < row, labelrotation=30
            )
            if row == n - 1:
                panel.set_xlabel(other)
            if column == 0 < row:
                panel.set_ylabel(label)
    fig.align_labels()
    fig.supxlabel(text, x=0.02, ha="left", fontsize="small")
    return fig
