"""A motion in a plane, that of a cylinder: the rows and the phases of a body whose phi', omega_3 and nu_y vanish.

The axis passes the poles, and theta, which is not wrapped, is an integral of every phase.
"""

from collections import namedtuple
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...form import Form, Integral
from ...operand import Operand, Vector, formula
from ...units import JOULE, METRE, METRE_PER_SECOND, NEWTON_SECOND, ONE, RADIAN, RADIAN_PER_SECOND
from .. import body as contact
from ..integrals import NAMED, integral
from ..orientation import planar
from ..planar import slip
from ..rolling import reaction
from . import dry, legs, row


class Angles(NamedTuple):
    """theta, not wrapped, theta', velocity and height of the lowest point, place; then the integrals."""

    theta: Operand
    theta_dot: Operand
    nu_x: Operand
    nu_z: Operand
    gap: Operand
    x: Operand
    work: Operand
    impulse: Operand


ANGLES = Angles(
    RADIAN, RADIAN_PER_SECOND, METRE_PER_SECOND, METRE_PER_SECOND, METRE, METRE, JOULE, NEWTON_SECOND
)  # fmt: skip


@formula
def theta_dot(q, b):
    """theta' [rad/s] of an axis in the x-z plane."""
    u_dot = row.axis_rate(q, b)
    return q.uz * u_dot.x - q.ux * u_dot.z


THETA = Integral("theta", *NAMED["theta"], formula(lambda q, carried, b: theta_dot(q, b)))


@formula
def row_of_angles(e, s, z, b):
    """The row of the angles."""
    none = 0 * z
    whole = row.Angles(
        e.theta, e.theta_dot, none, none, e.nu_x, none, e.nu_z, e.gap, none, e.x, none, e.work, e.impulse
    )
    return row.row_of_angles(whole, s, z, b)


@formula
def angles_of_row(q, carried, b):
    """The angles of a row."""
    c = row.row_scalars(q, b)
    v = row.point_velocity(row.axis(q), row.momentum(q), Vector(q.rx_dot, q.ry_dot, q.rz_dot), q.radius, q.offset, b)
    return Angles(carried.theta, theta_dot(q, b), v.x, v.z, c.gap, carried.x, carried.work, carried.impulse)


PLANAR_ROW = replace(
    row.ROW,
    name="angle",
    of_angles=row_of_angles,
    to_angles=angles_of_row,
    integrals=(THETA, *(integral for integral in row.ROW.integrals if integral.name != "y")),
    orientation=planar(lambda q: (q.ux, q.uz)),
)


def _with_theta(form: Form, scalars: Any) -> Form:
    """A form of a phase that integrates theta too, and whose scalars know theta'."""
    known: Any = namedtuple("PlanarScalars", (*scalars._fields, "theta_dot"))  # type: ignore[misc]
    return replace(
        form,
        scalars=formula(lambda q, b: known._make((*form.scalars(q, b), theta_dot(q, b)))),
        integrals=(THETA, *(integral for integral in form.integrals if integral.name != "y")),
        orientation=PLANAR_ROW.orientation,
    )


# --- sliding under Coulomb's law itself: the direction is a sign, and v_A = 0 an ordinary zero ------------------------


class SlipState(NamedTuple):
    """sin(theta), cos(theta), theta', nu_x, and its sign."""

    s: Operand
    z: Operand
    theta_dot: Operand
    nu_x: Operand
    sigma: Operand


class SlipScalars(NamedTuple):
    """What its events read."""

    z: Operand
    theta_dot: Operand
    nu_x: Operand
    force: Operand  # normal force


@formula
def _slip(q, b):
    """The motion, by the formulas of the contact. [contact 2.7]"""
    return slip(q.s, q.z, q.theta_dot, q.sigma, b)


@formula
def slip_scalars(q, b):
    """The scalars of a state."""
    return SlipScalars(q.z, q.theta_dot, q.nu_x, _slip(q, b).N)


@formula
def slip_rates(q, b):
    """theta'' and nu_x' of sliding; the sign stays."""
    moved = _slip(q, b)
    return SlipState(q.z * q.theta_dot, -(q.s * q.theta_dot), moved.theta_dot2, moved.nu_x_dot, 0 * q.z)


@formula
def slip_place(q, b):
    """Where the body is."""
    none, height = 0 * q.z, contact.height(q.z, b)
    velocity = Vector(q.nu_x + q.theta_dot * height, none, b.c * (q.s * q.theta_dot))
    return legs.Placed(Vector(q.s, none, q.z), Vector(none, b.I1 * q.theta_dot, none), velocity, height)


@formula
def slipping(q, b):
    """What a state says."""
    moved = _slip(q, b)
    return legs.Reached._make((*slip_place(q, b), Vector(moved.F_x, 0 * q.z, moved.N), 0))


def slip_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Any) -> SlipState:
    """The state of sliding of a cylinder on the plane."""
    turn = L.y / b.I1
    nu_x = velocity.x - turn * height
    return SlipState(u.x, u.z, turn, nu_x, np.sign(nu_x))


@formula
def nu_x(s, b):
    """nu_x."""
    return s.nu_x


@formula
def normal_force(s, b):
    """Normal force [N]."""
    return s.force


SLIP_FORM = Form(
    "angle",
    SlipState(ONE, ONE, RADIAN_PER_SECOND, METRE_PER_SECOND, ONE),
    slip_rates,
    slip_scalars,
    of_angles=lambda e, s, z, b: None,
    to_angles=lambda q, carried, b: None,
    integrals=(
        integral("theta", lambda q, carried, b: q.theta_dot),
        integral("x", lambda q, carried, b: q.nu_x + q.theta_dot * contact.height(q.z, b)),
        integral("work", lambda q, carried, b: -(_slip(q, b).F_x * q.nu_x)),
        integral("impulse", lambda q, carried, b: _slip(q, b).N),
    ),
    orientation=planar(lambda q: (q.s, q.z)),
)
SLIP_EVENTS = (
    replace(legs.SLIPPING[0], formula=normal_force),
    replace(dry.STICK, formula=nu_x, direction=0),
)


def sliding(u: Vector, L: Vector, w: Any, beta: Any, b: Any) -> SlipState:
    """The state of sliding with the speed w in the direction beta, 0 or pi."""
    return SlipState(u.x, u.z, L.y / b.I1, w * np.cos(beta), np.sign(np.cos(beta)))


DRY_SLIP = legs.Kind("slip", SLIP_FORM, SLIP_EVENTS, slip_place, slipping, slip_state, sliding)

SCALARS = {"slip": contact.Scalars, "roll": reaction.Scalars, "flight": reaction.Kinematics}
PLANAR_KINDS = {
    name: legs.KINDS[name]._replace(form=_with_theta(legs.KINDS[name].form, of)) for name, of in SCALARS.items()
}
PLANAR_KINDS["dry-slip"] = DRY_SLIP
"""Every way that a cylinder moves."""
