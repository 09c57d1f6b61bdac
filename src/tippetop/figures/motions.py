"""The motion of another program and the reference: theta, differences, conserved quantities.

`Comparison.plot` calls it with `exchange.comparison.Compared`s.
"""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..columns import capitalised
from .labels import MEASURED
from .style import COLOURS, LIGHT, figure, legend, literal, styled


FLOOR = 1e-17  # smaller differences are not drawn


@styled()
def comparison(motions: Sequence[Any], title: str) -> Figure:
    """Draw three panels over time: theta, differences, and relative drifts.

    Parameters
    ----------
    motions
        `exchange.comparison.Compared`s; the second title names the `main` quantity of the last.
    title
        The reference.
    """
    drifts = any(name in m.curves for m in motions for name in ("energy", "jellett"))
    fig = figure(9.0, 8.5 if drifts else 6.5)
    panels: Any = fig.subplots(3 if drifts else 2, 1, sharex=True)
    longest = max(motions, key=lambda m: m.t[-1])
    panels[0].plot(
        longest.t, longest.reference, color=LIGHT.run, lw=2.2, alpha=0.55, label="reference"
    )
    for m, color in zip(motions, itertools.cycle(COLOURS[1:])):
        panels[0].plot(m.t, m.theta, color=color, lw=0.9, label=literal(m.path.stem))
        name = m.main
        for axes, curve, style in (
            (panels[1], name, "-"),
            (panels[1], "theta", ":"),
            (panels[-1], "jellett", "-"),
            (panels[-1], "energy", "--"),
        ):
            sizes = np.abs(m.curves.get(curve, np.nan * m.t))
            shown = np.where((sizes > FLOOR) & ((curve, style) != (name, ":")), sizes, np.nan)
            axes.semilogy(m.t, shown, color=color, ls=style, lw=0.9)
    panels[0].set(ylabel="inclination θ (rad)", title=literal(capitalised(title)))
    dotted = "" if name == "theta" else ", dotted θ alone"
    words, unit = MEASURED.get(name, (name, "rad"))
    panels[1].set(ylabel=f"difference ({unit or 'rad'})", title=f"Error: solid {words}{dotted}")
    if drifts:
        words = "Change less the exact one: solid Jellett's integral λ, dashed energy E"
        panels[2].set(ylabel="relative change", title=words)
    panels[-1].set_xlabel("time t (s)")
    legend(panels[0], "upper right", ncols=4)
    return fig
