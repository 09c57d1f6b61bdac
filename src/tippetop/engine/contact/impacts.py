"""What an impact does to the body, and what strikes the plane: balls, their gaps and their velocities. [contact 3]"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...mechanics.contact import ball as balls_
from ...mechanics.contact.ball import Ball
from ...mechanics.contact.patch_impact import patch_struck
from ...mechanics.contact.phases.drilling import LOST
from ...mechanics.contact.phases.legs import Body
from ...mechanics.contact.phases.row import Row
from ...mechanics.contact.struck import struck
from ...mechanics.friction import Frictionless
from ...mechanics.operand import Vector, cross, dot, plus, times
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


class Impacts:
    """The balls of a body and what their impacts do.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    """

    def __init__(self, problem: Problem, balls: Balls):
        self.problem, self.balls, self.number = problem, balls, problem.number
        names = problem.variables.names[problem.variables.moving :]
        self.work, self.impulse = names.index("work"), names.index("impulse")
        self.lost = names.index(LOST[0]) if LOST[0] in names else -1
        rules = problem.contact
        assert rules is not None
        self.rules, self.kinds = rules, kinds_of(problem.system.name)
        self.landings, law = Landings(problem.number), balls[0].friction
        self.smooth = SmoothImpacts(law, rules.restitution, problem.number)
        self.touching = [self._ball(body) for body in balls.bodies]

    def ball(self, index: int) -> Ball:
        """A ball as the formulas of its contact take it."""
        return self.touching[index]

    def _ball(self, b: Body) -> Ball:
        mu = b.friction.mu if self.balls.dry or self.balls.drills else 0 * b.m
        return Ball(b.m, b.I1, b.I3, b.g, mu, b.c, b.R)

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
        return balls_.gap(moment.height, moment.u.z, self.ball(index))

    def point(self, index: int, moment: Moment) -> Vector:
        """Velocity of the lowest point of a ball."""
        return balls_.contact_velocity(moment.u, moment.L, moment.velocity, self.ball(index))

    def _struck(self, index: int, moment: Moment) -> tuple[Moment, Strike]:
        b, v, u = self.ball(index), self.point(index, moment), moment.u
        across = self._size(u)
        e = Vector(u.x / across, u.y / across, 0 * across) if float(across) > 0 else self._direction(v)
        along, sideways = v.x * e.x + v.y * e.y, e.x * v.y - e.y * v.x
        closes = abs(float(v.z)) < CLOSES_AT
        K = balls_.mobility(across, u.z, b)
        e_n, law = 0.0 if closes else self.rules.e_n, self.balls[index].friction
        if self.balls.drills:
            turn = balls_.angular_velocity(u, moment.L, b).z
            patch = self.number(law.patch)
            result: Any = patch_struck((along, sideways, v.z), turn, across, u.z, b, patch, e_n, self.rules.restitution)
        elif self.balls.dry or isinstance(law, Frictionless):
            result = struck(along, sideways, v.z, K, b.mu, e_n, self.rules.restitution)
        else:
            result = self.smooth.struck(along, sideways, v.z, K, u.z, e_n)
        return self._applied(index, moment, v, e, result, closes)

    def _applied(
        self, index: int, moment: Moment, before: Vector, e: Vector, result: Any, closes: bool
    ) -> tuple[Moment, Strike]:
        """The body after an impact of a ball, whose lowest point had the velocity `before`."""
        b, u = self.ball(index), moment.u
        p = Vector(result.p_e * e.x - result.p_2 * e.y, result.p_e * e.y + result.p_2 * e.x, result.p_z)
        velocity, moved = plus(moment.velocity, times(1 / b.m, p)), cross(balls_.arm(u, b), p)
        L = plus(moment.L, moved)
        if self.balls.drills:  # the impulse of a torque about the vertical
            L = L._replace(z=L.z + result.twist)
        after = balls_.contact_velocity(u, L, velocity, b)
        gained = (dot(p, before) + dot(p, after)) / 2
        carried = moment.carried.copy()
        if self.balls.drills:
            turns = (balls_.angular_velocity(u, momentum, b).z for momentum in (moment.L, L))
            gained = gained + result.twist * sum(turns) / 2
            carried[self.lost] = carried[self.lost] + result.twist * balls_.arm(u, b).z * INTEGRAL_SCALE
        carried[self.work] = carried[self.work] - gained * INTEGRAL_SCALE
        carried[self.impulse] = carried[self.impulse] + p.z * INTEGRAL_SCALE
        plastic = closes or self.rules.e_n == 0
        if plastic:
            velocity = velocity._replace(z=velocity.z - after.z)  # it does not rise by rounding
        strike = Strike(
            index,
            (float(before.z), 0.0 if plastic else float(after.z)),
            (float(self._size(before)), float(self._size(after))),
            float(p.z),
            float(self._size(p)),
            float(gained),
            result.mode,
            plastic,
            result.makes_energy,
        )
        return Moment(u, L, velocity, moment.height, carried), strike

    def _direction(self, v: Vector) -> Vector:
        w = self._size(v)
        one, none = 0 * w + 1, 0 * w
        return Vector(v.x / w, v.y / w, none) if float(w) > 0 else Vector(one, none, none)

    def _size(self, v: Vector) -> Any:
        square = v.x * v.x + v.y * v.y
        return math.sqrt(square) if isinstance(square, float) else np.sqrt(square)
