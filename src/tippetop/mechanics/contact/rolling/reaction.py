"""A body of revolution whose contact point is at rest, v_A = 0: contact arm a = c*3hat - R*zhat as
in `gliding`.

c = alpha*R is the rolling tippe top; R = 0, c = -l a top with its tip fixed. The reaction F = m s''
+ m g zhat at the contact follows from the motion, and is not vertical. Every formula takes its
parameters as a `contact.body.Touch`.
"""

from ...operand import formula, sqrt, times
from .. import body as contact
from ..response import bias_vector, mobility_inverse_times


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
def push_across(s, b):
    """Return (3hat x F).zhat [N]: horizontal reaction across the lean, times sin(theta)."""
    slope = b.I1 * (b.R * s.z) + b.I3 * (b.c - b.R * s.z)
    return b.m * (s.L3 * s.z_dot) * slope / spin_determinant(s.z, b)


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
def reaction(x, b):
    """Return the reaction F = m s'' + m g zhat at a contact at rest, (3,), space frame [N]."""
    return times(-1, mobility_inverse_times(x.u, bias_vector(x, b), b))


@formula
def scalars(x, u_dot, v, b):
    """Return the scalars; u_dot is 3hat', v is the velocity of the centre of mass."""
    F = reaction(x, b)
    return Scalars(*contact.kinematics(x, u_dot, b), v.x**2 + v.y**2, F.x**2 + F.y**2)


@formula
def scalars_by_kinematics(s, b):
    """Return the scalars, 0/0 at a pole: the reaction has parts along and across the lean."""
    speed2 = contact.arm_speed2(s, b) - (b.c * s.z_dot) ** 2
    return Scalars(*s, speed2, (push_along(s, b) ** 2 + push_across(s, b) ** 2) / s.s2)
