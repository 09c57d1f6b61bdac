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
from ...mechanics.friction import Frictionless, slip_coefficient
from ...mechanics.operand import Vector, cross, dot, plus, times
from ...mechanics.systems.with_contact import kinds_of
from ...mechanics.variables import INTEGRAL_SCALE
from ...problem import Problem
from .legs import Balls
from .smooth_impact import struck_smooth


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
        self.rules, self.kinds = problem.contact, kinds_of(problem.system.name)

    def ball(self, index: int) -> Ball:
        """A ball as the formulas of its contact take it."""
        b: Body = self.balls[index]
        mu = b.friction.mu if self.balls.dry or self.balls.drills else 0 * b.m
        return Ball(b.m, b.I1, b.I3, b.g, mu, b.c, b.R)

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
        assert self.rules is not None
        closes = abs(float(v.z)) < CLOSES_AT
        K = balls_.mobility(across, u.z, b)
        e_n, law = 0.0 if closes else self.rules.e_n, self.balls[index].friction
        if self.balls.drills:
            return self._struck_patch(index, moment, e, across, (along, sideways, v.z), e_n, closes)
        if self.balls.dry or isinstance(law, Frictionless):
            result = struck(along, sideways, v.z, K, b.mu, e_n, self.rules.restitution)
        else:
            result = struck_smooth(
                along, sideways, v.z, K, lambda v2: slip_coefficient(v2, u.z, law), e_n, self.rules.restitution
            )
        return self._applied(index, moment, e, result, 0 * b.m, closes)

    def _struck_patch(
        self, index: int, moment: Moment, e: Vector, s: Any, v: tuple, e_n: float, closes: bool
    ) -> tuple[Moment, Strike]:
        """The same with friction that drills, whose torque is struck too."""
        b, u, law = self.ball(index), moment.u, self.balls[index].friction
        assert self.rules is not None
        turn = float(balls_.angular_velocity(u, moment.L, b).z)
        result = patch_struck(tuple(map(float, v)), turn, s, u.z, b, law.patch, e_n, self.rules.restitution)
        return self._applied(index, moment, e, result, result.twist, closes)

    def _applied(
        self, index: int, moment: Moment, e: Vector, result: Any, twist: Any, closes: bool
    ) -> tuple[Moment, Strike]:
        """The body after an impulse at a ball, and the impulse `twist` of a torque about the vertical."""
        assert self.rules is not None
        b, u = self.ball(index), moment.u
        p = Vector(result.p_e * e.x - result.p_2 * e.y, result.p_e * e.y + result.p_2 * e.x, result.p_z)
        before, turn = self.point(index, moment), balls_.angular_velocity(u, moment.L, b).z
        velocity, moved = plus(moment.velocity, times(1 / b.m, p)), cross(balls_.arm(u, b), p)
        L = plus(moment.L, moved._replace(z=moved.z + twist))
        after, turn_after = balls_.contact_velocity(u, L, velocity, b), balls_.angular_velocity(u, L, b).z
        gained = (dot(p, before) + dot(p, after) + twist * (turn + turn_after)) / 2
        carried = moment.carried.copy()
        carried[self.work] = carried[self.work] - gained * INTEGRAL_SCALE
        carried[self.impulse] = carried[self.impulse] + p.z * INTEGRAL_SCALE
        if self.lost >= 0:
            carried[self.lost] = carried[self.lost] + twist * balls_.arm(u, b).z * INTEGRAL_SCALE
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
