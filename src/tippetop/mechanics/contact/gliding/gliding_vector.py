"""The gliding body in vector form: regular everywhere. [T 3.12, 3.17, 5.2]"""

from ...friction import slip_coefficient
from ...operand import Vector, formula
from ...units import ANGULAR_MOMENTUM, METRE_PER_SECOND
from .. import body as contact
from ..body import Scalars, Turning, kinematics, state


VECTOR_UNITS = state(L3=ANGULAR_MOMENTUM, rx_dot=METRE_PER_SECOND, ry_dot=METRE_PER_SECOND)
"""3hat, L and L_3 = L.3hat about the centre of mass, velocity of the centre of mass.

L_3 is carried because L_3' and L_z' are one product: it saves three.
"""

VectorState = type(VECTOR_UNITS)


@formula
def axis(q):
    """Return 3hat, unit vector along the axis of the body, (3,), space frame."""
    return Vector(q.ux, q.uy, q.uz)


@formula
def turning(q):
    """Return 3hat and L, the angular momentum about the centre of mass, space frame [kg m^2/s]."""
    return Turning(axis(q), Vector(q.Lx, q.Ly, q.Lz))


@formula
def axis_rate(q, b):
    """Return 3hat' = L x 3hat/I1 [1/s]. [T 3.17]"""
    return contact.axis_rate(turning(q), b)


@formula
def sliding_velocity(q, b):
    """Return v_A = r' + omega x a, horizontal, (3,) [m/s]. [T 3.3]

    `body.contact_velocity` with the carried L_3, summed from the left.
    """
    u_dot, w = axis_rate(q, b), contact.angular_velocity_of(turning(q), q.L3, b)
    return Vector(q.rx_dot + b.c * u_dot.x - b.R * w.y, q.ry_dot + b.c * u_dot.y + b.R * w.x, 0.0)


@formula
def vector_scalars(q, b):
    """Return the scalars of a vector state.

    L_3 is L.3hat, so that the carried L_3 is under control too.
    """
    u, v = axis(q), sliding_velocity(q, b)
    return Scalars(
        *kinematics(turning(q), axis_rate(q, b), b),
        u.x * v.x + u.y * v.y,
        u.x * v.y - u.y * v.x,
        v.x * v.x + v.y * v.y,
        q.rx_dot**2 + q.ry_dot**2,
    )


@formula
def reaction(q, b):
    """Return F = N (zhat - k v_A), (3,) [N]. [T 3.16; contact 2.1]"""
    s, v = vector_scalars(q, b), sliding_velocity(q, b)
    N = contact.g_n(s, b)
    k = -(slip_coefficient(s.v2, s.z, b.friction) * N)
    return Vector(k * v.x, k * v.y, N)


@formula
def vector_rates(q, b):
    """Return 3hat' = L x 3hat/I1, L' = a x F, m r'' = F_h. [T 3.12, 3.17; 5.2]"""
    u, F = axis(q), reaction(q, b)
    L3_rate = b.R * (u.x * F.y - u.y * F.x)
    return VectorState(*axis_rate(q, b), *contact.moment(u, F, b), L3_rate, F.x / b.m, F.y / b.m)
