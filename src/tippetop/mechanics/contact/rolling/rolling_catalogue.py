"""Input and output of a rolling body: initial data, forms, events, quantities."""

from dataclasses import replace

from ...system import Form, Quantity
from ...units import NEWTON, ONE
from ..body_axes import carried_along
from ..gliding import gliding_catalogue as gliding
from ..gliding.gliding_chart import in_euler_angles
from ..gliding.gliding_vector import axis, axis_rate
from ..integrals import integral, place
from . import rolling_euler, rolling_vector
from .reaction import friction_needed, horizontal_force, normal_force
from .rolling_euler import ANGLES, EULER_UNITS, euler_rates, euler_scalars


# --- initial data, events, quantities -----------------------------------------------------------

INITIAL = {name: p for name, p in gliding.INITIAL.items() if not name.startswith("nu_")}


VECTOR = Form(
    "vector",
    rolling_vector.VECTOR_UNITS,
    rolling_vector.vector_rates,
    rolling_vector.vector_scalars,
    rolling_vector.vector_of_angles,
    rolling_vector.angles_of_vector,
    integrals=(
        *place(rolling_vector.velocity),
        integral("impulse", lambda q, carried, b: rolling_vector.force(q, b).z),
    ),
    orientation=carried_along(axis, axis_rate, rolling_vector.spin),
)
EULER = in_euler_angles(
    VECTOR,
    ANGLES,
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    (*place(rolling_euler.velocity), integral("impulse", rolling_euler.vertical_force)),
)
UNDEFINED_AT_POLES = ("phi", "phi_dot")
FORMS = {form.name: form for form in (VECTOR, EULER)}

LIFTOFF = replace(
    gliding.LIFTOFF,
    long_name="normal force falls to zero: beyond it the model is not valid",
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
