"""Set-valued Coulomb friction at the contact of a ball: slip along a direction, rolling, and its cone. [contact 2]

A slip direction n is a horizontal unit vector; F = N (zhat - mu n). Everything is singular only where the contact jams
(Painleve: K_zz - mu n_e K_ez = 0, which `uniqueness.painleve_bound` excludes).
"""

from ..operand import Vector, formula
from .body import height
from .response import Components, bias_vector, contact_acceleration_vector, mobility_inverse_times, torque_acceleration


# --- slip ------------------------------------------------------------------------------------------------------------


@formula
def slip_normal_force(b, K, n_e, body):
    """N of slip [N], from b_z + zhat.K F = 0; falls through zero where the ball lifts off. [T 3.34 with mu n]"""
    return -b.z / (K.zz - body.friction.mu * n_e * K.ez)


@formula
def slip_force(b, K, n_e, n_t, body):
    """F of slip along n = n_e e + n_t 2hat, Components [N]."""
    N = slip_normal_force(b, K, n_e, body)
    return Components(-(body.friction.mu * N * n_e), -(body.friction.mu * N * n_t), N)


@formula
def response(u, push, b):
    """zhat.K(zhat - push) [1/kg]: upward acceleration of the contact point for N = 1 and the horizontal force -push."""
    lever = b.c * (u.x * u.x + u.y * u.y) - height(u.z, b) * (u.x * push.x + u.y * push.y)
    return 1 / b.m + b.c * lever / b.I1


@formula
def loaded_normal_force(u, b, push, tau, body):
    """N [N] where the friction -N push, horizontal, and beside it the torque N tau act: of a patch that drills."""
    return -b.z / (response(u, push, body) + torque_acceleration(u, tau, body).z)


@formula
def slip_normal_force_vector(u, b, n, body):
    """N of slip along n, a horizontal unit Vector [N]."""
    return -b.z / response(u, Vector(body.friction.mu * n.x, body.friction.mu * n.y, 0), body)


@formula
def slip_force_vector(u, b, n, body):
    """F of slip along n, a horizontal unit Vector, (3,) [N]."""
    N = slip_normal_force_vector(u, b, n, body)
    return Vector(-(body.friction.mu * N * n.x), -(body.friction.mu * N * n.y), N)


@formula
def along_and_across(G, n):
    """P = n.G, the rate of the slip speed w, and Q = (zhat x n).G, w times the turn of n in space; Vectors [m/s^2]."""
    return n.x * G.x + n.y * G.y, n.x * G.y - n.y * G.x


@formula
def slip_motion(u, L, n, body):
    """F, P and Q of slip along the horizontal unit Vector n: force (3,) [N], rate of w, w times the turn of n."""
    b = bias_vector(u, L, body)
    F = slip_force_vector(u, b, n, body)
    P, Q = along_and_across(contact_acceleration_vector(u, b, F, body), n)
    return F, P, Q


# --- rolling ---------------------------------------------------------------------------------------------------------


@formula
def reaction_of_rolling(b, K):
    """F that keeps the contact point at rest, Components [N]. [contact 2.3]"""
    det = K.ee * K.zz - K.ez**2
    return Components((K.ez * b.z - K.zz * b.e) / det, -b.t / K.tt, (K.ez * b.e - K.ee * b.z) / det)


@formula
def reaction_of_rolling_vector(u, b, body):
    """F that keeps the contact point at rest, (3,) [N]: -K^-1 b."""
    F = mobility_inverse_times(u, b, body)
    return Vector(-F.x, -F.y, -F.z)


@formula
def cone(F_1, F_2, N, mu):
    """mu^2 N^2 - |F_h|^2 [N^2] of two horizontal components: falls through zero where rolling ends."""
    return mu**2 * N**2 - F_1**2 - F_2**2
