"""A body seen from each of its balls."""

import numpy as np
import pytest

from tippetop.mechanics.contact.body import Moving, Touch, gap, height, seen_from_balls
from tippetop.mechanics.operand import Vector


def test_both_views_of_a_body_agree_on_the_gap_of_the_other_ball(rng: np.random.Generator) -> None:
    """No number is a difference of rounded sums."""
    for c, R, r, h in rng.uniform((-1, 0.5, 0.1, 0.2), (1, 1, 0.5, 2), (20, 4)):
        one, two = seen_from_balls(Touch(1.0, R, c, 1.0, 1.0, 1.0, None), (r, h))
        assert (one.clearance, one.lever) == (R - r, h)
        assert (two.clearance, two.lever) == (r - R, -h)
        for z in rng.uniform(-1, 1, 5):
            gap = height(z, one) - height(z, two)
            for found in (one.clearance + one.lever * z, -(two.clearance + two.lever * z)):
                assert found == pytest.approx(gap, abs=1e-15)


def test_the_gap_is_the_height_of_the_lowest_point_of_the_ball() -> None:
    """The centre of the ball lies c along 3hat from the centre of mass."""
    b = Touch(1.0, 0.5, 0.25, 1.0, 1.0, 1.0, None)
    still = Vector(0.0, 0.0, 0.0)
    for z in (-1.0, -0.5, 0.0, 1.0):
        u = Vector((1 - z**2) ** 0.5, 0.0, z)
        assert gap(Moving(u, still, still, 3.0), b) == 3.0 + 0.25 * z - 0.5
