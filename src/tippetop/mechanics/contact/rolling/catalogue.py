"""Input and output of a rolling body: initial data, forms, events, quantities."""

from dataclasses import replace
from typing import Any

from ...system import Form, Quantity
from ...units import NEWTON, ONE
from ..body import Touch
from ..body_axes import by_angles, carried_along
from ..gliding import catalogue as gliding
from ..gliding.catalogue import given_angles
from ..gliding.euler import psi_rate, sine_and_cosine
from ..gliding.vector import axis, axis_rate
from ..integrals import integral, place
from . import euler, vector
from .chart import angles_of_euler, angles_of_vector, euler_of_angles, vector_of_angles
from .euler import EULER_UNITS, Angles, euler_rates, euler_scalars
from .reaction import friction_needed, horizontal_force, normal_force
from .vector import VECTOR_UNITS, vector_rates, vector_scalars


# --- initial data, events, quantities -----------------------------------------------------------

INITIAL = {name: p for name, p in gliding.INITIAL.items() if not name.startswith("nu_")}


def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
    """Return the angle record of the given initial values."""
    return given_angles(Angles, data, z)


VECTOR = Form(
    "vector",
    VECTOR_UNITS,
    vector_rates,
    vector_scalars,
    vector_of_angles,
    angles_of_vector,
    integrals=(
        *place(vector.velocity),
        integral("impulse", vector.vertical_force),
    ),
    orientation=carried_along(axis, axis_rate, vector.spin),
)
EULER = Form(
    "euler",
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    euler_of_angles,
    angles_of_euler,
    integrals=(
        integral("phi", lambda q, carried, b: q.phi_dot),
        *place(euler.velocity),
        integral("impulse", euler.vertical_force),
    ),
    orientation=by_angles(sine_and_cosine, psi_rate),
    domains=(gliding.AWAY_FROM_POLE,),
)
UNDEFINED_AT_POLES = ("phi", "phi_dot")
FORMS = {form.name: form for form in (VECTOR, EULER)}

LIFTOFF = replace(
    gliding.LIFTOFF,
    long_name="normal force falls to zero: beyond it the model does not hold",
    formula=normal_force,
)
EVENTS = (gliding.TURNING, LIFTOFF, gliding.EQUATOR, gliding.INVERTED)

REACTION = (
    Quantity("normal_force", "F_z", NEWTON, "normal force", normal_force),
    Quantity(
        "horizontal_force", "|F_h|", NEWTON, "horizontal part of the reaction", horizontal_force
    ),
    Quantity(
        "friction_needed",
        "|F_h|/F_z",
        ONE,
        "Coulomb friction coefficient that rolling needs",
        friction_needed,
    ),
)
