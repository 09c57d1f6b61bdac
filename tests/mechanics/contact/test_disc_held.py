"""What holds a contact disc at rest, against the equations of Newton and Euler solved as linear
ones.
"""

from functools import cache

import numpy as np
import pytest
from nightly import at_night
from scipy.integrate import quad

from tippetop.mechanics.contact.response import direction, margin
from tippetop.mechanics.friction import Contensou
from tippetop.mechanics.operand import Vector


Z = np.array([0.0, 0.0, 1.0])


@cache
def limits(x):
    """|F|/(mu N) and |tau|/(mu N patch) of a disc under Hertz's pressure that slides with x and
    turns with 1, by quadrature over its points: the disc's share at a radius r, and the direction
    of sliding there.
    """

    def at(of):
        def ring(r):
            pressure = 1.5 * np.sqrt(1 - r * r) / np.pi
            inner = quad(lambda angle: of(r, angle, x), 0, 2 * np.pi, limit=200)[0]
            return pressure * r * inner

        return quad(ring, 0, 1, limit=200)[0]

    def speed(r, angle):
        return np.hypot(x - r * np.sin(angle), r * np.cos(angle))

    force = at(lambda r, angle, x: (x - r * np.sin(angle)) / speed(r, angle))
    torque = at(lambda r, angle, x: r * (r - x * np.sin(angle)) / speed(r, angle))
    return force, torque


@pytest.mark.parametrize("x", [at_night(0.3), 1.7])
def test_friction_of_a_disc_gives_what_is_within_its_limits(x):
    force, torque = limits(x)
    law, N = Contensou(0.3, 0.1, 0.0), 2.0
    push = [Vector(0.0, share * force * 0.6, N) for share in (0.999, 1.001)]
    turn = [share * torque * 0.06 for share in (0.999, 1.001)]
    assert margin(push[0], turn[0], law) > 0 > margin(push[1], turn[1], law)
    assert (
        margin(Vector(0.0, 0.0, N), 0.589 * 0.06, law)
        > 0
        > margin(Vector(0.0, 0.0, N), 0.5891 * 0.06, law)
    )
    assert margin(Vector(0.5999, 0.0, N), 0.0, law) > 0 > margin(Vector(0.6, 0.0, N), 1e-9, law)


@pytest.mark.parametrize("x", [at_night(0.3), 1.7])
def test_a_disc_that_gives_way_slides_against_its_friction(x):
    force, torque = limits(x)
    v, edge = direction(Vector(0.0, force * 0.6, 2.0), -torque * 0.06, Contensou(0.3, 0.1, 0.0))
    assert (v.x, v.y / edge, np.hypot(v.y, edge)) == pytest.approx((0.0, -x, 1.0), abs=1e-9)
