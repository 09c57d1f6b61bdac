"""Sliding under Coulomb's law itself: its equations, and the event in which it stops. [contact 2.1, 2.2]"""

from dataclasses import replace
from typing import Any, NamedTuple

from ...events import Event
from ...form import Form
from ...operand import Operand, Vector, atan2, cos, cross, dot, formula, sin, sqrt, times
from ...units import ANGULAR_MOMENTUM, METRE_PER_SECOND, ONE, RADIAN
from ..body import Touch, arm, centre_velocity, contact_velocity, height
from ..coulomb import slip_force_vector, slip_motion
from ..gliding import catalogue as gliding
from ..integrals import integral
from ..orientation import carried_along
from ..response import bias_vector
from . import row
from .legs import TOUCH, Kind, Placed, Reached


STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. What is left of it is an impulse."""


@formula
def sliding_left(s, b):
    """|v_A| less the speed at which sliding ends: transversal, as |v_A|^2 is not. [contact 2.2]"""
    return s.w - STOPS_AT


STICK = Event(
    "stick", "sliding stops, v_A = 0: the contact rolls, if the friction cone allows", sliding_left, -1, "stick"
)


class DrySlipState(NamedTuple):
    """3hat, L about the centre of mass, v_A = w (cos(beta), sin(beta)) in space axes: so |v_A| keeps its digits,
    and its direction its length, where sliding stops."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    beta: Operand
    w: Operand


class DryScalars(NamedTuple):
    """What its events read."""

    z: Operand  # cos(theta)
    z_dot: Operand
    w: Operand  # |v_A|
    force: Operand  # normal force


@formula
def direction(q):
    """n = v_A/|v_A|, (3,)."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


@formula
def dry_force(q, b):
    """F = N (zhat - mu v_A/|v_A|), (3,) [N]. [contact 2.1]"""
    u = row.axis(q)
    return slip_force_vector(u, bias_vector(u, row.momentum(q), b), direction(q), b)


@formula
def dry_scalars(q, b):
    """The scalars of a state."""
    return DryScalars(q.uz, row.axis_rate(q, b).z, q.w, dry_force(q, b).z)


@formula
def dry_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, and w', w beta' of v_A' = b + K F. [contact 1, 2.1]"""
    u = row.axis(q)
    F, P, Q = slip_motion(u, row.momentum(q), direction(q), b)
    return DrySlipState._make((*row.axis_rate(q, b), *cross(arm(u, b), F), Q / q.w, P))


@formula
def dry_velocity(q, b):
    """Velocity of the centre of mass, (3,) [m/s]."""
    return centre_velocity(row.axis(q), row.momentum(q), times(q.w, direction(q)), b)


@formula
def dry_place(q, b):
    """Where the body is."""
    return Placed(row.axis(q), row.momentum(q), dry_velocity(q, b), height(q.uz, b))


@formula
def dry_slipping(q, b):
    """What a state says."""
    return Reached._make((*dry_place(q, b), dry_force(q, b), 0))


@formula
def dry_normal_force(s, b):
    """Normal force [N]."""
    return s.force


DRY = Form(
    "vector",
    DrySlipState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, RADIAN, METRE_PER_SECOND),
    dry_rates,
    dry_scalars,
    of_angles=lambda e, s, z, b: None,  # it begins in the state that another phase leaves
    to_angles=lambda q, carried, b: None,
    integrals=(
        integral("x", lambda q, carried, b: dry_velocity(q, b).x),
        integral("y", lambda q, carried, b: dry_velocity(q, b).y),
        integral("work", lambda q, carried, b: -(q.w * dot(direction(q), dry_force(q, b)))),
        integral("impulse", lambda q, carried, b: dry_force(q, b).z),
    ),
    orientation=carried_along(row.axis, row.axis_rate, row.spin),
)
DRY_SLIPPING = (replace(gliding.LIFTOFF, formula=dry_normal_force), TOUCH, STICK)


def dry_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Touch) -> Any:
    """The state of sliding of a body on the plane."""
    v = contact_velocity(u, L, velocity, b)
    return DrySlipState(*u, *L, atan2(v.y, v.x), sqrt(v.x * v.x + v.y * v.y))


def dry_sliding(u: Vector, L: Vector, w: Any, beta: Any, b: Touch) -> Any:
    """The state of sliding with the speed w in the direction beta."""
    return DrySlipState(*u, *L, beta, w)


DRY_SLIP = Kind("slip", DRY, DRY_SLIPPING, dry_place, dry_slipping, dry_state, dry_sliding)
