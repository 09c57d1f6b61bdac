"""A cylinder under set-valued Coulomb friction: a ball whose phi', omega_3 and nu_y vanish.
[contact 2.7]

theta is not wrapped: sin(theta) may be negative; sigma is the sign of nu_x. I1 is the moment about
the centre of mass.
"""

from collections import namedtuple
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..form import Form, Phase
from ..operand import Vector, cos
from ..units import METRE_PER_SECOND, ONE, RADIAN_PER_SECOND
from .body import Touch, height
from .coulomb import slip_motion
from .integrals import integral
from .orientation import planar
from .single_contact import FLIGHT, LIFTOFF, ROLL, SLIP, STICK
from .state import PLANAR_ROW, Moving, Reaction, filled, planar_theta_dot


# --- phases -------------------------------------------------------------------------------------


@lru_cache
def with_theta_dot(record: Any) -> Any:
    """Return the type of a record of scalars with one more, theta'."""
    return namedtuple("PlanarScalars", (*record._fields, "theta_dot"))


def in_plane(phase: Phase) -> Phase:
    """Return a phase that integrates theta too, which is not wrapped, and whose scalars have
    theta'."""
    form = phase.form

    def scalars(q, b):
        s = form.scalars(q, b)
        record: Any = type(s)
        return with_theta_dot(record)(*s, planar_theta_dot(q, b))

    theta = integral("theta", lambda q, carried, b: planar_theta_dot(q, b))
    integrals = (theta, *(one for one in form.integrals if one.name != "y"))
    turn = PLANAR_ROW.orientation
    changed = replace(form, scalars=scalars, integrals=integrals, orientation=turn)
    return replace(phase, forms={form.name: changed})


IN_PLANE = {phase.label: in_plane(phase) for phase in (SLIP, ROLL, FLIGHT)}
"""The phases of a cylinder whose equations are those of any body, by label."""

SIGNED = filled(s=ONE, z=ONE, theta_dot=RADIAN_PER_SECOND, nu_x=METRE_PER_SECOND, sigma=ONE)
"""sin(theta), cos(theta), theta', nu_x, and its sign."""

Signed: Any = namedtuple("Signed", "z theta_dot nu_x force")


def signed(q, b):
    """The slide of a state. [contact 2.7]"""
    x = signed_leave(q, b)
    return slip_motion(x.u, x.L, Vector(q.sigma, x.u.y, x.u.y), b)


def signed_rates(q, b):
    """theta'' and nu_x' of sliding; the sign stays."""
    by = signed(q, b)
    turn = q.z * q.theta_dot, -(q.s * q.theta_dot)
    return type(SIGNED)(*turn, by.turn.y / b.I1, q.sigma * by.P, 0 * q.z)


def signed_leave(q, b):
    """The common state of a cylinder that slides."""
    none, h = 0 * q.z, height(q.z, b)
    velocity = Vector(q.nu_x + q.theta_dot * h, none, b.c * (q.s * q.theta_dot))
    return Moving(Vector(q.s, none, q.z), Vector(none, b.I1 * q.theta_dot, none), velocity, h)


def signed_reaction(q, b):
    """The force on a cylinder that slides."""
    return Reaction(signed(q, b).force)


def signed_enter(x, b):
    """The state of a cylinder that slides."""
    turn = x.L.y / b.I1
    nu_x = x.velocity.x - turn * x.height
    return type(SIGNED)(x.u.x, x.u.z, turn, nu_x, np.sign(nu_x))


def signed_slide(u: Vector, L: Vector, w: Any, beta: Any, b: Touch) -> Any:
    """Return the state of sliding with the speed w in the direction beta, 0 or pi."""
    along = cos(beta)
    return type(SIGNED)(u.x, u.z, L.y / b.I1, w * along, np.sign(along))


SIGNED_FORM = Form(
    "angle",
    SIGNED,
    signed_rates,
    lambda q, b: Signed(q.z, q.theta_dot, q.nu_x, signed(q, b).force.z),
    integrals=(
        integral("theta", lambda q, carried, b: q.theta_dot),
        integral("x", lambda q, carried, b: q.nu_x + q.theta_dot * height(q.z, b)),
        integral("work", lambda q, carried, b: -(signed(q, b).force.x * q.nu_x)),
        integral("impulse", lambda q, carried, b: signed(q, b).force.z),
    ),
    orientation=planar(lambda q: (q.s, q.z)),
)
SIGNED_SLIP = Phase(
    {"angle": SIGNED_FORM},
    (),
    (LIFTOFF, replace(STICK, formula=lambda s, b: s.nu_x, direction=0)),
    enter=signed_enter,
    leave=signed_leave,
    reaction=signed_reaction,
    label="slip",
)
