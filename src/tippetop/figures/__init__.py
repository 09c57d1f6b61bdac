"""Figures of runs and sweeps in matplotlib. Only `drawing` passes data to drawings.

- `catalogue.FIGURES` lists the kinds of figures, with the columns that each needs.
- `drawing.axes_of(kind, groups, attrs)` draws one in the style of `style`; `write` saves it.
- one module for each kind, such as `theta` or `energetics`, takes Datasets and returns Axes.

Tables of a run (Datasets by name) and its root attributes go in; Axes come out.
"""
