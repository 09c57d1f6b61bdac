"""Integrate many tops of one scenario, with one row of results each.

- `ensemble.measure(tops)` integrates all tops of a `Problems` on several threads.
- `lanes.run_tops` is the work of one thread: tops of a queue go through `engine.pools.Pools`.
- `outcomes.Outcomes` contains the results, as arrays with one element for each top.

`ensemble.vary` makes the `Problems` from a scenario and arrays of numbers. Tops that lanes cannot
follow run one after the other, each as a run of its own (`hybrid_tops`). `outcomes.dataset` returns
the results as an xarray Dataset in SI units.
"""
