"""The acceleration of a gliding contact, and the rates of momenta and modified energy that follow
from it.
"""

from ...friction import slip_coefficient
from ...operand import formula
from ...system import Quantity
from ...units import WATT, Unit
from .. import body as contact


@formula
def twist(s, b):
    """Return (3hat x F).zhat of the friction [N].

    L_3' = R twist, L_z' = c twist about the centre of mass.

    [T 3.11, 3.26]
    """
    return -(slip_coefficient(s.v2, s.z, b.friction) * contact.g_n(s, b) * s.v_n)


@formula
def push_u(s, b):
    """Return 3hat.(dv_A/dt) [m/s^2]. [T 3.32, corrected]"""
    N, h = contact.g_n(s, b), contact.height(s.z, b)
    drag = slip_coefficient(s.v2, s.z, b.friction) * N * s.v_u
    turn = s.L3 / b.I3 * s.phi_dot_s2 * (b.I3 * h - b.I1 * b.R) + b.c * s.s2 * (
        h * N - b.I1 * s.axis_speed2
    )
    return turn / b.I1 - drag * (1 / b.m + h**2 / b.I1)


@formula
def push_n(s, b):
    """Return (zhat x 3hat).(dv_A/dt) [m/s^2]. [T 3.33]"""
    q = b.c - b.R * s.z
    mobility = 1 / b.m + q**2 / b.I1 + b.R**2 * s.s2 / b.I3
    return twist(s, b) * mobility - s.L3 / b.I3 * s.z_dot * (b.I3 * q + b.I1 * b.R * s.z) / b.I1


@formula
def modified_energy_rate(s, b):
    """Return E~' = m (omega x a).(dv_A/dt) [W] of the state itself; 0/0 exactly at a pole.

    [T 4.22, 5.24, corrected]
    """
    return contact.modified_energy_rate(push_u(s, b), push_n(s, b), s, b)


TORQUE = Unit("kg m2 s-2")
MODIFIED_ENERGY_RATE = Quantity(
    "modified_energy_rate", "E~'", WATT, "rate of the modified energy", modified_energy_rate
)
