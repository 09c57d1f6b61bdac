"""What an impact does to the body, and what strikes the plane: balls, their gaps and their velocities. [contact 3]"""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.compilation import entry

from ...mechanics.contact import body as contact
from ...mechanics.contact.impact import Struck, after_impact, arrival
from ...mechanics.contact.patch_impact import MOST_COMPILED, follow, new_room, patch_struck
from ...mechanics.contact.phases.drilling import LOST
from ...mechanics.contact.phases.row import Row
from ...mechanics.contact.struck import struck
from ...mechanics.friction import Frictionless
from ...mechanics.operand import Vector
from ...mechanics.systems.with_contact import kinds_of, leg
from ...mechanics.variables import INTEGRAL_SCALE
from ...problem import Problem
from .balls import Balls
from .flights import Landings
from .smooth_impact import SmoothImpacts


CLOSES_AT = 1e-8  # v_n below which an impact does not bounce: the error is its square


class Moment(NamedTuple):
    """The body at one moment, internal units: axis, momentum, velocity and height of the centre of mass, integrals."""

    u: Vector
    L: Vector
    velocity: Vector
    height: Any
    carried: np.ndarray


def moment_of(row: np.ndarray) -> Moment:
    """What a row (variables,) says of the body; doubles become Python's numbers, which formulas take faster."""
    q = Row._make(row[: len(Row._fields)].tolist() if row.dtype == float else row[: len(Row._fields)])
    carried = row[len(Row._fields) :].copy()
    return Moment(Vector(*q[:3]), Vector(*q[3:6]), Vector(*q[6:9]), q.height, carried)


@dataclass
class Strike:
    """An impact, internal units."""

    ball: int
    v_n: tuple[float, float]  # normal velocity before and after
    slide: tuple[float, float]  # tangential speed
    impulse: float  # normal
    friction_impulse: float
    work: float  # energy that the body gained
    mode: str
    plastic: bool  # whether the ball stays on the plane
    makes_energy: bool  # more than rounding does; restitution "newton" can


@entry
def follow_patch(room):
    """`follow` in doubles."""
    return follow(room, 2.0**-52, MOST_COMPILED)


class Impacts:
    """The balls of a body and what their impacts do.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.

    Attributes
    ----------
    left
        Internal time to the end of the run: the start of a slide is followed no further.
    """

    def __init__(self, problem: Problem, balls: Balls):
        self.problem, self.balls, self.number = problem, balls, problem.number
        self.left: Any = problem.number(np.inf)
        names = problem.variables.names[problem.variables.moving :]
        self.work, self.impulse = names.index("work"), names.index("impulse")
        self.lost = names.index(LOST[0]) if LOST[0] in names else -1
        rules = problem.contact
        assert rules is not None
        self.rules, self.kinds = rules, kinds_of(problem.system.name)
        self.landings, law = Landings(problem.number), balls[0].friction
        smooth = not (self.balls.dry or self.balls.drills or isinstance(law, Frictionless))
        self.smooth = SmoothImpacts(law, rules.restitution, problem.number) if smooth else None
        self.room = new_room(problem.number) if self.balls.drills else None
        self.patch = partial(follow_patch, self.room) if self.room and problem.number is np.float64 else None

    def state(self, kind: str, index: int, moment: Moment) -> Any:
        """The state of a phase in which the body is so, with this ball in contact."""
        return self.kinds[kind].state(moment.u, moment.L, moment.velocity, moment.height, self.balls[index])

    def functions(self, kind: str, index: int, moment: Moment) -> dict[str, float]:
        """The event functions of a phase, by name, in the order of its events."""
        body = self.balls[index]
        scalars = self.kinds[kind].form.scalars(self.state(kind, index, moment), body)
        events = leg(self.problem.system.name, kind).events
        return {event.name: float(event.formula(scalars, body)) for event in events}

    def gap(self, index: int, moment: Moment) -> Any:
        """Height of a ball above the plane."""
        return contact.gap(moment.height, moment.u.z, self.balls[index])

    def point(self, index: int, moment: Moment) -> Vector:
        """Velocity of the lowest point of a ball."""
        return contact.contact_velocity(moment.u, moment.L, moment.velocity, self.balls[index])

    def _struck(self, index: int, moment: Moment, v_n: float) -> tuple[Moment, Strike]:
        """The body after an impact of a ball, whose lowest point falls with v_n."""
        closes = abs(v_n) < CLOSES_AT
        e_n, b = 0.0 if closes else self.rules.e_n, self.balls[index]
        impact: Any
        if self.smooth is not None and self.smooth.compiled:
            v, impact, after = self.smooth.body_struck(moment.u, moment.L, moment.velocity, b, e_n)
        else:
            v, impact, after = self._followed(index, moment, e_n)
        carried = moment.carried.copy()
        if self.balls.drills:
            carried[self.lost] = carried[self.lost] + impact.twist * contact.arm(moment.u, b).z * INTEGRAL_SCALE
        carried[self.work] = carried[self.work] - after.gained * INTEGRAL_SCALE
        carried[self.impulse] = carried[self.impulse] + after.p.z * INTEGRAL_SCALE
        velocity, plastic = after.velocity, closes or self.rules.e_n == 0
        if plastic:
            velocity = velocity._replace(z=velocity.z - after.v.z)  # it does not rise by rounding
        strike = Strike(
            index,
            (float(v.z), 0.0 if plastic else float(after.v.z)),
            (float(self._size(v)), float(self._size(after.v))),
            float(after.p.z),
            float(self._size(after.p)),
            float(after.gained),
            impact.mode,
            plastic,
            impact.makes_energy,
        )
        return Moment(moment.u, after.L, velocity, moment.height, carried), strike

    def _followed(self, index: int, moment: Moment, e_n: float) -> tuple[Vector, Any, Struck]:
        """What `SmoothImpacts.body_struck` gives, under any law and in any numbers."""
        u, b = moment.u, self.balls[index]
        a, restitution = arrival(u, moment.L, moment.velocity, b), self.rules.restitution
        if self.balls.drills:
            turn, slip = contact.angular_velocity(u, moment.L, b).z, (a.along, a.sideways, a.v.z)
            impact: Any = patch_struck(slip, turn, a.s, u.z, b, e_n, restitution, self.room, self.patch)
        elif self.smooth is None:
            mu = b.friction.mu if self.balls.dry else 0 * b.m
            impact = struck(a.along, a.sideways, a.v.z, a.K, mu, e_n, restitution)
        else:
            impact = self.smooth.struck(a.along, a.sideways, a.v.z, a.K, u.z, e_n)
        twist = impact.twist if self.balls.drills else 0 * a.s
        after = after_impact(u, moment.L, moment.velocity, a, impact.p_e, impact.p_2, impact.p_z, twist, b)
        return a.v, impact, after

    def _size(self, v: Vector) -> Any:
        square = v.x * v.x + v.y * v.y
        return math.sqrt(square) if isinstance(square, float) else np.sqrt(square)
