"""The rolling tippe top: the sphere of `tippe_top`, whose contact point is at rest, v_A = 0.

[T ch. 4]
"""

from ..contact import body as contact
from ..contact.gliding import catalogue as gliding
from ..contact.rolling import catalogue as rolling
from ..contact.rolling import euler as rolling_euler
from ..system import Quantity, of_one_phase
from ..units import ANGULAR_MOMENTUM
from . import outlook, tippe_top
from .tippe_top_contact import CONTACT
from .tippe_top_reduced import REDUCED


ROLLING_TIPPE_TOP = of_one_phase(
    "roll",
    name="rolling-tippe-top",
    title="tippe top in pure rolling",
    source="Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping "
    "(2010), chapter 4",
    parameters=tippe_top.TippeTop.parameters,
    body=tippe_top.TippeTop.body_of,
    body_units=contact.body_units,
    scales=lambda b: (b.m, b.R),
    normalised_to={"m": 1.0, "R": 1.0},
    initial=rolling.INITIAL,
    alternatives=(gliding.BY_PSI_DOT,),
    start=rolling.start,
    angles=rolling_euler.ANGLES,
    forms={
        "contact": CONTACT,
        "vector": rolling.VECTOR,
        "reduced": REDUCED,
        "euler": rolling.EULER,
    },
    quantities=(
        gliding.JELLETT_QUANTITY,
        Quantity("routh", "D", ANGULAR_MOMENTUM, "Routh's function", tippe_top.routh),
        *gliding.ENERGIES,
        *rolling.REACTION,
    ),
    integrals=("jellett", "routh", "energy"),
    events=rolling.EVENTS,
    long_names=gliding.LONG_NAMES,
    vectors=gliding.VECTORS,
    undefined_at_poles=rolling.UNDEFINED_AT_POLES,
    checks=tippe_top.TippeTop.faults,
    potential=tippe_top.potential,
    theta_inertia=tippe_top.theta_inertia,
    momenta=("routh", "jellett"),
    landscape=tippe_top.LANDSCAPE,
    outlook=outlook.rolling_tippe_top,
    long_form="reduced",
    classes=tippe_top.TIPPE_TOP.classes,
)
