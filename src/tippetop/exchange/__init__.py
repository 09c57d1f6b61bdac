"""Motions and bodies of other programs: tables to compare and to fit, files for simulators.

- `motion_table.read` reads a table, `motion.motion` converts it to our conventions.
- `comparison.compare` returns the differences of a motion from the exact one.
- `fitting.fit` fits numbers of a scenario to measurements, an `observation.Observation`.
- `simulators.text_of` writes a body for MuJoCo, Gazebo and others.

Predictions are computed by ensembles (`predictions`), for many sets of numbers in one call.
"""
