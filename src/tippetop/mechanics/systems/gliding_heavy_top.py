"""The gliding heavy top: the top of `heavy_top` whose tip glides on a plane. [T ch. 5]

It is the body of `gliding` with R = 0, c = -l.
"""

from ..contact import body as contact
from ..contact import gliding
from ..operand import formula
from ..system import Opening, Quantity, of_one_phase
from . import heavy_top, outlook
from .tippe_top import SOURCE


@formula
def Lz_rate(push_n, b):
    """Return Lz' = m (zhat x a).(dv_A/dt) [kg m^2/s^2] about the tip; push_n: see `body.push_n`.

    It is the rate of `heavy_top.Lz`, as a = c 3hat.

    [T 5.19]
    """
    return b.m * b.c * push_n


@formula
def own_Lz_rate(s, b):
    """Return Lz' about the tip [kg m^2/s^2] of a gliding state with the scalars s. [T 5.19]"""
    return Lz_rate(contact.push_n(s, b), b)


GLIDING_HEAVY_TOP = of_one_phase(
    "slip",
    name="gliding-heavy-top",
    title="heavy symmetric top whose tip glides on a plane",
    source=SOURCE + "5",
    quantities=(*heavy_top.MOMENTA, *gliding.QUANTITIES),
    on_request=(
        Quantity("Lz_rate", "L_z'", gliding.TORQUE, "rate of L_z about the tip", own_Lz_rate),
        gliding.MODIFIED_ENERGY_RATE,
    ),
    integrals=("L3",),
    outlook=outlook.gliding_heavy_top,
    opening=Opening(without=("L3", "Lz")),
    **gliding.OF_SYSTEM
    | {"events": (gliding.TURNING, gliding.LIFTOFF, gliding.FALLEN, gliding.SETTLED)},
    **heavy_top.COMMON,
)
