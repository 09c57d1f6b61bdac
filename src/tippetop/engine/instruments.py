"""What instruments measure of a body in smooth motion, by derivatives of its place and axes.

States of tops go in, values by name come out; `ensembles.rows_at_times` calls it for fits.
"""

import numpy as np

from ..columns import Arrays
from ..mechanics.contact.body import height, touching
from ..mechanics.operand import Vector, cross, dot, minus, plus, times
from ..mechanics.units import METRE, METRE_PER_SECOND2, PER_SECOND2, RADIAN_PER_SECOND
from ..problem import Problems
from .expressions import axes_in, orientation_of
from .observables import Source
from .variational import in_motion


IN_BODY = {
    "gyroscope": RADIAN_PER_SECOND,
    "omega": RADIAN_PER_SECOND,
    "turning": PER_SECOND2,
    "accelerometer": METRE_PER_SECOND2,
}
"""Angular velocity in body axes and in space; in body axes: its rate, and the specific force at the
centre of mass.
"""
INSTRUMENTS = {"z": Source(("height",), METRE, "height of the centre of mass")}
INSTRUMENTS |= {
    name: Source(tuple(f"{name}_{c}" for c in "xyz"), unit, name, ("xyz",))
    for name, unit in IN_BODY.items()
}
"""The sources of these values, like those of columns."""


def instruments_of(tops: Problems, states: np.ndarray, which: np.ndarray) -> Arrays:
    """Return the values of INSTRUMENTS by the names of their parts, internal units, (k,) each.

    The order in which they are computed is that of INSTRUMENTS.

    `states` (variables, k) are of the runs with the numbers `which` (k,). The specific force is the
    acceleration of the centre of mass less that of gravity.
    """
    variables = tops.variables
    form = variables.form
    body = tops.body_of_pars(tops.pars[:, which])
    q, carried = variables.split(in_motion(variables, [*states], body, 2))
    scalars = form.scalars(q, body)
    found = orientation_of(tops.base.system, form, q, carried, body)
    first, third = axes_in(found)
    axes = first, cross(third, first), third
    moves = [_rates(axis) for axis in axes]
    # omega_1 = 2hat' . 3hat, and cyclically
    own = Vector(*(dot(moves[i - 2], axes[i - 1]) for i in range(3)))
    omega = plus(cross(third, moves[2]), times(own.z, third))
    if not hasattr(carried, "x"):  # on a fixed tip, from which the centre of mass is at -c 3hat
        place = times(-body.c, third)
    else:
        y = getattr(carried, "y", 0 * carried.x)  # a planar motion has none
        by_row = hasattr(scalars, "height")
        z = scalars.height if by_row else height(scalars.z, touching(scalars, body))
        place = Vector(carried.x, y, z)
    x, y = (getattr(body, "around", ()) and body.around.slope) or (0.0, 0.0)
    force = minus(_rates(_rates(place)), Vector(x, y, -body.g))
    felt = (dot(axis, force) for axis in axes)
    values = place.z, *own, *omega, *_rates(own), *felt
    names = (part for source in INSTRUMENTS.values() for part in source.parts)
    # a constant becomes a column (k,) too
    return {n: v.value + 0 * states[0] for n, v in zip(names, values, strict=True)}


def _rates(vector: Vector) -> Vector:
    """Return the time derivative of a vector whose components are `variational.Moving`."""
    return Vector(*(one.rate for one in vector))
