"""What people give and read of a rolling body: initial data, forms, events, quantities."""

from dataclasses import replace
from typing import Any

from ...system import Form, Quantity
from ...units import NEWTON, ONE
from ..body import Body
from ..gliding import catalogue as gliding
from ..gliding import chart as gliding_chart
from ..gliding.catalogue import given_angles
from .chart import angles_of_euler, angles_of_vector, vector_of_angles
from .euler import EULER_UNITS, EulerState, euler_rates, euler_scalars
from .reaction import friction_needed, horizontal_force, normal_force
from .vector import QUADRATURES, VECTOR_UNITS, vector_rates, vector_scalars


# --- initial data, events, quantities -------------------------------------------------------------------------------

INITIAL = {name: p for name, p in gliding.INITIAL.items() if not name.startswith("nu_")}


def start(data: dict[str, Any], s: Any, z: Any, b: Body) -> EulerState:
    """The Euler record of what a person gave."""
    return given_angles(EulerState, data, z)


VECTOR = Form("vector", VECTOR_UNITS, vector_rates, vector_scalars, vector_of_angles, angles_of_vector, QUADRATURES)
EULER = Form(
    "euler",
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    gliding_chart.euler_of_angles,
    angles_of_euler,
    ("phi", *QUADRATURES),
    (gliding.POLE,),
)
FORMS = {form.name: form for form in (VECTOR, EULER)}

LIFTOFF = replace(
    gliding.LIFTOFF, long_name="normal force falls to zero: beyond it the model does not hold", formula=normal_force
)
EVENTS = (gliding.TURNING, LIFTOFF, gliding.EQUATOR, gliding.INVERTED)

REACTION = (
    Quantity("normal_force", "F_z", NEWTON, "normal force", normal_force),
    Quantity("horizontal_force", "|F_h|", NEWTON, "horizontal part of the reaction", horizontal_force),
    Quantity("friction_needed", "|F_h|/F_z", ONE, "Coulomb friction coefficient that rolling needs", friction_needed),
)
