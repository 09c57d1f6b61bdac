"""Systems, friction laws, events and columns of the user."""

from .library.registering import LAWS, SYSTEMS, outline, register
from .mechanics import units
from .mechanics.contact.outline import root
from .mechanics.event import Event, Kept
from .mechanics.form import Exit, Form, Integral, Next, Phase
from .mechanics.friction import FrictionLaw
from .mechanics.number import Number, number
from .mechanics.system import Quantity, System
from .mechanics.units import Unit


__all__ = [
    "LAWS",
    "SYSTEMS",
    "Event",
    "Exit",
    "Form",
    "FrictionLaw",
    "Integral",
    "Kept",
    "Next",
    "Number",
    "Phase",
    "Quantity",
    "System",
    "Unit",
    "number",
    "outline",
    "register",
    "root",
    "units",
]
