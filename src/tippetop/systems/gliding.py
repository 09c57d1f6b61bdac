"""A rigid body of revolution that glides on a plane: contact arm a = c*3hat - R*zhat, F = g_n*zhat - k g_n v_A.

c = alpha*R is the tippe top; R = 0, c = -l the gliding heavy top. Equation numbers are those of the source,
Rutstam (2010), where its misprints are corrected; phi is the azimuth of the horizontal projection of 3hat.
Every formula takes its parameters as a `Body`, in any consistent units.
"""

from typing import Any, NamedTuple

from ..friction import slip_coefficient
from ..operand import Operand, Vector, atan2, cos, cross, dot, formula, plus, sin, sqrt, times
from ..system import (
    ANGULAR_MOMENTUM,
    INERTIA,
    JELLETT,
    JOULE,
    KILOGRAM,
    METRE,
    METRE_PER_SECOND,
    METRE_PER_SECOND2,
    NEWTON,
    NEWTON_SECOND,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    WATT,
    Event,
    Form,
    Hazard,
    Parameter,
    Quantity,
)


class Body(NamedTuple):
    """m [kg], R and c [m] of the contact arm, I1 and I3 [kg m^2] about the centre of mass, g [m/s^2], friction law."""

    m: Operand
    R: Operand
    c: Operand
    I1: Operand
    I3: Operand
    g: Operand
    friction: Any


def body_units(friction: Any) -> Body:
    """The units of a Body."""
    return Body(KILOGRAM, METRE, METRE, INERTIA, INERTIA, METRE_PER_SECOND2, friction)


# --- what the quantities are written in -----------------------------------------------------------------------------


class Scalars(NamedTuple):
    """Functions of the state that do not depend on the form; all are smooth at the poles (section 3.4)."""

    z: Operand  # cos(theta)
    s2: Operand  # sin(theta)^2
    z_dot: Operand  # -theta' sin(theta)
    fall: Operand  # z'' of the axis if no torque acted
    precession: Operand  # phi' sin(theta)^2
    axis_speed2: Operand  # |3hat'|^2 = theta'^2 + phi'^2 sin(theta)^2
    L3: Operand  # L.3hat
    Lz: Operand  # L.zhat, about the centre of mass
    v_u: Operand  # v_A.3hat = nu_x sin(theta)
    v_n: Operand  # (3hat x v_A).zhat = nu_y sin(theta)
    v2: Operand  # |v_A|^2
    speed2: Operand  # |r'|^2, horizontal velocity of the centre of mass


@formula
def yielding(s, b):
    """Upward acceleration of the contact point per unit of g_n/m; must be positive. [denominator of T 3.16]"""
    slip = slip_coefficient(s.v2, s.z, b.friction) * s.v_u
    return 1 + b.m * b.c / b.I1 * (b.c * (1 - s.z * s.z) - (b.R - b.c * s.z) * slip)


@formula
def g_n(s, b):
    """Normal force g_n [N], from zhat.(dv_A/dt) = 0. [T 3.16, 3.34, 5.6]"""
    return b.m * (b.g - b.c * s.fall) / yielding(s, b)


@formula
def friction_loss(s, b):
    """Friction power per unit of normal force, k |v_A|^2 [m/s]."""
    return slip_coefficient(s.v2, s.z, b.friction) * s.v2


@formula
def friction_power(s, b):
    """Rate at which friction takes energy, k g_n |v_A|^2 = -E' [W]. [T 3.8]"""
    return friction_loss(s, b) * g_n(s, b)


@formula
def jellett(s, b):
    """Jellett's integral lambda = -L.a = R L_z - c L_3 [kg m^3/s]; constant for any force at A. [T 3.18]"""
    return b.R * s.Lz - b.c * s.L3


@formula
def rotation_energy(s, b):
    """Half omega.L [J], about the centre of mass."""
    return (b.I1 * s.axis_speed2 + s.L3**2 / b.I3) / 2


@formula
def height_energy(z, b):
    """Energy of weight m g s_z [J], s_z = R - c z the height of the centre of mass."""
    return b.m * b.g * (b.R - b.c * z)


@formula
def energy(s, b):
    """Energy E [J]; E' = -k g_n |v_A|^2. [T 3.7]"""
    return b.m * (s.speed2 + (b.c * s.z_dot) ** 2) / 2 + rotation_energy(s, b) + height_energy(s.z, b)


@formula
def arm2(z, b):
    """|a|^2 = R^2 + c^2 - 2 c R z, squared distance from the centre of mass to the contact [m^2]."""
    return b.R**2 + b.c**2 - 2 * (b.c * b.R * z)


@formula
def arm_speed2(s, b):
    """|omega x a|^2 [m^2/s^2]: the speed that the centre of mass would have if the body rolled. [section 3.3]"""
    w3, q = s.L3 / b.I3, b.c - b.R * s.z
    return q**2 * s.axis_speed2 + b.R**2 * (s.z_dot**2 + s.s2 * w3**2) + 2 * b.R * w3 * q * s.precession


@formula
def modified_energy(s, b):
    """Modified (rolling) energy E~ = m|omega x a|^2/2 + omega.L/2 + m g s_z [J]. [T 4.15, 5.23]"""
    return b.m * arm_speed2(s, b) / 2 + rotation_energy(s, b) + height_energy(s.z, b)


@formula
def modified_energy_rate(push_u, push_n, s, b):
    """E~' = m (omega x a).(dv_A/dt) [W]; push_u = 3hat.(dv_A/dt), push_n = (zhat x 3hat).(dv_A/dt). [T 4.18, 4.22]"""
    turn = (b.c - b.R * s.z) * s.precession + b.R * (s.L3 / b.I3) * s.s2
    return b.m * ((b.R - b.c * s.z) * (s.z_dot * push_u) + turn * push_n) / s.s2


@formula
def vertical_inertia(z, b):
    """Half of I1 + m c^2 sin(theta)^2 [kg m^2]: the factor of theta'^2 where the reaction is vertical. [section 3.3]"""
    return (b.I1 + b.m * b.c**2 * ((1 - z) * (1 + z))) / 2


@formula
def vertical_potential(z, Lz, L3, b):
    """E - m|r'|^2/2 - vertical_inertia theta'^2 [J], by L_z and L_3 about the centre of mass: without friction both
    are constant, and this is the effective potential of the nutation."""
    return height_energy(z, b) + L3**2 / (2 * b.I3) + (Lz - L3 * z) ** 2 / (2 * b.I1 * ((1 - z) * (1 + z)))


# --- vector form: regular everywhere --------------------------------------------------------------------------------


class VectorState(NamedTuple):
    """3hat, L and L_3 = L.3hat about the centre of mass, velocity and place of the centre of mass; then the integrals
    of friction power and normal force. L_3 is carried because L_3' and L_z' are one product: it saves three."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    L3: Operand
    rx_dot: Operand
    ry_dot: Operand
    x: Operand
    y: Operand
    work: Operand
    impulse: Operand


VECTOR_UNITS = VectorState._make(
    (*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 4, *(METRE_PER_SECOND,) * 2, METRE, METRE, JOULE, NEWTON_SECOND)
)
QUADRATURES = ("x", "y", "work", "impulse")


@formula
def axis(q):
    """3hat, unit vector along the axis of the body, (3,), space frame."""
    return Vector(q.ux, q.uy, q.uz)


@formula
def momentum(q):
    """Angular momentum L about the centre of mass, (3,), space frame [kg m^2/s]."""
    return Vector(q.Lx, q.Ly, q.Lz)


@formula
def axis_rate(q, b):
    """3hat' = L x 3hat/I1 [1/s]. [T 3.17]"""
    return times(1 / b.I1, cross(momentum(q), axis(q)))


@formula
def angular_velocity(u, L, L3, b):
    """omega = L/I1 + (1/I3 - 1/I1) L_3 3hat [1/s]. [section 1]"""
    return plus(times(1 / b.I1, L), times((1 / b.I3 - 1 / b.I1) * L3, u))


@formula
def contact_velocity(q, b):
    """v_A = r' + omega x a, horizontal, (3,) [m/s]. [T 3.3]"""
    u_dot, w = axis_rate(q, b), angular_velocity(axis(q), momentum(q), q.L3, b)
    return Vector(q.rx_dot + b.c * u_dot.x - b.R * w.y, q.ry_dot + b.c * u_dot.y + b.R * w.x, 0.0)


@formula
def torque_free_fall(q, b):
    """z'' of the axis if no torque acted, (L x 3hat')_z/I1 [1/s^2]."""
    u_dot = axis_rate(q, b)
    return (q.Lx * u_dot.y - q.Ly * u_dot.x) / b.I1


@formula
def vector_scalars(q, b):
    """The scalars of a vector state. L_3 is L.3hat, so that the carried L_3 is under control too."""
    u, L = axis(q), momentum(q)
    u_dot, v = axis_rate(q, b), contact_velocity(q, b)
    return Scalars(
        z=u.z,
        s2=u.x * u.x + u.y * u.y,
        z_dot=u_dot.z,
        fall=torque_free_fall(q, b),
        precession=u.x * u_dot.y - u.y * u_dot.x,
        axis_speed2=dot(u_dot, u_dot),
        L3=dot(L, u),
        Lz=L.z,
        v_u=u.x * v.x + u.y * v.y,
        v_n=u.x * v.y - u.y * v.x,
        v2=v.x * v.x + v.y * v.y,
        speed2=q.rx_dot**2 + q.ry_dot**2,
    )


@formula
def vector_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, m r'' = F_h. [T 3.12, 3.17; 5.2]"""
    u_dot, v, scalars = axis_rate(q, b), contact_velocity(q, b), vector_scalars(q, b)
    N = g_n(scalars, b)
    F = times(-(slip_coefficient(scalars.v2, scalars.z, b.friction) * N), v)
    h = b.R - b.c * q.uz
    twist = q.ux * F.y - q.uy * F.x  # (3hat x F)_z
    return VectorState(
        u_dot.x,
        u_dot.y,
        u_dot.z,
        b.c * (q.uy * N) + h * F.y,
        -(b.c * (q.ux * N)) - h * F.x,
        b.c * twist,
        b.R * twist,
        F.x / b.m,
        F.y / b.m,
        q.rx_dot,
        q.ry_dot,
        friction_power(scalars, b),
        N,
    )


# --- Euler-angle form: singular at the poles ------------------------------------------------------------------------


class EulerState(NamedTuple):
    """theta, theta', phi', omega_3, v_A = nu_x e + nu_y 2hat; then what the equations do not read."""

    theta: Operand
    theta_dot: Operand
    phi_dot: Operand
    omega3: Operand
    nu_x: Operand
    nu_y: Operand
    phi: Operand
    x: Operand
    y: Operand
    work: Operand
    impulse: Operand


EULER_UNITS = EulerState._make(
    (RADIAN, *(RADIAN_PER_SECOND,) * 3, *(METRE_PER_SECOND,) * 2, RADIAN, METRE, METRE, JOULE, NEWTON_SECOND)
)


@formula
def centre_velocity(e, s, z, b):
    """Components of the velocity of the centre of mass along e and 2hat [m/s]. [section 3.2]"""
    along_e = e.nu_x + e.theta_dot * (b.R - b.c * z)
    return along_e, e.nu_y - s * (b.R * e.omega3 + e.phi_dot * (b.c - b.R * z))


@formula
def euler_scalars(e, b):
    """The scalars of an Euler-angle state."""
    s, z = sin(e.theta), cos(e.theta)
    along_e, along_2 = centre_velocity(e, s, z, b)
    L3 = b.I3 * e.omega3
    precession = e.phi_dot * s**2
    axis_speed2 = e.theta_dot**2 + (e.phi_dot * s) ** 2
    return Scalars(
        z=z,
        s2=s**2,
        z_dot=-(e.theta_dot * s),
        fall=L3 / b.I1 * precession - z * axis_speed2,
        precession=precession,
        axis_speed2=axis_speed2,
        L3=L3,
        Lz=b.I1 * precession + L3 * z,
        v_u=e.nu_x * s,
        v_n=e.nu_y * s,
        v2=e.nu_x**2 + e.nu_y**2,
        speed2=along_e**2 + along_2**2,
    )


@formula
def euler_rates(e, b):
    """The solved equations in Euler angles. [T 3.29-3.34 with 3.32 and 3.34 corrected; 5.14-5.18]"""
    s, z = sin(e.theta), cos(e.theta)
    scalars = euler_scalars(e, b)
    N = g_n(scalars, b)
    k = slip_coefficient(scalars.v2, scalars.z, b.friction)
    Fx, Fy = -(k * N * e.nu_x), -(k * N * e.nu_y)  # along e and 2hat
    h, q = b.R - b.c * z, b.c - b.R * z
    along_e, along_2 = centre_velocity(e, s, z, b)
    theta_dot2 = s / b.I1 * (b.I1 * e.phi_dot**2 * z - b.I3 * e.omega3 * e.phi_dot - b.c * N) - h * Fx / b.I1
    phi_dot2 = (b.I3 * e.theta_dot * e.omega3 - 2 * b.I1 * e.theta_dot * e.phi_dot * z + Fy * q) / (b.I1 * s)
    nu_x_dot = (
        s / b.I1 * (e.phi_dot * e.omega3 * (b.I3 * h - b.I1 * b.R) + b.c * h * N - b.I1 * b.c * scalars.axis_speed2)
        + Fx * (1 / b.m + h**2 / b.I1)
        + e.phi_dot * e.nu_y
    )
    nu_y_dot = (
        Fy * (1 / b.m + q**2 / b.I1 + (b.R * s) ** 2 / b.I3)
        + e.omega3 * e.theta_dot / b.I1 * (b.I3 * q + b.I1 * b.R * z)
        - e.phi_dot * e.nu_x
    )
    return EulerState(
        e.theta_dot,
        theta_dot2,
        phi_dot2,
        b.R * s * Fy / b.I3,
        nu_x_dot,
        nu_y_dot,
        e.phi_dot,
        along_e * cos(e.phi) - along_2 * sin(e.phi),
        along_e * sin(e.phi) + along_2 * cos(e.phi),
        friction_power(scalars, b),
        N,
    )


# --- the chart between them -----------------------------------------------------------------------------------------


@formula
def axis_and_momentum(e, s, z, I1, I3):
    """3hat and the angular momentum of a body with transverse moment I1 and axial moment I3, (3,) each. [section 1]"""
    ex, ey = cos(e.phi), sin(e.phi)
    L3, transverse, nodal = I3 * e.omega3, -(I1 * e.phi_dot * s), I1 * e.theta_dot
    lean = transverse * z + L3 * s  # L along e; 1hat = z e - s zhat
    return Vector(s * ex, s * ey, z), Vector(lean * ex - nodal * ey, lean * ey + nodal * ex, L3 * z - transverse * s)


@formula
def vector_of_angles(e, s, z, b):
    """The vector state of an Euler-angle state; s, z are its sin(theta), cos(theta), exact at the poles. [section 1]"""
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    along_e, along_2 = centre_velocity(e, s, z, b)
    ex, ey = cos(e.phi), sin(e.phi)
    return VectorState(
        u.x,
        u.y,
        u.z,
        L.x,
        L.y,
        L.z,
        b.I3 * e.omega3,
        along_e * ex - along_2 * ey,
        along_e * ey + along_2 * ex,
        e.x,
        e.y,
        e.work,
        e.impulse,
    )


@formula
def angles_of_vector(q, b):
    """The Euler-angle state of a vector state; 0/0 exactly at a pole, where phi and what is taken along it mean
    nothing. theta is atan2(sin, cos): no digits are lost near the poles. [section 3.4]"""
    c = vector_scalars(q, b)
    s = sqrt(c.s2)
    return EulerState(
        atan2(s, c.z),
        -c.z_dot / s,
        c.precession / c.s2,
        c.L3 / b.I3,
        c.v_u / s,
        c.v_n / s,
        atan2(q.uy, q.ux),
        q.x,
        q.y,
        q.work,
        q.impulse,
    )


@formula
def euler_of_angles(e, s, z, b):
    """The Euler form is its own chart."""
    return e


@formula
def angles_of_euler(e, b):
    """The same angles with theta in [0, pi] and phi in (-pi, pi]: by way of the vector state."""
    return angles_of_vector(vector_of_angles(e, sin(e.theta), cos(e.theta), b), b)


# --- initial data, events, quantities -------------------------------------------------------------------------------

INITIAL = {
    "theta": Parameter(RADIAN, "inclination theta of the axis", least=0, most=3.141592653589793),
    "theta_dot": Parameter(RADIAN_PER_SECOND, "theta'"),
    "phi": Parameter(RADIAN, "azimuth phi of the horizontal projection of the axis"),
    "phi_dot": Parameter(RADIAN_PER_SECOND, "phi'"),
    "omega3": Parameter(RADIAN_PER_SECOND, "angular velocity omega_3 about the axis"),
    "nu_x": Parameter(METRE_PER_SECOND, "contact velocity along e"),
    "nu_y": Parameter(METRE_PER_SECOND, "contact velocity along 2hat"),
    "x": Parameter(METRE, "x of the centre of mass"),
    "y": Parameter(METRE, "y of the centre of mass"),
    "psi_dot": Parameter(RADIAN_PER_SECOND, "psi', instead of omega3"),
}


def given_angles(angles: Any, data: dict[str, Any], z: Any) -> Any:
    """The record of angles of what a person gave, the rest zero; psi_dot may stand for omega3."""
    e = angles(*(data.get(name, 0) for name in angles._fields))
    return e._replace(omega3=data["psi_dot"] + e.phi_dot * z) if "psi_dot" in data else e


def start(data: dict[str, Any], s: Any, z: Any, b: Body) -> EulerState:
    """The Euler record of what a person gave; centre_at_rest may stand for nu_x and nu_y."""
    e = given_angles(EulerState, data, z)
    if data.get("centre_at_rest"):
        along_e, along_2 = centre_velocity(e, s, z, b)
        e = e._replace(nu_x=e.nu_x - along_e, nu_y=e.nu_y - along_2)
    return e


@formula
def away_from_pole(s, b):
    """sin(theta)^2."""
    return s.s2


JAMMED = Hazard(yielding, "the friction jams the contact (denominator of g_n not positive): no solution of the model")
POLE = Hazard(away_from_pole, 'the Euler-angle form is singular where sin(theta) = 0: use form = "vector"')

VECTOR = Form(
    "vector", VECTOR_UNITS, vector_rates, vector_scalars, vector_of_angles, angles_of_vector, QUADRATURES, (JAMMED,)
)
EULER = Form(
    "euler",
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    euler_of_angles,
    angles_of_euler,
    ("phi", *QUADRATURES),
    (JAMMED, POLE),
)
FORMS = {form.name: form for form in (VECTOR, EULER)}
VECTORS = {"axis": ("ux", "uy", "uz"), "L": ("Lx", "Ly", "Lz")}
LONG_NAMES = {
    **{name: parameter.long_name for name, parameter in INITIAL.items()},
    "phi": "azimuth phi of the horizontal projection of the axis; undefined (NaN) exactly at a pole",
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
    """z' = -theta' sin(theta): zero at the turning angles, and at a pole."""
    return s.z_dot


@formula
def equator(s, b):
    """z = cos(theta): zero where the axis is horizontal."""
    return s.z


@formula
def near_inversion(s, b):
    """z + cos(0.1): falls through zero where theta rises through pi - 0.1."""
    return s.z + COS_INVERTED


@formula
def sliding(s, b):
    """Friction loss less 1e-12, in internal units: below it the motion is settled, because a solution without sliding
    is a spinning or a tumbling one. [T Theorem 3.3.1]"""
    return friction_loss(s, b) - 1e-12


COS_INVERTED = 0.9950041652780258  # cos(0.1)

TURNING = Event("turning", "turning angle, theta' = 0", turning, sense=-1)
LIFTOFF = Event("liftoff", "normal force g_n falls to zero: beyond it the model does not hold", g_n, -1, stops=True)
EQUATOR = Event("equator", "theta = pi/2", equator)
FALLEN = Event("equator", "theta = pi/2: the body has fallen to the plane", equator, stops=True)
INVERTED = Event("inverted", "theta rises through pi - 0.1", near_inversion, -1)
SETTLED = Event("settled", "sliding dies out: friction loss below 1e-12 sqrt(gR)", sliding, -1)
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
JELLETT_QUANTITY = Quantity("jellett", "lambda", JELLETT, "Jellett's integral", jellett)
