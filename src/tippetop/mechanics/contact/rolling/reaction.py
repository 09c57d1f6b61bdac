"""A body of revolution whose contact point is at rest, v_A = 0: contact arm a = c*3hat - R*zhat as
in `gliding`.

c = alpha*R is the rolling tippe top; R = 0, c = -l a top with its tip fixed. The reaction F = m s''
+ m g zhat at the contact follows from the motion, and is not vertical. Every formula takes its
parameters as a `contact.body.Touch`.
"""

from ...operand import Vector, cross, formula, plus, sqrt, times
from .. import body as contact


FIELDS = (*contact.Kinematics._fields, "speed2", "friction_force2")
Scalars = type(contact.filled(**dict.fromkeys(FIELDS)))
"""The kinematics, |r'|^2 of the horizontal velocity of the centre of mass, and |F_h|^2 of the
horizontal part of the reaction.
"""


# --- the reaction -------------------------------------------------------------------------------


@formula
def motion_terms(s, b):
    """Return q |3hat'|^2 + R omega_3 phi' sin(theta)^2, q = c - R z [m/s^2].

    v_A = 0 requires it of F.3hat, beyond z''.
    """
    return (b.c - b.R * s.z) * s.axis_speed2 + b.R * (s.L3 / b.I3) * s.phi_dot_s2


@formula
def z_dot2(s, b):
    """Return z'' [1/s^2], from v_A = 0. [equal to T 4.2]"""
    h = contact.height(s.z, b)
    drive = b.c * (b.g * s.s2) + h * motion_terms(s, b)
    return (b.I1 * s.z_ddot_free + b.m * drive) / (b.I1 + b.m * contact.arm2(s.z, b))


@formula
def normal_force(s, b):
    """Return the normal force F_z = m (g - c z'') [N]."""
    return b.m * (b.g - b.c * z_dot2(s, b))


@formula
def push_along(s, b):
    """Return F_h.3hat [N]: horizontal reaction along the lean of the axis, times sin(theta)."""
    return b.m * (motion_terms(s, b) - contact.height(s.z, b) * z_dot2(s, b))


@formula
def spin_rate(s, b):
    """Return omega_3' [1/s^2]. [T 4.4]"""
    q = b.c - b.R * s.z
    slope = b.I1 * (b.R * s.z) + b.I3 * q
    return b.m * b.R * (s.L3 / b.I3 * s.z_dot) * slope / spin_determinant(s.z, b)


@formula
def spin_determinant(z, b):
    """Return I3^2 d(z) = I1 I3 + m R^2 I1 sin(theta)^2 + m I3 (c - R z)^2 [kg^2 m^4]. [T 4.2]"""
    return b.I1 * b.I3 + b.m * (b.R**2 * b.I1 * ((1 - z) * (1 + z)) + b.I3 * (b.c - b.R * z) ** 2)


@formula
def horizontal_force(s, b):
    """Return the size of the horizontal part of the reaction, |F_h| [N]."""
    return sqrt(s.friction_force2)


@formula
def friction_needed(s, b):
    """Return the coefficient of Coulomb friction that pure rolling needs, |F_h|/F_z."""
    return sqrt(s.friction_force2) / normal_force(s, b)


@formula
def reaction(u, L, u_dot, s, b):
    """Return the reaction F = m s'' + m g zhat at a contact at rest, (3,), space frame [N].

    s are the kinematics.

    From L' = a x F, 3hat'' = (L' x 3hat + L x 3hat')/I1 and s' = -omega x a; F.3hat and z'' are
    known in advance.
    """
    q, N, z_ddot = b.c - b.R * u.z, normal_force(s, b), z_dot2(s, b)
    F3 = push_along(s, b) + N * u.z  # F.3hat
    free = plus(
        cross(L, u_dot), times(-(b.c * F3), u)
    )  # I1 3hat'' without q F and its vertical part
    spin, w3, contact_mobility = spin_rate(s, b), s.L3 / b.I3, 1 + b.m * q**2 / b.I1
    x = q / b.I1 * free.x + b.R * (z_ddot * u.x - spin * u.y - w3 * u_dot.y)
    y = q / b.I1 * free.y + b.R * (z_ddot * u.y + spin * u.x + w3 * u_dot.x)
    return Vector(-(b.m * x) / contact_mobility, -(b.m * y) / contact_mobility, N)


@formula
def completed(s, v, F):
    """Return the scalars, of kinematics s, velocity v of the centre of mass, and force F."""
    return Scalars(*s, v.x**2 + v.y**2, F.x**2 + F.y**2)
