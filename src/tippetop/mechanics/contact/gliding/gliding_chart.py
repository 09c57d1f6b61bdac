"""The chart between Euler angles and vectors. [T 3.20-3.22; section 3.4 of the derivation]"""

from collections.abc import Callable
from typing import Any

from ...operand import Vector, atan2, cos, formula, sin, sqrt
from ...system import Domain, Form, Integral
from ..body import Turning, of_azimuth
from ..body_axes import by_angles
from ..integrals import integral
from .gliding_euler import ANGLES, centre_velocity, psi_rate, sine_and_cosine
from .gliding_vector import VectorState, axis, vector_scalars


@formula
def axis_and_momentum(e, s, z, I1, I3):
    """Return 3hat and L of a body with the transverse moment I1 and the axial moment I3.

    [section 1]
    """
    ex, ey = cos(e.phi), sin(e.phi)
    L3, transverse, nodal = I3 * e.omega3, -(I1 * e.phi_dot * s), I1 * e.theta_dot
    lean = transverse * z + L3 * s  # L along e; 1hat = z e - s zhat
    L = Vector(lean * ex - nodal * ey, lean * ey + nodal * ex, L3 * z - transverse * s)
    return Turning(Vector(s * ex, s * ey, z), L)


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    along_e, along_2 = centre_velocity(e, s, z, b)
    velocity = of_azimuth(along_e, along_2, e.phi)
    return VectorState(*u, *L, b.I3 * e.omega3, *velocity)


def angles_by(units: Any, scalars: Callable) -> Callable:
    """Return to_angles(q, carried, b) of a form whose state has the axis.

    The angles are 0/0 exactly at a pole, where phi is undefined. theta is atan2(sin, cos): no
    digits are lost near the poles. [section 3.4]

    Parameters
    ----------
    units
        The record of the angles; fields that the scalars do not give are integrals.
    scalars
        scalars(q, b) of the form.
    """

    def to_angles(q: Any, carried: Any, b: Any) -> Any:
        c, u = scalars(q, b), axis(q)
        s = sqrt(c.s2)
        known = {
            "theta": atan2(s, c.z),
            "theta_dot": -c.z_dot / s,
            "phi_dot": c.phi_dot_s2 / c.s2,
            "omega3": c.L3 / b.I3,
            "phi": atan2(u.y, u.x),
        }
        if hasattr(c, "v_u"):
            known |= {"nu_x": c.v_u / s, "nu_y": c.v_n / s}
        if hasattr(c, "rise"):
            known |= {"nu_z": c.rise, "gap": c.gap}
        return type(units)(
            *(known[name] if name in known else getattr(carried, name) for name in units._fields)
        )

    return to_angles


angles_of_vector = angles_by(ANGLES, vector_scalars)

AWAY_FROM_POLE = Domain(
    formula(lambda s, b: s.s2),
    'this form is singular where sin(theta) = 0: use form = "vector"',
)


def in_euler_angles(
    vector: Form,
    angles: Any,
    units: Any,
    rates: Callable,
    scalars: Callable,
    integrals: tuple[Integral, ...],
    *domains: Domain,
) -> Form:
    """Return the form of a body in Euler angles, in addition to its vector form.

    Parameters
    ----------
    vector
        The vector form: by way of it theta is brought to [0, pi], and phi to (-pi, pi].
    angles
        The record of the angles.
    units
        The state: the first of the angles.
    rates, scalars, integrals, domains
        As of a `Form`, without phi.
    """

    def to_angles(q: Any, carried: Any, b: Any) -> Any:
        sources = (q if name in q._fields else carried for name in angles._fields)
        e = type(angles)(*map(getattr, sources, angles._fields))
        state = vector.of_angles(e, sin(e.theta), cos(e.theta), b)
        return vector.to_angles(state, carried, b)

    return Form(
        "euler",
        units,
        rates,
        scalars,
        lambda e, s, z, b: type(units)(*e[: len(units)]),
        to_angles,
        integrals=(integral("phi", lambda q, carried, b: q.phi_dot), *integrals),
        orientation=by_angles(sine_and_cosine, psi_rate),
        domains=(*domains, AWAY_FROM_POLE),
    )
