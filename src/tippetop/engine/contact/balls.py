"""The balls of a body that can touch the plane, as the equations take them."""

from typing import Any

import numpy as np

from ...mechanics.contact.body import Ball, Body, Touch, touch
from ...mechanics.friction import LAWS, Frictionless, is_frictionless, slip_coefficient
from ...mechanics.operand import leaves, refill
from ...mechanics.units import METRE
from ...problem import Problem


class Balls:
    """The balls of a body that can touch the plane, in internal units and the working precision.

    Parameters
    ----------
    problem
        A run whose contact changes its phase.
    """

    def __init__(self, problem: Problem):
        body, number = problem.internal_body, problem.number
        rules = problem.contact
        assert rules is not None
        friction, law = body.friction, problem.law
        if (law.set_valued or law.regions) and is_frictionless(friction):
            friction, law = Frictionless(), LAWS["none"]
        self.dry, self.regions = law.set_valued, law.regions
        self.drills = bool(self.regions)
        one = number(1)
        self.stem, balls = rules.stem, [Ball(body.c, one * body.R, 0 * one)]
        if rules.stem:
            metre = problem.exact(1) / problem.exact(problem.scales.of(METRE))
            r, h = (number(problem.exact(x) * metre) for x in (rules.r, rules.h))
            balls.append(Ball(body.c + h, r, h))
        whole = Body(body.m, body.I1, body.I3, body.g, friction, tuple(balls))
        self.bodies = [touch(whole, i) for i in range(len(balls))]
        plain = number is np.float64 and not (self.stem or self.dry or self.drills)
        if plain and _has_a_value_at_rest(friction):
            self.bodies = [refill(self.bodies[0], map(float, leaves(self.bodies[0])))]  # formulas take these faster

    def __len__(self) -> int:
        return len(self.bodies)

    def __getitem__(self, ball: int) -> Touch:
        return self.bodies[ball]


def _has_a_value_at_rest(friction: Any) -> bool:
    """Whether no formula of a contact divides by zero: Python's numbers would raise where numpy's are infinite."""
    try:
        with np.errstate(all="ignore"):
            return bool(np.isfinite(slip_coefficient(0.0, 0.0, refill(friction, map(float, leaves(friction))))))
    except ArithmeticError:
        return False
