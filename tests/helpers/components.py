"""The response at a contact and Coulomb's law by angles, along e, 2hat and zhat: an oracle for
those of vectors.

K is that of `response.mobility`; everything is singular at the poles.
"""

from typing import Any, NamedTuple

from tippetop.mechanics.contact.body import height
from tippetop.mechanics.contact.response import Mobility


class Components(NamedTuple):
    """Components of a vector along e, 2hat and zhat."""

    e: Any
    t: Any
    z: Any


def bias(s: Any, z: Any, theta_dot: Any, phi_dot: Any, omega3: Any, b: Any) -> Components:
    """Return the acceleration of the contact point without a force there. [contact 1]"""
    H, q, swing = height(z, b), b.c - b.R * z, theta_dot**2 + (phi_dot * s) ** 2
    return Components(
        s * phi_dot * omega3 * (b.I3 * H / b.I1 - b.R) - b.c * (s * swing),
        omega3 * theta_dot * (b.I3 * q / b.I1 + b.R * z),
        -b.g - b.c * (z * swing - b.I3 * (phi_dot * omega3 * s**2) / b.I1),
    )


def contact_acceleration(b: Components, K: Mobility, F: Components) -> Components:
    """Return b + K F."""
    return Components(
        b.e + K.ee * F.e + K.ez * F.z, b.t + K.tt * F.t, b.z + K.ez * F.e + K.zz * F.z
    )


def slip_force(b: Components, K: Mobility, n_e: Any, n_t: Any, mu: Any) -> Components:
    """Return the force of slip along n = n_e e + n_t 2hat."""
    N = -b.z / (K.zz - mu * n_e * K.ez)
    return Components(-(mu * N * n_e), -(mu * N * n_t), N)


def reaction_of_rolling(b: Components, K: Mobility) -> Components:
    """Return the force that keeps the contact point at rest. [contact 2.3]"""
    det = K.ee * K.zz - K.ez**2
    return Components((K.ez * b.z - K.zz * b.e) / det, -b.t / K.tt, (K.ez * b.e - K.ee * b.z) / det)
