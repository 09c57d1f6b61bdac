"""Sweeps: many tops of a plan, computed in chunks by several processes, into one store.

- `plan.Plan` is a checked plan; its `design.Design` has the numbers of every top.
- `sweep.sweep(plan, path)` computes the chunks that are not done, and writes them.
- `maps.make_map` returns the fate of the tops over one or two axes.

A `chunk.Task` goes to a worker (`workers`), which runs its tops by `ensembles`, and its columns
come back; only one process writes the store. `sweep_summary` reads it.
"""
