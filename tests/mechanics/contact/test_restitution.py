"""The stem of a body whose contact may open."""

import numpy as np
import pytest

from tippetop.mechanics.contact.restitution import stem_height


def test_the_height_of_a_stem_is_that_of_its_lowest_point(rng: np.random.Generator) -> None:
    """Of points all over its ball, whose middle is `offset` along the axis from the centre of mass."""
    points = rng.normal(size=(200_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for z in (-1.0, -0.3, 0.7):
        axis = np.array([np.sqrt(1 - z * z), 0.0, z])
        lowest = (0.05 + 0.016 * axis[2] + 0.004 * points[:, 2]).min()
        assert stem_height(0.05, z, 0.016, 0.004) == pytest.approx(lowest, abs=1e-7)
