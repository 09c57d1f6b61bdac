"""Compiled loops over numbers. Nothing of tippetop is imported here.

- `loop.c` makes the steps of runs and finds their events; `tippetop.engine.loop` calls it.
- `grid.minima` and `grid.turnings` compile numba kernels for given formulas: the minimum of a
  function over a grid of points, and the crossings of a level around it.
- `compilation.Entry` is a kernel that Python calls, with its machine code kept on disk.

All arrays are allocated by the caller. Kernels take formulas as functions of opaque records.
"""
