"""A cylinder under set-valued Coulomb friction: a ball whose phi', omega_3 and nu_y vanish.
[contact 2.7]

theta is not wrapped: sin(theta) may be negative; sigma is the sign of nu_x. I1 is the moment about
the centre of mass.
"""

from collections import namedtuple
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..form import Form, Phase
from ..operand import Operand, Vector, cos, formula
from ..units import METRE_PER_SECOND, ONE, RADIAN_PER_SECOND
from .body import Touch, height
from .coulomb import reaction_of_rolling, slip_force
from .integrals import integral
from .orientation import planar
from .response import bias, contact_acceleration, mobility
from .single_contact import FLIGHT, LIFTOFF, ROLL, SLIP, STICK
from .state import PLANAR_ROW, Moving, Reaction, planar_theta_dot


class Planar(NamedTuple):
    """The force at the contact [N], and what it leads to."""

    F_x: Operand
    N: Operand
    theta_dot2: Operand  # theta'' [rad/s^2]
    nu_x_dot: Operand  # nu_x' [m/s^2]


@formula
def moved(b, K, F, s, z, body):
    """The motion with the force F, Components."""
    theta_dot2 = -(body.c * s * F.z + height(z, body) * F.e) / body.I1
    return Planar(F.e, F.z, theta_dot2, contact_acceleration(b, K, F).e)


@formula
def slip(s, z, theta_dot, sigma, body):
    """The motion while the cylinder slips in the direction sigma."""
    b, K = bias(s, z, theta_dot, 0, 0, body), mobility(s, z, body)
    return moved(b, K, slip_force(b, K, sigma, 0, body), s, z, body)


@formula
def roll(s, z, theta_dot, body):
    """The motion while the cylinder rolls; nu_x' vanishes to rounding."""
    b, K = bias(s, z, theta_dot, 0, 0, body), mobility(s, z, body)
    return moved(b, K, reaction_of_rolling(b, K), s, z, body)


# --- phases ---------------------------------------------------------------------------------------


@lru_cache
def with_theta_dot(record: Any) -> Any:
    """Return the type of a record of scalars with one more, theta'."""
    return namedtuple("PlanarScalars", (*record._fields, "theta_dot"))


def in_plane(phase: Phase) -> Phase:
    """Return a phase that integrates theta too, which is not wrapped, and whose scalars have
    theta'."""
    form = phase.form

    @formula
    def scalars(q, b):
        s = form.scalars(q, b)
        record: Any = type(s)
        return with_theta_dot(record)._make((*s, planar_theta_dot(q, b)))

    theta = integral("theta", lambda q, carried, b: planar_theta_dot(q, b))
    integrals = (theta, *(one for one in form.integrals if one.name != "y"))
    turn = PLANAR_ROW.orientation
    changed = replace(form, scalars=scalars, integrals=integrals, orientation=turn)
    return replace(phase, forms={form.name: changed})


class SignedState(NamedTuple):
    """sin(theta), cos(theta), theta', nu_x, and its sign."""

    s: Operand
    z: Operand
    theta_dot: Operand
    nu_x: Operand
    sigma: Operand


class SignedScalars(NamedTuple):
    """The scalars of its events."""

    z: Operand
    theta_dot: Operand
    nu_x: Operand
    force: Operand  # normal force


@formula
def signed(q, b):
    """The motion of a state. [contact 2.7]"""
    return slip(q.s, q.z, q.theta_dot, q.sigma, b)


@formula
def signed_rates(q, b):
    """theta'' and nu_x' of sliding; the sign stays."""
    by = signed(q, b)
    return SignedState(q.z * q.theta_dot, -(q.s * q.theta_dot), by.theta_dot2, by.nu_x_dot, 0 * q.z)


@formula
def signed_leave(q, b):
    """The common state of a cylinder that slides."""
    none, h = 0 * q.z, height(q.z, b)
    velocity = Vector(q.nu_x + q.theta_dot * h, none, b.c * (q.s * q.theta_dot))
    return Moving(Vector(q.s, none, q.z), Vector(none, b.I1 * q.theta_dot, none), velocity, h)


@formula
def signed_reaction(q, b):
    """The force on a cylinder that slides."""
    by = signed(q, b)
    return Reaction(Vector(by.F_x, 0 * q.z, by.N))


def signed_enter(x: Moving, b: Touch) -> SignedState:
    """Return the state of a cylinder that slides."""
    turn = x.L.y / b.I1
    nu_x = x.velocity.x - turn * x.height
    return SignedState(x.u.x, x.u.z, turn, nu_x, np.sign(nu_x))


def signed_slide(u: Vector, L: Vector, w: Any, beta: Any, b: Touch) -> SignedState:
    """Return the state of sliding with the speed w in the direction beta, 0 or pi."""
    return SignedState(u.x, u.z, L.y / b.I1, w * cos(beta), np.sign(cos(beta)))


SIGNED_SLIP = Phase(
    {
        "angle": Form(
            "angle",
            SignedState(ONE, ONE, RADIAN_PER_SECOND, METRE_PER_SECOND, ONE),
            signed_rates,
            formula(lambda q, b: SignedScalars(q.z, q.theta_dot, q.nu_x, signed(q, b).N)),
            integrals=(
                integral("theta", lambda q, carried, b: q.theta_dot),
                integral("x", lambda q, carried, b: q.nu_x + q.theta_dot * height(q.z, b)),
                integral("work", lambda q, carried, b: -(signed(q, b).F_x * q.nu_x)),
                integral("impulse", lambda q, carried, b: signed(q, b).N),
            ),
            orientation=planar(lambda q: (q.s, q.z)),
        )
    },
    (),
    (LIFTOFF, replace(STICK, formula=formula(lambda s, b: s.nu_x), direction=0)),
    enter=signed_enter,
    leave=signed_leave,
    reaction=signed_reaction,
    label="slip",
)
IN_PLANE = {phase.label: in_plane(phase) for phase in (SLIP, ROLL, FLIGHT)}
"""The phases of a cylinder whose equations are those of any body, by label."""
