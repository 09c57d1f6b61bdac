"""The gliding heavy top: the top of `heavy_top` whose tip glides on a plane. [T ch. 5]

It is the body of `gliding` with R = 0, c = -l; here is what only it has: the form about the contact
point.
"""

from typing import NamedTuple

from ..contact import body as contact
from ..contact.gliding import catalogue as gliding
from ..contact.gliding import chart as gliding_chart
from ..contact.gliding import euler as gliding_euler
from ..contact.gliding import rates
from ..contact.gliding.vector import axis
from ..contact.integrals import integral
from ..contact.orientation import carried_along
from ..contact.rolling import reaction
from ..contact.rolling import vector as rolling_vector
from ..friction import LAWS, slip_coefficient
from ..operand import Operand, Vector, cos, cross, formula, plus, sin, times
from ..system import Form, Opening, Quantity, of_one_phase
from ..units import ANGULAR_MOMENTUM, METRE_PER_SECOND, ONE
from . import heavy_top, outlook
from .tippe_top import SOURCE


@formula
def Lz_rate(push_n, b):
    """Return L_z' = m (zhat x a).(dv_A/dt) [kg m^2/s^2] while gliding.

    push_n is (zhat x 3hat).(dv_A/dt).

    [T 5.19]
    """
    return b.m * b.c * push_n


# --- gliding: the vector form about the contact -------------------------------------------------


class ContactState(NamedTuple):
    """3hat, angular momentum L_A about the contact, contact velocity v_A."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    vx: Operand
    vy: Operand


CONTACT_UNITS = ContactState._make(
    (*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 2)
)


@formula
def contact_scalars(q, b):
    """Return the scalars of a state about the contact."""
    u, u_dot = axis(q), heavy_top.tip_axis_rate(q, b)
    s = reaction.kinematics(u, heavy_top.momentum_about_centre(q, b), u_dot, b)
    v_u, v_n = u.x * q.vx + u.y * q.vy, u.x * q.vy - u.y * q.vx
    speed2 = (q.vx - b.c * u_dot.x) ** 2 + (q.vy - b.c * u_dot.y) ** 2
    return contact.Scalars(
        z=s.z,
        s2=s.s2,
        z_dot=s.z_dot,
        z_ddot_free=s.z_ddot_free,
        phi_dot_s2=s.phi_dot_s2,
        axis_speed2=s.axis_speed2,
        L3=s.L3,
        Lz=s.Lz,
        v_u=v_u,
        v_n=v_n,
        v2=q.vx**2 + q.vy**2,
        speed2=speed2,
    )


@formula
def contact_rates(q, b):
    """Return 3hat' = L_A x 3hat/I1*, L_A' = m a x (g zhat + dv_A/dt), and v_A'.

    v_A' = F/m - g zhat + c 3hat''. [T 5.4]
    """
    u, u_dot, s = axis(q), heavy_top.tip_axis_rate(q, b), contact_scalars(q, b)
    N = contact.g_n(s, b)
    slip = slip_coefficient(s.v2, s.z, b.friction) * N
    F = Vector(-(slip * q.vx), -(slip * q.vy), N)
    L = heavy_top.momentum_about_centre(q, b)
    u_dot2 = times(1 / b.I1, plus(cross(times(b.c, cross(u, F)), u), cross(L, u_dot)))
    v_dot = Vector(F.x / b.m + b.c * u_dot2.x, F.y / b.m + b.c * u_dot2.y, 0)
    pull = b.m * b.c
    return ContactState(
        u_dot.x,
        u_dot.y,
        u_dot.z,
        pull * (u.y * b.g - u.z * v_dot.y),
        pull * (u.z * v_dot.x - u.x * b.g),
        pull * (u.x * v_dot.y - u.y * v_dot.x),
        v_dot.x,
        v_dot.y,
    )


@formula
def work_rate(q, carried, b):
    """Return the power that friction takes [W]."""
    s = contact_scalars(q, b)
    return slip_coefficient(s.v2, s.z, b.friction) * contact.g_n(s, b) * s.v2


@formula
def contact_of_angles(e, s, z, b):
    """Return the state about the contact of the angles. [section 1]"""
    u, L = gliding_chart.axis_and_momentum(e, s, z, heavy_top.tip_inertia(b), b.I3)
    ex, ey = cos(e.phi), sin(e.phi)
    v = e.nu_x * ex - e.nu_y * ey, e.nu_x * ey + e.nu_y * ex
    return ContactState(u.x, u.y, u.z, L.x, L.y, L.z, v[0], v[1])


@formula
def angles_of_contact(q, carried, b):
    """Return the angles of a state about the contact; 0/0 exactly at a pole. [section 3.4]"""
    return gliding_chart.gliding_angles(contact_scalars(q, b), axis(q), carried, b)


CONTACT = Form(
    "contact",
    CONTACT_UNITS,
    contact_rates,
    contact_scalars,
    contact_of_angles,
    angles_of_contact,
    integrals=(
        integral("x", lambda q, carried, b: q.vx - b.c * heavy_top.tip_axis_rate(q, b).x),
        integral("y", lambda q, carried, b: q.vy - b.c * heavy_top.tip_axis_rate(q, b).y),
        integral("work", work_rate),
        integral("impulse", lambda q, carried, b: contact.g_n(contact_scalars(q, b), b)),
    ),
    orientation=carried_along(axis, heavy_top.tip_axis_rate, rolling_vector.spin),
    domains=(gliding.NOT_JAMMED,),
)


@formula
def own_Lz_rate(s, b):
    """Return L_z' about the tip [kg m^2/s^2] of the state itself. [T 5.19]"""
    return Lz_rate(rates.push_n(s, b), b)


GLIDING_HEAVY_TOP = of_one_phase(
    "slip",
    name="gliding-heavy-top",
    title="heavy symmetric top whose tip glides on a plane",
    source=SOURCE + "5",
    initial=gliding.INITIAL,
    alternatives=gliding.ALTERNATIVES,
    start=gliding.start,
    angles=gliding_euler.ANGLES,
    forms={"vector": gliding.VECTOR, "contact": CONTACT, "euler": gliding.EULER},
    quantities=(*heavy_top.MOMENTA, *gliding.QUANTITIES),
    on_request=(
        Quantity("Lz_rate", "L_z'", rates.TORQUE, "rate of L_z about the tip", own_Lz_rate),
        rates.MODIFIED_ENERGY_RATE,
    ),
    integrals=("L3",),
    events=(gliding.TURNING, gliding.LIFTOFF, gliding.FALLEN, gliding.SETTLED),
    undefined_at_poles=gliding.UNDEFINED_AT_POLES,
    long_names=gliding.LONG_NAMES,
    laws=LAWS,
    outlook=outlook.gliding_heavy_top,
    opening=Opening(without=("L3", "Lz")),
    **heavy_top.COMMON,
)
