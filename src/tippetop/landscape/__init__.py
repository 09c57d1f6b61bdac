"""The effective potential V of tippe tops and heavy tops, and its minimum F over the inclination.

- `landscape_body.Top` is a body with the coefficients of its potential.
- `formulas` contains V and its slopes in a variable q that is exact at both poles.
- `surface`, `potential`, `turning` and `marked_lines` return labelled Datasets over grids.

Momenta (D, lambda) or (L3, Lz) go in; kernels of numba (`kernels`) find the minimum and the turning
angles at each point. `run_landscape` makes the data of figures from a stored run.
"""
