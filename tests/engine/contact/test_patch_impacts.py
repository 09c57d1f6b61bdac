"""Impacts of a patch that drills, in machine code: as Python has them, and where the patch hardly turns."""

from functools import partial

import numpy as np
import pytest

from tippetop.engine.contact.impacts import follow_patch
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.patch_impact import PatchImpact, new_room, patch_struck
from tippetop.mechanics.contact.response import mobility
from tippetop.mechanics.contact.struck import RESTITUTIONS, struck
from tippetop.mechanics.friction import Contensou


BODY = Touch(0.006, 0.015, 0.003, 8e-7, 7e-7, 9.81, Contensou(0.3, 5e-4, 0.0))


def by_machine_code(*impact: object) -> PatchImpact:
    room = new_room(np.float64)
    return patch_struck(*impact, room, partial(follow_patch, room))


@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_machine_code_gives_what_python_gives(restitution: str) -> None:
    impact = ((0.1, -0.2, -0.1), 90.0, 0.8, 0.6, BODY, 0.6, restitution)
    *made, mode = by_machine_code(*impact)
    *expected, as_well = patch_struck(*impact)
    assert made == pytest.approx(expected, rel=1e-12)
    assert mode == as_well == "slip"


@pytest.mark.parametrize("restitution", RESTITUTIONS)
@pytest.mark.parametrize("Omega_z", [0.0, 0.1])
def test_a_patch_that_hardly_turns_comes_to_rest_within_an_impact_as_a_point_does(
    Omega_z: float, restitution: str
) -> None:
    """The sliding that has died out grew again while the end of the restitution was sought backwards: v of 1 mm/s."""
    s, z = np.sin(1.0), np.cos(1.0)
    v, e_n, body = (0.02, -0.03, -0.3), 0.5, BODY._replace(friction=Contensou(0.3, 2e-5, 0.0))
    made = by_machine_code(v, Omega_z, s, z, body, e_n, restitution)
    point = struck(*v, mobility(s, z, body), body.friction.mu, e_n, restitution)
    assert (point.v_e, point.v_2) == (0, 0)
    assert (made.v_e, made.v_2) == pytest.approx((0, 0), abs=1e-5)
    assert (made.v_n, made.p_z) == pytest.approx((point.v_n, point.p_z), rel=1e-5)
    assert made.energy == pytest.approx(point.energy, rel=1e-4)
