"""Systems whose contact may open and close: the phases of their body, and the exits that lead from
one to another."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import product
from operator import itemgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..events import Event
from ..form import CLOCK, Exit, Phase
from ..friction import LAWS, Frictionless, Law, all_laws, is_frictionless, named, slip_coefficient
from ..operand import leaves, refill
from ..parameter import Parameter
from ..system import System
from ..units import JOULE, METRE, METRE_PER_SECOND, NEWTON_SECOND
from . import body as contact
from .body import Ball, Body, Touch, touch
from .double_contact import double_contact
from .exits import (
    Impact,
    begin,
    begin_slip,
    change_ball,
    go_on,
    land,
    lift_off,
    phase_name,
    stay_on,
    stick,
)
from .gliding import catalogue as gliding
from .gliding.euler import centre_velocity
from .planar import IN_PLANE, SIGNED_SLIP, signed_slide
from .single_contact import (
    CONE,
    DIRECTED_SLIP,
    FLIGHT,
    RESTS,
    ROLL,
    SLIP,
    STICK,
    TOUCH,
    directed,
    disc_slip,
)
from .state import (
    ANGLES,
    BALLS,
    DISC_ANGLES,
    DISC_ROW,
    LOST,
    PHASES,
    PLANAR_ANGLES,
    PLANAR_ROW,
    ROW,
    columns,
    moving,
    row,
)


ABOVE = {
    "gap": Parameter(METRE, "height of the lowest point of the sphere above the plane", least=0),
    "nu_z": Parameter(METRE_PER_SECOND, "vertical velocity of the lowest point of the sphere"),
}
LONG_NAMES = {
    "gap": "height of the lowest point of the ball that touches the plane, or did last",
    "nu_z": "vertical velocity of the lowest point of that ball",
    "nu_x": "horizontal velocity of the lowest point along e; undefined (NaN) exactly at a pole",
    "nu_y": "horizontal velocity of the lowest point along 2hat; undefined (NaN) exactly at a pole",
    LOST[0]: LOST[2],
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
"""What jumps log, as events of a run."""

REASONS = (
    "start",
    "stick",
    "slip",
    "liftoff",
    "landing",
    "other-ball",
    "opens-at-once",
    "other-leaves",
)
TABLES = {
    "phases": {
        "phase": PHASES,
        "ball": BALLS,
        "reason": REASONS,
    },
    "impacts": Impact(
        BALLS, *(METRE_PER_SECOND,) * 4, *(NEWTON_SECOND,) * 2, JOULE, ("slip", "stick", "reverse")
    )._asdict(),
}
"""Units or words of the columns of further tables; the place of a word is its number in a store."""


def start(angles: Any, data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
    """Return the angles of initial data; centre_at_rest may replace nu_x and nu_y."""
    e = gliding.given_angles(angles, data, z)
    if not data.get("centre_at_rest"):
        return e
    if "nu_y" not in angles._fields:
        return e._replace(nu_x=e.nu_x - e.theta_dot * contact.height(z, b))
    along_e, along_2 = centre_velocity(e, s, z, b)
    return e._replace(nu_x=e.nu_x - along_e, nu_y=e.nu_y - along_2)


class LawsLike(Mapping):
    """The laws of a system whose contact has the same phases: a view, for registered laws."""

    def __init__(self, system: System, kind: tuple[bool, ...]):
        self.system, self.kind = system, kind

    def _known(self) -> dict[str, Law]:
        return {name: law for name, law in all_laws(self.system.laws) if kind_of(law) == self.kind}

    def __getitem__(self, name: str) -> Law:
        return self._known()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())


def kind_of(law: Law) -> tuple[bool, ...]:
    """Return what decides the phases of a contact, of a law."""
    return law.set_valued, bool(law.regions), law.coefficient is not None


# --- phases and exits -----------------------------------------------------------------------------


class Placed(NamedTuple):
    """A phase on its ball, and the regions of the law on each ball in contact."""

    phase: Phase
    ball: int
    regions: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Its name."""
        return phase_name(self.phase.label, self.ball, *self.regions)


def phases_of(planar: bool, law: Law, balls: int) -> dict[str, Phase]:
    """Return the phases of a body under a law, by name."""
    of_any = IN_PLANE if planar else {phase.label: phase for phase in (SLIP, ROLL, FLIGHT)}
    directed_slip = SIGNED_SLIP if planar else DIRECTED_SLIP
    placed = []
    for ball in range(balls):
        for name, region in law.regions.items():
            placed.append(Placed(disc_slip(region, law.torque), ball, (name,)))
        if law.set_valued:
            placed += [Placed(directed_slip, ball), Placed(of_any["roll"], ball)]
        elif not law.regions:
            placed.append(Placed(of_any["slip"], ball))
        placed.append(Placed(of_any["flight"], ball))
    if balls > 1 and not law.set_valued:
        for names in product(law.regions, repeat=2) if law.regions else ((),):
            regions = tuple(law.regions[name] for name in names)
            placed.append(Placed(double_contact(regions, law.torque).phase, 0, names))
    return {one.name: with_exits(one, placed, planar, law, balls) for one in placed}


def with_exits(one: Placed, placed: list[Placed], planar: bool, law: Law, balls: int) -> Phase:
    """Return a phase as its body and its law have it."""
    phase, ball, name = one.phase, one.ball, one.name
    events = phase.events
    if balls > 1 and phase.label in ("slip", "roll"):
        events = (*events, TOUCH)
    every = tuple(other.name for other in placed)
    flight, slip = phase_name("flight", ball), phase_name("slip", ball)
    jumps: dict[str, tuple[tuple[str, ...], Callable]] = {
        CLOCK: (every, land) if phase.label == "flight" else ((name,), partial(go_on, to=name)),
        "liftoff": ((flight,), lift_off),
        "stick": ((phase_name("roll", ball), slip, flight), stick),
        "slip": ((slip,), partial(begin_slip, sliding=signed_slide if planar else directed)),
        "touch": (every, change_ball),
        "sphere-leaves": (on(1, placed), partial(stay_on, ball=1)),
        "stem-leaves": (on(0, placed), partial(stay_on, ball=0)),
        RESTS.name: ((name,), partial(go_on, to=name, passed=RESTS.name, side=RESTS.direction)),
    }
    for place, region in enumerate(one.regions):
        of_ball = "stem-" if place else ""
        for border in law.regions[region].borders:
            regions = (*one.regions[:place], border.follows, *one.regions[place + 1 :])
            there = law.regions[border.follows].borders
            back = next(way.event for way in there if way.follows == region)
            side = border.direction if border.follows == region else 0
            passed = of_ball + (border.event if side else back)
            to = phase_name(phase.label, ball, *regions)
            jumps[of_ball + border.event] = (to,), partial(go_on, to=to, passed=passed, side=side)
    names = (CLOCK, *(event.name for event in events))
    exits = tuple(Exit(event, *jumps[event]) for event in names)
    forms = {key: replace(form, not_normalised=("R", "c")) for key, form in phase.forms.items()}
    return replace(phase, forms=forms, events=events, exits=exits, parameters=itemgetter(ball), ball=ball)


def on(ball: int, placed: list[Placed]) -> tuple[str, ...]:
    """Return the names of the phases on one ball."""
    return tuple(one.name for one in placed if one.ball == ball and one.phase.label != "both")


# --- systems --------------------------------------------------------------------------------------


_opened: dict[tuple, System] = {}


def opened(system: System, law: Law, balls: int) -> System:
    """Return a system whose contact may open, of one that slides; the same for laws with the same
    record.

    Parameters
    ----------
    system
        Has an `opening`.
    law
        The friction law.
    balls
        1, or 2 of a body with a stem.
    """
    key = system, law.record, balls
    if key not in _opened:
        _opened[key] = _open(system, law, balls)
    return _opened[key]


def _open(system: System, law: Law, balls: int) -> System:
    opening = system.opening
    assert opening is not None
    angles: Any = DISC_ANGLES if law.torque else PLANAR_ANGLES if opening.planar else ANGLES
    form = DISC_ROW if law.torque else PLANAR_ROW if opening.planar else ROW
    of_axis = (event for event in system.events if not event.lasting and event.ends != "liftoff")
    common = Phase(
        {form.name: form},
        columns(opening.planar, opening.routh, balls > 1),
        (*of_axis, *OCCURRENCES),
        leave=moving,
    )

    def assembled(b: Touch, rules: Any, internal: Callable) -> tuple[Any, Mapping[str, Phase]]:
        bodies = seen_from_balls(b, rules, internal, system.laws)
        free = type(bodies[0].friction) is Frictionless
        return bodies, opened(system, LAWS["none"], balls).phases if free else phases

    phases = phases_of(opening.planar, law, balls)
    return replace(
        system,
        title=f"{system.title}, which may slip, roll and fly",
        phases=phases,
        common=common,
        assembled=assembled,
        begin=begin,
        row=row,
        tables=TABLES,
        laws=MappingProxyType(LawsLike(system, kind_of(law))),
        initial=system.initial | ABOVE,
        start=partial(start, type(angles)),
        angles=angles,
        long_names=system.long_names | LONG_NAMES,
        integrals=() if opening.planar else ("jellett",),
        landscape=None,
        potential=None,
        outlook=opening.outlook,
        borders=None,
        motion=None,
        long_form="",
        contact=(law, balls),
    )


def seen_from_balls(b: Touch, rules: Any, internal: Callable, laws: Any) -> tuple[Touch, ...]:
    """Return a body seen from each of its balls, internal units; without friction, under the law
    that has none.

    Parameters
    ----------
    b
        The body seen from its sphere.
    rules
        Of the contact: radius r and distance h of a stem, SI.
    internal
        internal(value, unit) -> an SI value in internal units.
    laws
        The laws of its system.
    """
    known = named(type(b.friction), laws)
    assert known is not None
    smooth = not (known[1].set_valued or known[1].regions)
    friction = b.friction
    if not smooth and is_frictionless(friction):
        friction, smooth = Frictionless(), True
    one = 0 * b.I1 + 1
    balls = [Ball(b.c, one * b.R, 0 * one)]
    if rules.stem:
        r, h = internal(rules.r, METRE), internal(rules.h, METRE)
        balls.append(Ball(b.c + h, r, h))
    whole = Body(b.m, b.I1, b.I3, b.g, friction, tuple(balls))
    bodies = tuple(touch(whole, i) for i in range(len(balls)))
    plain = isinstance(one, float) and smooth and not rules.stem
    if plain and has_a_value_at_rest(friction):  # formulas take floats faster than numbers of NumPy
        return (refill(bodies[0], map(float, leaves(bodies[0]))),)
    return bodies


def has_a_value_at_rest(friction: Any) -> bool:
    """Return whether no formula of a contact divides by zero: there floats raise, and numbers of
    NumPy do not."""
    try:
        with np.errstate(all="ignore"):
            law = refill(friction, map(float, leaves(friction)))
            return bool(np.isfinite(slip_coefficient(0.0, 0.0, law)))
    except ArithmeticError:
        return False
