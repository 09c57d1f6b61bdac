"""Systems whose contact may open and close: the phases of their body, and the exits that lead from
one to another."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from operator import itemgetter
from typing import Any

from ..event import Event
from ..form import CLOCK, Exit, Phase
from ..friction import LAWS, PARTS, all_laws, has_parts, is_frictionless
from ..number import Number
from ..operand import formula
from ..system import System
from ..units import METRE, METRE_PER_SECOND
from . import gliding
from .body import BALLS, Touch, seen_from_balls
from .contact_phases import CONE, RESTS, STICK
from .exits import IMPACT, KINDS, PHASES, REASONS, begin, come_to_rest, go_on, phase_name
from .integrals import NAMED, integral
from .rows import (
    ANGLES,
    DISC_ANGLES,
    DISC_ROW,
    PLANAR_ANGLES,
    PLANAR_ROW,
    ROW,
    columns,
    moving,
    planar_theta_dot,
    row,
)


ABOVE = {
    "gap": Number(METRE, "height of the lowest point of the sphere above the plane", least=0),
    "nu_z": Number(
        METRE_PER_SECOND, "vertical velocity of the lowest point of the sphere", symbol=r"\nu_z"
    ),
}
LONG_NAMES = {
    "gap": "height of the lowest point of the ball that touches the plane, or did last",
    "nu_z": "vertical velocity of the lowest point of that ball",
    "nu_x": "horizontal velocity of the lowest point along e; undefined (NaN) exactly at a pole",
    "nu_y": "horizontal velocity of the lowest point along 2hat; undefined (NaN) exactly at a pole",
    "jellett_lost": NAMED["jellett_lost"][1],
}
OCCURRENCES = (
    Event(
        "liftoff",
        "normal force falls to zero: the body flies",
        None,
        -1,
        kept=gliding.LIFTOFF.kept,
    ),
    replace(STICK, formula=None, direction=0, ends=None),
    replace(CONE, formula=None, direction=0, ends=None),
    Event("reversal", "sliding turns back at once where it stops", None),
    Event(
        "impact",
        "a ball strikes the plane: a landing, or one ball takes over from the other",
        None,
    ),
)
"""Events of a run that jumps log."""

SETTLED = Event(
    "settled",
    "friction takes no energy any more, and the body presses on the plane with more than half "
    "of its weight",
    formula(lambda s, b: s.power - 1e-12 * (2 * s.force - b.m * b.g)),
    direction=-1,
    lasting=True,
    kept=gliding.SETTLED.kept,
)
"""An event of runs that stop when they have settled."""

TABLES = {
    "phases": {
        "phase": PHASES,
        "ball": BALLS,
        "reason": REASONS,
    },
    "impacts": IMPACT._asdict(),
}
"""Units or words of the columns of further tables; the place of a word is its number in a store."""


def kind_of(law: Any) -> tuple:
    """Return the attributes of a law that determine the phases of a contact."""
    return law.set_valued, bool(law.regions), law.coefficient is not None, law.torque


def in_plane(phase: Phase) -> Phase:
    """Return a phase that integrates theta too."""
    theta = integral("theta", lambda q, carried, b: planar_theta_dot(q, b))
    integrals, turn = (theta, *phase.form.integrals), PLANAR_ROW.orientation
    return replace(phase, forms=replace(phase.form, integrals=integrals, orientation=turn))


# --- phases and exits ---------------------------------------------------------------------------


def phases_of(planar: bool, law: Any, balls: int) -> dict[str, Phase]:
    """Return the phases of a body under a law, by name."""
    bare: dict[str, Bare] = {}
    for label, kind in KINDS.items():
        for regions, phase in kind.phases(law).items():
            named = replace(in_plane(phase) if planar else phase, label=label)
            for ball in range(balls + 1 - kind.balls):
                bare[phase_name(label, ball, *regions)] = named, ball, regions
    return {name: with_exits(name, bare, law) for name in bare}


Bare = tuple[Phase, int, tuple[str, ...]]
"""A phase without exits, its ball, and the regions of the law on each ball in contact."""


def with_exits(name: str, bare: dict[str, Bare], law: Any) -> Phase:
    """Return a phase as its body and its law have it."""
    phase, ball, regions = bare[name]
    jumps: Any = {RESTS.name: partial(come_to_rest, slides=name), **KINDS[phase.label].jumps}
    for at, region in enumerate(regions if law.regions.keys() >= {*regions} else ()):
        for border in law.regions[region].borders:
            to = phase_name(phase.label, ball, *regions[:at], border.follows, *regions[at + 1 :])
            stays = border.direction if border.follows == region else 0
            of_ball = "stem-" * at
            jumps[of_ball + border.event] = partial(
                go_on, to=to, passed=of_ball + border.back, side=stays
            )
    names = [event.name for event in phase.events] + [CLOCK] * (CLOCK in jumps)
    exits = tuple(Exit(one, tuple(bare), jumps[one]) for one in names)
    form = replace(phase.form, not_normalised=("R", "c"))
    return replace(phase, forms=form, exits=exits, parameters=itemgetter(ball), ball=ball)


# --- systems ------------------------------------------------------------------------------------


@cache
def opened(system: System, law: Any, balls: int) -> System:
    """Return a system whose contact may open, of one that slides; the same one for a law's record.

    Parameters
    ----------
    system
        Has an `opening`.
    law
        The friction law.
    balls
        1, or 2 of a body with a stem.
    """
    opening: Any = system.opening
    angles: Any = DISC_ANGLES if law.torque else PLANAR_ANGLES if opening.planar else ANGLES
    form = PLANAR_ROW if opening.planar else DISC_ROW if law.torque else ROW
    of_axis = tuple(one for one in system.events if not one.lasting and one.ends != "liftoff")
    quantities = columns(opening.planar, opening.routh, balls > 1)
    known = {*opening.without, *(quantity.name for quantity in quantities)}
    quantities += tuple(one for one in system.quantities if one.name not in known)
    phases = {  # events of the axis, by the few scalars of a phase if these are enough
        name: phase
        if phase.axis_stays or opening.planar
        else replace(phase, events=(*of_axis, *phase.events))
        for name, phase in phases_of(opening.planar, law, balls).items()
    }

    def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
        e = system.start(data, s, z, b)
        return type(angles)(*(getattr(e, n, data.get(n, 0)) for n in angles._fields))

    def assembled(b: Touch, rules: Any, internal: Callable) -> tuple[Any, Mapping[str, Phase]]:
        """Return the body seen from each of its balls and the phases.

        internal(value, unit) converts SI values.
        """
        stem = (internal(rules.r, METRE), internal(rules.h, METRE)) if rules.stem else ()
        of_disc = bool(law.regions) and not is_frictionless(b.friction)
        if not (law.set_valued or law.regions) or b.friction.mu != 0 or of_disc:
            return seen_from_balls(b, stem), phases
        none = LAWS["none"].given(PARTS if has_parts(b.friction) else ())
        free = none._make(getattr(b.friction, name) for name in none.parameters)
        seen = seen_from_balls(b._replace(friction=free), stem)
        return seen, opened(system, none, balls).phases

    return replace(
        system,
        title=f"{system.title}, which may slip, roll and fly",
        phases=phases,
        common=Phase({form.name: form}, quantities, (*of_axis, *OCCURRENCES), leave=moving),
        assembled=assembled,
        begin=begin,
        read=row,
        tables=TABLES,
        laws={name: one for name, one in all_laws(system.laws) if kind_of(one) == kind_of(law)},
        initial=system.initial | ABOVE,
        start=start,
        angles=angles,
        long_names=system.long_names | LONG_NAMES,
        integrals=() if opening.planar else ("jellett",),
        landscape=None,
        potential=None,
        outlook=opening.outlook,
        borders=None,
        motion=None,
        contact=(law, balls),
    )
