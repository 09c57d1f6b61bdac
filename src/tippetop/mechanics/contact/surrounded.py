"""Systems in surroundings: air, and a plane that is tilted, vibrates or turns.

A system goes in, and comes out with a body in surroundings, without the theory of a level plane at
rest, and in rolling with further integrals. Where the equations depend on an integral of the run
(time on a shaker, place on a turntable), the state ends with a copy of it: see `present_body`.

Symbols
    around    names of the groups of surroundings, see `surroundings.GROUPS`
    q         the state of a form; carried: the record of integrals; e: record of angles
    b         the body; b.around: its record of surroundings
    x         the common state, a `body.Moving`
    s         in (s, b): record of scalars; in (e, s, z, b): sin(theta), and z: cos(theta)
"""

from dataclasses import replace
from functools import cache
from typing import Any

from ..system import Outlook, System
from ..units import JELLETT, JOULE
from .body import AXIS, FRAME, filled
from .contact_phases import without_slip
from .framed import OF_ROW
from .gliding import start_of
from .present_body import form_by_states
from .rows import (
    ENERGY,
    FRICTION_NEEDED,
    HORIZONTAL,
    LIFTOFF,
    MODIFIED_ENERGY,
    NORMAL_FORCE,
    ROW,
    form_of,
)
from .surroundings import rules_of, surrounded_body


NO_OUTLOOK = "theory is that of a level plane at rest in still air: it predicts nothing here"


NO_THEORY: dict[str, Any] = dict.fromkeys(("landscape", "potential", "borders", "motion"))
"""Fields of a System that are for a body that always touches a level plane at rest."""

LOSSES = {
    "work": "energy taken by friction and surroundings since the start",
    "jellett_lost": "Jellett's integral taken by torques since the start",
}
"""Words for the integrals that surroundings change."""


def disturbed(b: Any, start: Any, rules: Any = None) -> Outlook:
    """Return no predictions: the theory of the package does not apply in surroundings.

    It has the arguments of `System.outlook`, and `rules`, the third one of `Opening.outlook`.
    """
    return Outlook(NO_OUTLOOK)


def in_surroundings(system: System, around: tuple[str, ...]) -> System:
    """Return a system whose body is in surroundings of these groups, without its theory."""
    rules = rules_of(around)
    units = {key: rule.unit for key, rule in rules.items()}
    # the units of the surroundings are in place of the parameters, which the units of b do not need
    body_units = surrounded_body(lambda parameters, friction: system.body_units(friction))
    return replace(
        system,
        body=surrounded_body(system.body),
        body_units=lambda friction: body_units(units, friction),
        surroundings=rules,
        momenta=(),
        outlook=disturbed,
        **NO_THEORY,
    )


def rolls(system: System) -> bool:
    """Return whether a system is that of a body in space in pure rolling.

    `surrounded_rolling` takes such a system only.
    """
    return [*system.phases] == ["roll"] and bool(system.vectors)


CHANGED = {
    one.name: one.formula
    for one in (ENERGY, MODIFIED_ENERGY, NORMAL_FORCE, HORIZONTAL, FRICTION_NEEDED, LIFTOFF)
}
"""Formulas of the scalars of rows, by name."""


@cache
def surrounded_rolling(system: System, around: tuple[str, ...]) -> System:
    """Return a system in pure rolling, in surroundings of these groups.

    Equal arguments return the same object: systems are keys of other caches.
    """
    form = system.forms["vector"]
    angles = filled(**system.angles._asdict(), work=JOULE)
    start = system.start
    lies: tuple[str, ...] = FRAME
    of_rows = OF_ROW
    if "ix" not in form.units._fields:
        angles = filled(**angles._asdict(), jellett_lost=JELLETT)
        start = start_of(angles)
        lies = AXIS
        of_rows = ROW
    known = form_of(without_slip((), lies=lies), "roll", angles, of_rows)

    def changed(records: Any) -> Any:
        """Return records of quantities or events, those named in CHANGED with its formulas."""
        return tuple(replace(one, formula=CHANGED.get(one.name, one.formula)) for one in records)

    return in_surroundings(system, around).replace(
        forms={"vector": replace(form_by_states(known, around), domains=form.domains)},
        quantities=changed(system.quantities),
        events=changed(system.events),
        angles=angles,
        start=start,
        long_names=system.long_names | LOSSES,
        integrals=tuple(name for name in system.integrals if name == "jellett"),
    )
