"""A body that glides on the plane, of one ball: its forms, start, events and columns.

In go a `Touch`, a state and a friction law; out come the rates of the state and the scalars from
which events and columns are computed. `systems.tippe_top` and others make their `System` of the
constants at the end (FORMS, INITIAL, EVENTS, QUANTITIES). There are two forms because angles are
what users give and read, but singular at the poles; the vector form is regular everywhere. [T 3.12,
3.17, 3.20-3.22, 3.29-3.34, 5.2, 5.14-5.18]

Symbols
    b         the body, a `body.Touch`
    q         state of the vector form; in a form of angles, its state
    e         `EulerState`: theta, theta', phi', omega_3, nu_x, nu_y; of the chart: record ANGLES
    carried   record of the integrals: phi, x, y, work, impulse
    s, z      sin(theta), cos(theta) in (e, s, z, b); but s in (s, b) is a record of `Scalars`
    u, 3hat   unit vector of the axis; e = (cos(phi), sin(phi), 0), 2hat = zhat x e
    L, L_3    angular momentum about the centre of mass, L.3hat
    r         horizontal position of the centre of mass
    A, a      the contact point; the arm, from the centre of mass to A
    v_A       velocity of A, nu_x e + nu_y 2hat
    F, g_n    force of the plane at A; its normal part; friction is -k g_n v_A
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..event import Event, Kept
from ..friction import LAWS
from ..operand import Vector, atan2, cos, formula, sin, sqrt
from ..system import Alternative, Domain, Form, Integral, Number, Quantity
from ..units import (
    ANGULAR_MOMENTUM,
    JELLETT,
    JOULE,
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    NEWTON_SECOND,
    RADIAN,
    RADIAN_PER_SECOND,
    WATT,
    Unit,
)
from . import body as contact
from .body import (
    Scalars,
    Touch,
    Turning,
    axis,
    contact_mobility,
    drag,
    energy,
    filled,
    friction_loss,
    friction_power,
    g_n,
    height,
    jellett,
    kinematics,
    kinematics_of_angles,
    modified_energy,
    modified_energy_rate,
    of_azimuth,
    push_n,
    push_u,
    rolling_velocity,
    slip_scalars,
    state,
    touching_ball,
    turning,
)
from .body_axes import by_angles, carried_along, psi_of_axes
from .integrals import integral, place


# --- vector form: regular everywhere --------------------------------------------------------------


VECTOR_UNITS = state(L3=ANGULAR_MOMENTUM, rx_dot=METRE_PER_SECOND, ry_dot=METRE_PER_SECOND)
"""3hat, L and L_3 = L.3hat about the centre of mass, velocity of the centre of mass.

L_3 is carried because L_3' and L_z' are one product: it saves three.
"""

VectorState = type(VECTOR_UNITS)


@formula
def axis_rate(q, b):
    """Return 3hat' = L x 3hat/I1, (3,) [1/s], of a vector state. [T 3.17]"""
    return contact.axis_rate(turning(q), b)


@formula
def sliding_velocity(q, b):
    """Return v_A = r' + omega x a, horizontal, (3,) [m/s]. [T 3.3]

    `body.contact_velocity` with the carried L_3, summed from the left.
    """
    u_dot = axis_rate(q, b)
    w = contact.angular_velocity_of(turning(q), q.L3, b)
    return Vector(q.rx_dot + b.c * u_dot.x - b.R * w.y, q.ry_dot + b.c * u_dot.y + b.R * w.x, 0.0)


@formula
def vector_scalars(q, b):
    """Return the `Scalars` of a vector state.

    Their L3 is L.3hat, so that the carried L_3 is checked too.
    """
    u = axis(q)
    v = sliding_velocity(q, b)
    return Scalars(
        *kinematics(turning(q), axis_rate(q, b), b),
        *slip_scalars(u, v),
        q.rx_dot**2 + q.ry_dot**2,
    )


@formula
def reaction(q, b):
    """Return g_n (zhat - k v_A), the force of the plane in a vector state, (3,) [N]. [T 3.16]"""
    s = vector_scalars(q, b)
    v = sliding_velocity(q, b)
    k = drag(s, b)
    return Vector(k * v.x, k * v.y, g_n(s, b))


@formula
def vector_rates(q, b):
    """Return the rates of a vector state: 3hat' = L x 3hat/I1, L' = a x F, m r'' = F_h.

    [T 3.12, 3.17; 5.2]
    """
    u = axis(q)
    F = reaction(q, b)
    L3_rate = b.R * (u.x * F.y - u.y * F.x)  # (a x F).3hat, of which c 3hat x F is no part
    return VectorState(*axis_rate(q, b), *contact.moment(u, F, b), L3_rate, F.x / b.m, F.y / b.m)


# --- Euler angles: singular at the poles ----------------------------------------------------------


EULER_UNITS = filled(
    theta=RADIAN,
    theta_dot=RADIAN_PER_SECOND,
    phi_dot=RADIAN_PER_SECOND,
    omega3=RADIAN_PER_SECOND,
    nu_x=METRE_PER_SECOND,
    nu_y=METRE_PER_SECOND,
)
"""theta, theta', phi', omega_3, v_A = nu_x e + nu_y 2hat."""

ANGLES = filled(
    **EULER_UNITS._asdict(), phi=RADIAN, x=METRE, y=METRE, work=JOULE, impulse=NEWTON_SECOND
)
"""Public variables: the state, phi, and the integrals."""

EulerState = type(EULER_UNITS)


@formula
def centre_velocity(e, s, z, b):
    """Return the velocity of the centre of mass along e and 2hat [m/s], by angles and rates."""
    along_e, along_2 = rolling_velocity(e, s, z, b)
    return e.nu_x + along_e, e.nu_y + along_2


@formula
def euler_scalars(e, b):
    """Return the `Scalars` of a state e in Euler angles: `vector_scalars` of the same motion."""
    s = sin(e.theta)
    z = cos(e.theta)
    along_e, along_2 = centre_velocity(e, s, z, b)
    speeds2 = e.nu_x**2 + e.nu_y**2, along_e**2 + along_2**2
    return Scalars(*kinematics_of_angles(e, s, z, b), e.nu_x * s, e.nu_y * s, *speeds2)


@formula
def sine_and_cosine(q):
    """Return sin(theta), cos(theta) of a state in angles."""
    return sin(q.theta), cos(q.theta)


@formula
def spins(e, across, b):
    """Return phi'' and omega_3' [rad/s^2] if the force along 2hat at the contact is `across` [N].

    `rolling.euler_rates` calls it too: e may lack nu_x and nu_y.

    [T 3.30, 3.31]
    """
    s, z = sine_and_cosine(e)
    turn = e.theta_dot * (b.I3 * e.omega3 - 2 * b.I1 * e.phi_dot * z)
    return (turn + across * (b.c - b.R * z)) / (b.I1 * s), b.R * s * across / b.I3


@formula
def euler_rates(e, b):
    """Return the rates of a state e in Euler angles: the equations of motion, solved for them.

    [T 3.29-3.34 with 3.32 and 3.34 corrected; 5.14-5.18]
    """
    s = sin(e.theta)
    c = euler_scalars(e, b)
    k = drag(c, b)
    swing = e.phi_dot * (b.I1 * e.phi_dot * c.z - b.I3 * e.omega3) - b.c * g_n(c, b)
    return EulerState(
        e.theta_dot,
        (s * swing - height(c.z, b) * (k * e.nu_x)) / b.I1,
        *spins(e, k * e.nu_y, b),
        push_u(c, b) / s + e.phi_dot * e.nu_y,
        push_n(c, b) / s - e.phi_dot * e.nu_x,
    )


@formula
def psi_rate(q, carried, b):
    """Return psi' = omega_3 - phi' cos(theta) [rad/s]. [T 3.22]"""
    return q.omega3 - q.phi_dot * cos(q.theta)


def place_of_angles(centre: Callable) -> tuple[Integral, ...]:
    """Return the integrals x and y of a form in angles, which has the velocity `centre`.

    centre(e, sin(theta), cos(theta), b) returns that of the centre of mass along e and 2hat.
    """

    def velocity(q: Any, carried: Any, b: Any) -> tuple[Any, Any]:
        """Return the velocity of the centre of mass along x and y [m/s]."""
        along_e, along_2 = centre(q, *sine_and_cosine(q), b)
        return of_azimuth(along_e, along_2, carried.phi)

    return place(velocity)


# --- the chart between them -----------------------------------------------------------------------


@formula
def axis_and_momentum(e, s, z, I1, I3):
    """Return the `Turning` (3hat, L) of angles e, for moments I1 across and I3 along the axis.

    e: a record ANGLES, of this module, `rolling` or `rows`, with theta_dot, phi_dot, omega3 and
    phi; s, z: sin(theta), cos(theta). L is about the point to which I1 refers [kg m^2/s].
    """
    ex = cos(e.phi)
    ey = sin(e.phi)
    L3 = I3 * e.omega3
    transverse = -(I1 * e.phi_dot * s)
    nodal = I1 * e.theta_dot
    lean = transverse * z + L3 * s  # L along e; 1hat = z e - s zhat
    L = Vector(lean * ex - nodal * ey, lean * ey + nodal * ex, L3 * z - transverse * s)
    return Turning(Vector(s * ex, s * ey, z), L)


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles e: `of_angles` of the form.

    e: a record ANGLES, with phi, not an `EulerState`; s, z: sin(theta), cos(theta), exact at the
    poles. b: a `Touch` with R and c; those of an outline are filled in by `touching_ball`.
    """
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    along_e, along_2 = centre_velocity(e, s, z, b)
    velocity = of_azimuth(along_e, along_2, e.phi)
    return VectorState(*u, *L, b.I3 * e.omega3, *velocity)


def azimuth(q: Any, carried: Any) -> Any:
    """Return phi in (-pi, pi] [rad], from 3hat of a state."""
    return atan2(q.uy, q.ux)


def wrapped_azimuth(q: Any, carried: Any) -> Any:
    """Return phi in (-pi, pi] [rad], from theta and the integral phi.

    Where sin(theta) < 0, as theta is not wrapped, 3hat has the opposite azimuth; at a pole it is
    0/0 in meaning, as in `azimuth`.
    """
    s = sin(q.theta)
    return atan2(s * sin(carried.phi), s * cos(carried.phi))


def angles_by(units: Any, scalars: Callable, azimuth: Callable = azimuth) -> Callable:
    """Return the function to_angles(q, carried, b) of a form; see `Form`.

    At a pole phi is undefined and the angles are exactly 0/0. theta is atan2(sin, cos), so that no
    digits are lost near the poles. Scalars may lack the velocities of the contact (v_u, v_n), those
    of rows (rise, gap) and `motion` of `framed`: the angles then lack these numbers too.

    Parameters
    ----------
    units
        The record of the angles; fields that the scalars do not give are integrals.
    scalars
        scalars(q, b) of the form.
    azimuth
        azimuth(q, carried) -> phi.
    """

    def to_angles(q: Any, carried: Any, b: Any) -> Any:
        """Return the record `units` of a state: angles and rates, the rest from `carried`."""
        c = scalars(q, b)
        s = sqrt(c.s2)
        known = {
            "theta": atan2(s, c.z),
            "theta_dot": -c.z_dot / s,
            "phi_dot": c.phi_dot_s2 / c.s2,
            "omega3": c.L3 / b.I3,
            "phi": azimuth(q, carried),
        }
        if hasattr(c, "motion"):
            known["psi"] = psi_of_axes(*c.motion.u.axes[::2])  # axes 1 and 3
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
    angles
        The record of the angles, of which theta is brought to [0, pi], and phi to (-pi, pi].
    units
        The state: the first of the angles.
    rates, scalars, integrals, domains
        As of a `Form`, without phi.
    """
    return Form(
        "euler",
        units,
        rates,
        scalars,
        lambda e, s, z, b: type(units)(*e[: len(units)]),
        angles_by(angles, scalars, wrapped_azimuth),
        integrals=(integral("phi", lambda q, carried, b: q.phi_dot), *integrals),
        orientation=by_angles(sine_and_cosine, psi_rate),
        domains=(*domains, AWAY_FROM_POLE),
    )


# --- the catalogue --------------------------------------------------------------------------------


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
ALTERNATIVES = (
    Alternative("psi_dot", ("omega3",)),
    Alternative("centre_at_rest", ("nu_x", "nu_y"), flag=True),
)


def start_of(angles: Any) -> Callable:
    """Return `System.start` of a body: numbers of the user -> the record of angles.

    Missing numbers are zero. psi_dot may be given instead of omega3, and centre_at_rest instead of
    nu_x and nu_y: as in `framed.start`; a change of one is a change of both.
    """

    def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
        """Return the record `angles` from the numbers that the user gave.

        s, z are sin(theta), cos(theta).
        """
        e = type(angles)(*(data.get(name, 0) for name in angles._fields))
        if "psi_dot" in data:
            e = e._replace(omega3=data["psi_dot"] + e.phi_dot * z)
        if data.get("centre_at_rest"):
            along_e, along_2 = rolling_velocity(e, s, z, touching_ball(z, s * s, b))
            e = e._replace(nu_x=-along_e, nu_y=-along_2)
        return e

    return start


NOT_JAMMED = Domain(
    contact_mobility,
    "the friction jams the contact (denominator of g_n not positive): no solution of the model",
)


def work_and_impulse(scalars: Any) -> tuple[Integral, Integral]:
    """Return the integrals `work` [J] and `impulse` [N s] of a form with scalars(q, b).

    Their rates are the friction power and the normal force.
    """
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
    orientation=carried_along(axis_rate, lambda q, b: q.L3 / b.I3),
    domains=(NOT_JAMMED,),
)
EULER = in_euler_angles(
    ANGLES,
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    (*place_of_angles(centre_velocity), *work_and_impulse(euler_scalars)),
    NOT_JAMMED,
)
FORMS = {form.name: form for form in (VECTOR, EULER)}
UNDEFINED_AT_POLES = ("phi", "phi_dot", "nu_x", "nu_y")
VECTORS = {"axis": ("ux", "uy", "uz"), "L": ("Lx", "Ly", "Lz")}
"""Columns that are vectors: the variables of the state that are their components."""
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
def theta_turns(s, b):
    """Return z' = -theta' sin(theta) [1/s], the function of the event `turning`.

    It is zero at a pole too. Its sign is opposite to that of theta': the event has `sense` -1.
    """
    return s.z_dot


@formula
def equator(s, b):
    """Return z = cos(theta), the function of `equator`: zero where the axis is horizontal."""
    return s.z


@formula
def near_inversion(s, b):
    """Return z + cos(0.1), the function of `inverted`: zero where theta = pi - 0.1."""
    return s.z + COS_INVERTED


@formula
def sliding(s, b):
    """Return the friction loss k |v_A|^2 less 1e-12, in internal units: the function of `settled`.

    Below zero the motion is settled, because a solution without sliding is a spinning or a tumbling
    one. [T Theorem 3.3.1]
    """
    return friction_loss(s, b) - 1e-12


COS_INVERTED = 0.9950041652780258  # cos(0.1)

TURNING = Event("turning", "turning angle, theta' = 0", theta_turns, sense=-1)
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

OF_SYSTEM: dict[str, Any] = {
    "initial": INITIAL,
    "alternatives": ALTERNATIVES,
    "start": start_of(ANGLES),
    "angles": ANGLES,
    "forms": FORMS,
    "events": EVENTS,
    "undefined_at_poles": UNDEFINED_AT_POLES,
    "vectors": VECTORS,
    "long_names": LONG_NAMES,
    "laws": LAWS,
}
"""Fields of a System."""

ENERGIES = (
    Quantity("energy", "E", JOULE, "energy", energy),
    Quantity("modified_energy", "E~", JOULE, "modified (rolling) energy", modified_energy),
)
QUANTITIES = (
    *ENERGIES,
    Quantity("normal_force", "g_n", NEWTON, "normal force", g_n),
    Quantity("friction_power", "-E'", WATT, "power dissipated by friction", friction_power),
)
"""Columns of a gliding body; `rows` gives them its formulas by their order."""
TORQUE = Unit("kg m2 s-2")
MODIFIED_ENERGY_RATE = Quantity(
    "modified_energy_rate",
    "E~'",
    WATT,
    "rate of the modified energy",
    lambda s, b: modified_energy_rate(push_u(s, b), push_n(s, b), s, b),
)
JELLETT_QUANTITY = Quantity("jellett", "lambda", JELLETT, "Jellett's integral", jellett)
