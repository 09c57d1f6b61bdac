"""Scenarios: tables of TOML become a checked `Problem`, or sentences on all that is wrong with
them.

- `reading.read` returns the tables of a file or a preset; `reading.override` changes them.
- `schema.scenario_model` is the model of the tables that a system and a law allow.
- `build.problem(tables)` checks tables, and returns the `Problem` that is integrated.

`build.resolved` returns the tables with all defaults, which a store keeps, and `build.stored` makes
the same problem of them. `scenario_reference` and `template` explain the keys to users.
"""
