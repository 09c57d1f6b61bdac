"""The gliding body in vector form: regular everywhere. [T 3.12, 3.17, 5.2]"""

from typing import NamedTuple

from ...friction import slip_coefficient
from ...operand import Operand, Vector, dot, formula, times
from ...units import ANGULAR_MOMENTUM, METRE_PER_SECOND, ONE
from .. import body as contact
from ..body import Scalars, g_n, height


class VectorState(NamedTuple):
    """3hat, L and L_3 = L.3hat about the centre of mass, velocity of the centre of mass.

    L_3 is carried because L_3' and L_z' are one product: it saves three.
    """

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    L3: Operand
    rx_dot: Operand
    ry_dot: Operand


VECTOR_UNITS = VectorState._make((*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 4, *(METRE_PER_SECOND,) * 2))


@formula
def axis(q):
    """3hat, unit vector along the axis of the body, (3,), space frame."""
    return Vector(q.ux, q.uy, q.uz)


@formula
def momentum(q):
    """Angular momentum L about the centre of mass, (3,), space frame [kg m^2/s]."""
    return Vector(q.Lx, q.Ly, q.Lz)


@formula
def axis_rate(q, b):
    """3hat' = L x 3hat/I1 [1/s]. [T 3.17]"""
    return contact.axis_rate(axis(q), momentum(q), b)


@formula
def sliding_velocity(q, b):
    """v_A = r' + omega x a, horizontal, (3,) [m/s]. [T 3.3]

    `body.contact_velocity` with the carried L_3, summed from the left."""
    u_dot, w = axis_rate(q, b), contact.angular_velocity_of(axis(q), momentum(q), q.L3, b)
    return Vector(q.rx_dot + b.c * u_dot.x - b.R * w.y, q.ry_dot + b.c * u_dot.y + b.R * w.x, 0.0)


@formula
def torque_free_fall(q, b):
    """z'' of the axis if no torque acted, (L x 3hat')_z/I1 [1/s^2]."""
    u_dot = axis_rate(q, b)
    return (q.Lx * u_dot.y - q.Ly * u_dot.x) / b.I1


@formula
def vector_scalars(q, b):
    """The scalars of a vector state.

    L_3 is L.3hat, so that the carried L_3 is under control too.
    """
    u, L = axis(q), momentum(q)
    u_dot, v = axis_rate(q, b), sliding_velocity(q, b)
    return Scalars(
        z=u.z,
        s2=u.x * u.x + u.y * u.y,
        z_dot=u_dot.z,
        z_ddot_free=torque_free_fall(q, b),
        phi_dot_s2=u.x * u_dot.y - u.y * u_dot.x,
        axis_speed2=dot(u_dot, u_dot),
        L3=dot(L, u),
        Lz=L.z,
        v_u=u.x * v.x + u.y * v.y,
        v_n=u.x * v.y - u.y * v.x,
        v2=v.x * v.x + v.y * v.y,
        speed2=q.rx_dot**2 + q.ry_dot**2,
    )


@formula
def vector_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, m r'' = F_h. [T 3.12, 3.17; 5.2]"""
    u_dot, v, scalars = axis_rate(q, b), sliding_velocity(q, b), vector_scalars(q, b)
    N = g_n(scalars, b)
    F = times(-(slip_coefficient(scalars.v2, scalars.z, b.friction) * N), v)
    h = height(q.uz, b)
    twist = q.ux * F.y - q.uy * F.x  # (3hat x F)_z
    return VectorState(
        u_dot.x,
        u_dot.y,
        u_dot.z,
        b.c * (q.uy * N) + h * F.y,
        -(b.c * (q.ux * N)) - h * F.x,
        b.c * twist,
        b.R * twist,
        F.x / b.m,
        F.y / b.m,
    )
