"""The rolling tippe top: the sphere of `tippe_top`, whose contact point is at rest, v_A = 0.

[T ch. 4]
"""

from ..contact import gliding, rolling
from ..system import of_one_phase
from . import outlook, tippe_top
from .tippe_top_contact import CONTACT
from .tippe_top_reduced import REDUCED


ROLLING_TIPPE_TOP = of_one_phase(
    "roll",
    name="rolling-tippe-top",
    title="tippe top in pure rolling",
    source=tippe_top.SOURCE + "4",
    quantities=(
        *tippe_top.MOMENTA,
        *gliding.ENERGIES,
        *rolling.REACTION,
    ),
    outlook=outlook.rolling_tippe_top,
    **rolling.OF_SYSTEM
    | {
        "forms": {
            "contact": CONTACT,
            "vector": rolling.VECTOR,
            "reduced": REDUCED,
            "euler": rolling.EULER,
        },
        "integrals": ("jellett", "routh", "energy"),
    },
    **tippe_top.COMMON,
)
