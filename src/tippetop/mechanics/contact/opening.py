"""Systems whose contact may open and close: their phases, and the exits that lead between them.

`opened(system, law, balls, around)` is the entrance: it returns the system of a gliding body with
phases of slip, rolling, flight and contact of both balls. `phases_of` joins equations and events
(`contact_phases`) with jumps (`exits`); rows and columns come from `rows` or `framed`.
`scenario.contact` calls it where a scenario has [contact] or [stem], or a law that can stick.

Symbols
    opening   the record `Opening` of a system: `planar`, `outlined`, `framed` tell its kind apart
    law       a friction law, as the type of its record
    around    the names of the groups of surroundings, () without any
    x, world  the arguments of a jump; q: the state of a phase; b: the body, a `Touch`
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from operator import itemgetter
from typing import Any

import numpy as np

from ..event import Event
from ..form import CLOCK, STALL, Exit, Form, Phase
from ..friction import LAWS, PARTS, all_laws, has_parts
from ..number import Number
from ..operand import formula
from ..system import System
from ..units import METRE, METRE_PER_SECOND
from . import gliding
from .body import AXIS, BALLS, FRAME, Touch, seen_from_balls
from .contact_phases import CONE, PHASES, RESTS, STICK, moving, phase_name, phases_under
from .exits import IMPACT, JUMPS, REASONS, begin, go_on, slide_on
from .integrals import NAMED, integral
from .present_body import added_integrals, jump_by_states, phase_by_states
from .rows import (
    ANGLES,
    DISC_ANGLES,
    DISC_ROW,
    PLACE_COLUMNS,
    PLANAR_ANGLES,
    PLANAR_ROW,
    ROW,
    columns,
    planar_theta_dot,
    row,
)
from .surrounded import LOSSES, NO_THEORY, disturbed, in_surroundings


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
        direction=-1,
        kept=gliding.LIFTOFF.kept,
    ),
    Event(STICK.name, STICK.long_name),
    Event(CONE.name, CONE.long_name),
    Event("reversal", "sliding turns back at once where it stops"),
    Event("impact", "a ball strikes the plane: a landing, or one ball takes over from the other"),
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
"""Units or words of the columns of further tables; the position of a word is its number in a
store."""


def kind_of(law: Any) -> tuple:
    """Return the attributes of a law that determine its phases.

    Laws with equal ones can replace one another in a system with phases. All are falsy for a law
    that cannot be used there, which callers test by `any`.
    """
    return law.set_valued, bool(law.regions), law.coefficient is not None, law.torque


def in_plane(form: Form) -> Form:
    """Return a form for a motion in a plane: theta is an integral too, and beta' = 0.

    `rows.PLANAR_ROW`, the form of its rows, has this integral and orientation too.
    """
    theta = integral("theta", lambda q, carried, b: planar_theta_dot(q, b))

    def rates(q: Any, b: Any) -> Any:
        """Return the rates of a state q, with beta' = 0 where it has a direction beta of slip."""
        return form.rates(q, b)._replace(**{one: 0 * q.w for one in q._fields if one == "beta"})

    integrals = theta, *form.integrals
    return replace(form, rates=rates, integrals=integrals, orientation=PLANAR_ROW.orientation)


# --- phases and exits ---------------------------------------------------------------------------


def phases_of(
    opening: Any, law: Any, balls: int, of_axis: tuple[Event, ...], around: tuple[str, ...]
) -> dict[str, Phase]:
    """Return the phases of a body under a law, by name, with their events and exits.

    Parameters
    ----------
    opening
        The `Opening` of the system.
    law
        The friction law.
    balls
        The number of balls that can touch.
    of_axis
        Events that every phase has in which the axis moves; () if they need the scalars of rows.
    around
        The groups of surroundings.
    """
    known = phases_under(law, FRAME if opening.framed else AXIS, bool(around))
    kinds = {
        phase_name(label, ball, *regions): (phase_by_states(phase, around), label, ball, regions)
        for (label, *regions), phase in known.items()
        for ball in range(balls - (label == "both"))  # "both" once, seen from the sphere
    }
    phases = {}
    for name, (phase, label, ball, regions) in kinds.items():
        ways = passages(label, ball, regions, law)
        jumps: dict[str, Callable] = {
            **JUMPS,
            RESTS.name: partial(go_on, to=name, passed=RESTS.name),
            **ways,
        }
        names = [*(event.name for event in phase.events), CLOCK]
        if label == "slip" and law.set_valued:
            names.append(STALL)
            jumps |= dict.fromkeys((CLOCK, STALL), slide_on)
        # the gap of these bodies is no polynomial of the state; R and c are not 1 in internal units
        gaps = ("land",) if opening.framed or opening.outlined else ()
        form = replace(phase.form, not_normalised=("R", "c"), resolved=gaps)
        phases[name] = replace(
            phase,
            forms=in_plane(form) if opening.planar else form,
            events=phase.events if phase.axis_stays else (*of_axis, *phase.events),
            exits=tuple(
                Exit(n, tuple(kinds), jump_by_states(jumps[n]), smooth=n in ways) for n in names
            ),
            parameters=itemgetter(ball),
            label=label,
            ball=ball,
        )
    return phases


def passages(label: str, ball: int, regions: list[str], law: Any) -> dict[str, Callable]:
    """Return the jumps from a phase to those in the next regions of the law, by event.

    The phase has this label and ball, and one of `regions` for each ball in contact. Events have
    the names that `contact_phases.border` makes; "roll" of both balls is not a region.
    """
    return {
        phase_name(way.event, at): partial(
            go_on,
            to=phase_name(label, ball, *regions[:at], way.follows, *regions[at + 1 :]),
            passed=phase_name(way.back, at),
        )
        for at, region in enumerate(regions)
        if region in law.regions
        for way in law.regions[region].borders
    }


# --- systems ------------------------------------------------------------------------------------


@cache
def opened(system: System, law: Any, balls: int, around: tuple[str, ...] = ()) -> System:
    """Return a gliding system with a contact that may open: it slips, rolls, flies and lands.

    Equal arguments return the same object: systems are keys of other caches, and are compared and
    pickled by identity. The engine reads `phases`, `common`, `read`, `begin` and `assembled`;
    `contact`, the arguments of this function, is how a pickle finds the system again, and is not
    None exactly where the contact may open. `landscape`, `potential`, `borders` and `motion` become
    None, because they hold for a body that always touches the plane with one ball.

    Parameters
    ----------
    system
        Has an `opening`.
    law
        The friction law, a class.
    balls
        1, or 2 of a body with a stem.
    around
        The names of the groups of its surroundings; see `surroundings`.
    """
    opening: Any = system.opening
    rows: tuple = ANGLES, ROW
    if opening.planar:
        rows = PLANAR_ANGLES, PLANAR_ROW
    elif law.torque or around:
        rows = DISC_ANGLES, DISC_ROW
    angles, form = opening.framed or rows
    form = replace(
        form, domains=opening.domains, integrals=(*form.integrals, *added_integrals(around))
    )
    of_axis = tuple(one for one in system.events if not one.lasting and one.ends != "liftoff")
    jellett = not (opening.planar or opening.outlined or opening.framed)
    quantities = columns(jellett, opening.routh, balls > 1)
    if opening.framed:
        quantities = PLACE_COLUMNS
    known = {*opening.without, *(quantity.name for quantity in quantities)}
    quantities += tuple(one for one in system.quantities if one.name not in known)
    # events of the axis by the few scalars of a phase, if these are enough
    apart = opening.planar or opening.framed
    phases = phases_of(opening, law, balls, () if apart else of_axis, around)

    def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
        """Return the record of angles of a start, with gap and nu_z, from the user's `data`.

        s, z are sin(theta), cos(theta). A framed system has a `start` that does all of this.
        """
        e = system.start(data, s, z, b)
        return type(angles)(*(getattr(e, n, data.get(n, 0)) for n in angles._fields))

    def assembled(b: Touch, rules: Any, internal: Callable) -> tuple[Any, Mapping[str, Phase]]:
        """Return the body seen from each of its balls, and the phases of a run: `System.assembled`.

        b is in internal units; `rules` is a `ContactLaw`, SI; internal(value, unit) converts. With
        mu = 0 the phases are those without friction, as a contact that cannot stick has no others.
        """
        stem = (internal(rules.r, METRE), internal(rules.h, METRE)) if rules.stem else ()
        known = phases
        friction = b.friction
        if (law.set_valued or law.regions) and np.all(friction.mu == 0):
            none = LAWS["none"].given(PARTS if has_parts(friction) else ())
            known = opened(system, none, balls, around).phases
            numbers = (getattr(friction, name, 0 * b.m) for name in none.parameters)
            b = b._replace(friction=none._make(numbers))
        return seen_from_balls(b, stem), known

    return replace(
        in_surroundings(system, around) if around else system,
        title=f"{system.title}, which may slip, roll and fly",
        phases=phases,
        common=Phase({form.name: form}, quantities, (*of_axis, *OCCURRENCES), leave=moving),
        assembled=assembled,
        begin=jump_by_states(begin),
        read=row,
        tables=TABLES,
        laws={name: one for name, one in all_laws(system.laws) if kind_of(one) == kind_of(law)},
        initial=system.initial | ABOVE,
        start=system.start if opening.framed else start,
        angles=angles,
        long_names=system.long_names | LONG_NAMES | (LOSSES if around else {}),
        integrals=("jellett",) if jellett else (),
        outlook=disturbed if around else opening.outlook,
        contact=(law, balls, around),
        **NO_THEORY,
    )
