"""Impacts and landings of a run, in its numbers: compiled for doubles."""

from functools import partial
from typing import Any

import numpy as np

from tippetop_kernels.compilation import entry

from ...mechanics.contact import body as contact
from ...mechanics.contact.body import Touch
from ...mechanics.contact.impact import Struck, after_impact, arrival
from ...mechanics.contact.patch_impact import MOST_COMPILED, follow, new_room, patch_struck
from ...mechanics.contact.state import Moving
from ...mechanics.contact.struck import struck
from ...mechanics.friction import Frictionless, named
from ...mechanics.operand import Vector
from ...problem import Problem
from .flights import Landings
from .smooth_impact import SmoothImpacts


@entry
def follow_patch(room):
    """`follow` in doubles."""
    return follow(room, 2.0**-52, MOST_COMPILED)


class Strikes:
    """What `world` has of impacts.

    Parameters
    ----------
    problem
        The run.
    bodies
        The body seen from each ball.
    """

    def __init__(self, problem: Problem, bodies: tuple[Touch, ...]):
        law = bodies[0].friction
        known = named(type(law), problem.system.laws)
        set_valued = known is not None and known[1].set_valued
        drills = known is not None and bool(known[1].regions)
        rules: Any = problem.contact
        smooth = None
        if not (set_valued or drills or isinstance(law, Frictionless)):
            smooth = SmoothImpacts(law, rules.restitution, problem.number)
        room = new_room(problem.number) if drills else None
        patch = partial(follow_patch, room) if room and problem.number is np.float64 else None
        landings = Landings(problem.number)

        def of_body(x: Moving, b: Touch, e_n: Any) -> tuple[Vector, Any, Struck]:
            if smooth is not None and smooth.compiled:
                return smooth.body_struck(x.u, x.L, x.velocity, b, e_n)
            a = arrival(x.u, x.L, x.velocity, b)
            if drills:
                turn, slip = contact.angular_velocity(x.u, x.L, b).z, (a.along, a.sideways, a.v.z)
                impact: Any = patch_struck(slip, turn, a.s, x.u.z, b, e_n, rules.restitution, room, patch)
            elif smooth is None:
                mu = b.friction.mu if set_valued else 0 * b.m
                impact = struck(a.along, a.sideways, a.v.z, a.K, mu, e_n, rules.restitution)
            else:
                impact = smooth.struck(a.along, a.sideways, a.v.z, a.K, x.u.z, e_n)
            twist = impact.twist if drills else 0 * a.s
            after = after_impact(x.u, x.L, x.velocity, a, impact.p_e, impact.p_2, impact.p_z, twist, b)
            return a.v, impact, after

        def landing(x: Moving, b: Touch, zeros: int) -> Any:
            return landings.of(x.u, x.L, x.velocity.z, contact.gap(x.height, x.u.z, b), b, zeros)

        self.struck, self.landing = of_body, landing
