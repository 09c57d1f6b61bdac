"""Bodies that touch a plane: equations, and the jumps between phases of their contact.

- `body.Touch` is the body `b` of formulas, `body.Moving` the common state `x` of all phases.
- `gliding`, `rolling`, `framed` contain forms, events and columns of one phase.
- `contact_phases.phases_under(law)` makes all phases of a contact, `exits` the jumps between them.

`opening.opened(system, law, balls)` joins them to a system that slips, rolls, flies and lands.
Forces follow from `response`, impacts from `impact_motion`. Bodies with an outline (`outlined`) and
in surroundings (`surrounded`) have the same formulas, whose argument b is changed first.

Functions marked `@formula` may be called in functions that numba compiles (`operand.formula`).
Those of phases, rows, jumps, surroundings and bodies without an axis are not marked: no such
function calls them.
"""
