"""The phases of a cylinder: a ball whose phi', omega_3 and nu_y vanish. [contact 2.7]

theta is not wrapped. I1 is the moment about the centre of mass.
"""

from collections import namedtuple
from dataclasses import replace
from functools import lru_cache
from typing import Any

from ..form import Phase
from .integrals import integral
from .state import PLANAR_ROW, planar_theta_dot


@lru_cache
def with_theta_dot(record: Any) -> Any:
    """Return the type of a record of scalars with one more, theta'."""
    return namedtuple("PlanarScalars", (*record._fields, "theta_dot"))


def in_plane(phase: Phase) -> Phase:
    """Return a phase that integrates theta too, and whose scalars have theta'."""
    form = phase.form

    def scalars(q, b):
        s = form.scalars(q, b)
        record: Any = type(s)
        return with_theta_dot(record)(*s, planar_theta_dot(q, b))

    theta = integral("theta", lambda q, carried, b: planar_theta_dot(q, b))
    integrals = (theta, *form.integrals)
    turn = PLANAR_ROW.orientation
    changed = replace(form, scalars=scalars, integrals=integrals, orientation=turn)
    return replace(phase, forms=changed)
