"""The balls of a body that can touch the plane, as the equations take them."""

from ...mechanics.contact.phases.legs import Body
from ...mechanics.friction import Contensou, Frictionless, SetValued, is_frictionless
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
        friction = body.friction
        self.dry = isinstance(friction, SetValued) and not is_frictionless(friction)
        self.drills = isinstance(friction, Contensou) and not is_frictionless(friction)
        friction = (
            friction if self.dry or self.drills or not isinstance(friction, SetValued | Contensou) else Frictionless()
        )
        one = number(1)
        self.stem = rules.stem
        self.bodies = [Body(body.m, one * body.R, body.c, body.I1, body.I3, body.g, friction, one, 0 * one)]
        if rules.stem:
            metre = problem.exact(1) / problem.exact(problem.scales.of(METRE))
            r, h = (number(problem.exact(x) * metre) for x in (rules.r, rules.h))
            clear = body.R - r
            self.bodies = [self.bodies[0]._replace(clearance=clear, lever=h)]
            self.bodies.append(self.bodies[0]._replace(R=r, c=body.c + h, clearance=-clear, lever=-h))

    def __len__(self) -> int:
        return len(self.bodies)

    def __getitem__(self, ball: int) -> Body:
        return self.bodies[ball]
