"""Derivatives of runs by their numbers, and the growth of small errors.

- `through.Pass` repeats a run with derivatives, through every change of its contact.
- `sensitivities.differentiate` returns derivatives of all columns, and of times of events.

A `Problem` and names of its numbers go in. Within a phase the variational equations are integrated;
between phases formulas and jumps are called with dual numbers, and recorded once as programs of
columns.
"""
