"""Input and output of a gliding body: initial data, forms, events, quantities."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ...event import Event, Kept
from ...operand import formula
from ...system import Alternative, Domain, Form, Integral, Number, Quantity
from ...units import (
    JELLETT,
    JOULE,
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    RADIAN,
    RADIAN_PER_SECOND,
    WATT,
    Unit,
)
from ..body import (
    Touch,
    contact_mobility,
    energy,
    friction_loss,
    friction_power,
    g_n,
    jellett,
    modified_energy,
    modified_energy_rate,
    push_n,
    push_u,
)
from ..body_axes import carried_along
from ..integrals import integral, place
from .gliding_chart import angles_of_vector, in_euler_angles, vector_of_angles
from .gliding_euler import (
    ANGLES,
    EULER_UNITS,
    centre_velocity,
    euler_rates,
    euler_scalars,
    velocity,
)
from .gliding_vector import VECTOR_UNITS, axis, axis_rate, vector_rates, vector_scalars


INITIAL = {
    "theta": Number(
        RADIAN, "inclination theta of the axis", least=0, most=3.141592653589793, symbol=r"\theta"
    ),
    "theta_dot": Number(RADIAN_PER_SECOND, "theta'", symbol=r"\theta'"),
    "phi": Number(RADIAN, "azimuth phi of the horizontal projection of the axis", symbol=r"\phi"),
    "phi_dot": Number(RADIAN_PER_SECOND, "phi'", symbol=r"\phi'"),
    "omega3": Number(
        RADIAN_PER_SECOND, "angular velocity omega_3 about the axis", symbol=r"\omega_3"
    ),
    "nu_x": Number(METRE_PER_SECOND, "contact velocity along e", symbol=r"\nu_x"),
    "nu_y": Number(METRE_PER_SECOND, "contact velocity along 2hat", symbol=r"\nu_y"),
    "x": Number(METRE, "x of the centre of mass"),
    "y": Number(METRE, "y of the centre of mass"),
    "psi_dot": Number(RADIAN_PER_SECOND, "psi', instead of omega3", symbol=r"\psi'"),
    "psi": Number(RADIAN, "turn psi of the body about its axis", symbol=r"\psi"),
}
BY_PSI_DOT = Alternative("psi_dot", ("omega3",))
ALTERNATIVES = (BY_PSI_DOT, Alternative("centre_at_rest", ("nu_x", "nu_y"), flag=True))


def start_of(angles: Any) -> Callable:
    """Return `start` of a system with these angles: what the user gave, the rest zero.

    psi_dot may be given instead of omega3, and centre_at_rest instead of nu_x and nu_y.
    """

    def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
        e = type(angles)(*(data.get(name, 0) for name in angles._fields))
        if "psi_dot" in data:
            e = e._replace(omega3=data["psi_dot"] + e.phi_dot * z)
        if data.get("centre_at_rest"):
            along_e, along_2 = centre_velocity(e, s, z, b)
            e = e._replace(nu_x=e.nu_x - along_e, nu_y=e.nu_y - along_2)
        return e

    return start


NOT_JAMMED = Domain(
    contact_mobility,
    "the friction jams the contact (denominator of g_n not positive): no solution of the model",
)


def work_and_impulse(scalars: Any) -> tuple[Integral, Integral]:
    """Return the integrals of friction power and normal force of a form with these scalars."""
    return (
        integral("work", lambda q, carried, b: friction_power(scalars(q, b), b)),
        integral("impulse", lambda q, carried, b: g_n(scalars(q, b), b)),
    )


VECTOR = Form(
    "vector",
    VECTOR_UNITS,
    vector_rates,
    vector_scalars,
    vector_of_angles,
    angles_of_vector,
    integrals=(
        *place(lambda q, carried, b: (q.rx_dot, q.ry_dot)),
        *work_and_impulse(vector_scalars),
    ),
    orientation=carried_along(axis, axis_rate, lambda q, b: q.L3 / b.I3),
    domains=(NOT_JAMMED,),
)
EULER = in_euler_angles(
    VECTOR,
    ANGLES,
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    (*place(velocity), *work_and_impulse(euler_scalars)),
    NOT_JAMMED,
)
FORMS = {form.name: form for form in (VECTOR, EULER)}
UNDEFINED_AT_POLES = ("phi", "phi_dot", "nu_x", "nu_y")
VECTORS = {"axis": ("ux", "uy", "uz"), "L": ("Lx", "Ly", "Lz")}
LONG_NAMES = {
    **{name: parameter.long_name for name, parameter in INITIAL.items()},
    "phi": "azimuth phi of the horizontal projection of the axis, in (-pi, pi]; undefined (NaN) "
    "exactly at a pole",
    "phi_dot": "phi'; undefined (NaN) exactly at a pole",
    "nu_x": "contact velocity along e; undefined (NaN) exactly at a pole",
    "nu_y": "contact velocity along 2hat; undefined (NaN) exactly at a pole",
    "work": "energy taken by friction since the start",
    "impulse": "integral of the normal force since the start",
    "axis": "unit vector 3hat along the axis, space frame",
    "L": "angular momentum about the centre of mass, space frame",
}


@formula
def turning(s, b):
    """Return z' = -theta' sin(theta): zero at the turning angles, and at a pole."""
    return s.z_dot


@formula
def equator(s, b):
    """Return z = cos(theta): zero where the axis is horizontal."""
    return s.z


@formula
def near_inversion(s, b):
    """Return z + cos(0.1): falls through zero where theta rises through pi - 0.1."""
    return s.z + COS_INVERTED


@formula
def sliding(s, b):
    """Return the friction loss less 1e-12, in internal units.

    Below it the motion is settled, because a solution without sliding is a spinning or a tumbling
    one. [T Theorem 3.3.1]
    """
    return friction_loss(s, b) - 1e-12


COS_INVERTED = 0.9950041652780258  # cos(0.1)

TURNING = Event("turning", "turning angle, theta' = 0", turning, sense=-1)
LIFTOFF = Event(
    "liftoff",
    "normal force g_n falls to zero: beyond it the model is not valid",
    g_n,
    direction=-1,
    ends="liftoff",
    extremes="normal_force",
    kept=(Kept("lifted_at", "first", "the normal force first falls to zero; NaN: never"),),
)
EQUATOR = Event(
    "equator",
    "theta = pi/2",
    equator,
    kept=(
        Kept("first_equator", "first", "first passage of theta = pi/2; NaN: none"),
        Kept("last_equator", "last", "last passage of theta = pi/2; NaN: none"),
        Kept("equators", "count", "passages of theta = pi/2"),
    ),
)
FALLEN = replace(EQUATOR, long_name="theta = pi/2: the body has fallen to the plane", ends="fallen")
INVERTED = Event(
    "inverted",
    "theta rises through pi - 0.1",
    near_inversion,
    direction=-1,
    kept=(Kept("inverted_at", "first", "theta first rises through pi - 0.1; NaN: never"),),
)
SETTLED = Event(
    "settled",
    "sliding dies out: friction loss below 1e-12 sqrt(gR)",
    sliding,
    direction=-1,
    lasting=True,
    kept=(Kept("settled_at", "last", "sliding last died out; NaN: never"),),
)
EVENTS = (TURNING, LIFTOFF, EQUATOR, INVERTED, SETTLED)

ENERGIES = (
    Quantity("energy", "E", JOULE, "energy", energy),
    Quantity("modified_energy", "E~", JOULE, "modified (rolling) energy", modified_energy),
)
QUANTITIES = (
    *ENERGIES,
    Quantity("normal_force", "g_n", NEWTON, "normal force", g_n),
    Quantity("friction_power", "-E'", WATT, "power dissipated by friction", friction_power),
)
TORQUE = Unit("kg m2 s-2")
MODIFIED_ENERGY_RATE = Quantity(
    "modified_energy_rate",
    "E~'",
    WATT,
    "rate of the modified energy",
    lambda s, b: modified_energy_rate(push_u(s, b), push_n(s, b), s, b),
)
JELLETT_QUANTITY = Quantity("jellett", "lambda", JELLETT, "Jellett's integral", jellett)
