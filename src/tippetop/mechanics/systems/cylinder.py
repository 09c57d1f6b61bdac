"""The eccentric cylinder, gliding or with the modified reaction. [T ch. 6]

`Cylinder` takes the numbers of the user, GLIDING_CYLINDER is the `System`. Its motion is planar,
and theta is unbounded. It is the body of `gliding` and `rolling` with phi' = omega_3 = nu_y = 0, so
their quantities serve; there are no poles. The state has sin(theta), cos(theta), and theta is an
integral: a count of turns does not cost digits.

Symbols
    b         the body, a `contact.body.Touch` with c = alpha R, I1 = I; law: record of b.friction
    q         a state: s = sin(theta), z = cos(theta), theta', nu_x; carried: record of integrals
    c         in (c, b): the `Scalars` of a state; e: record of angles
    nu_x, v_A velocity of the contact point; F_x, F_z: force of the plane there
"""

from collections import ChainMap
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ..contact import body as contact
from ..contact import gliding
from ..contact.body import Top, Touch, filled
from ..contact.body_axes import by_angles
from ..contact.integrals import integral
from ..event import Event
from ..friction import LAWS, FrictionLaw, slip_coefficient
from ..number import Number, number, reuse
from ..operand import Operand, formula, select
from ..system import Alternative, Form, Opening, Quantity, of_one_phase
from ..units import (
    INERTIA,
    JOULE,
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    NEWTON_SECOND,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    WATT,
    Unit,
)
from . import outlook, tippe_top


class Cylinder(Top):
    """An eccentric cylinder that moves in a plane across its axis.

    Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping (2010),
    chapter 6.
    """

    gliding = "gliding-cylinder"
    resting = "rolling-cylinder"

    m: Number = reuse(tippe_top.TippeTop.parameters["m"])
    R: Number = number(METRE, "radius of the cylinder", symbol="R", above=0)
    alpha: Number = number(
        ONE,
        "eccentricity: the centre of mass lies alpha*R below the axis",
        symbol=r"\alpha",
        least=0,
        below=1,
    )
    I: Number = number(INERTIA, "moment of inertia about the centre of mass", symbol="I", above=0)
    g: Number = reuse(tippe_top.TippeTop.parameters["g"])

    def seen(self, friction: Any) -> Touch:
        """Return the body as the `b` of formulas, a `Touch` with c = alpha R, I1 = I.

        I3 plays no part. `friction` is the record of a law.
        """
        return Touch(self.m, self.R, self.alpha * self.R, self.I, self.I, self.g, friction)


# --- the modified reaction, as a law of the contact ---------------------------------------------


KILOGRAM_PER_SECOND = Unit("kg s-1")


class Modified(FrictionLaw):
    """Modified reaction: F = g~ zhat + m g zhat - m kappa (omega x a)' - mu v_A.

    F = m (1 - kappa) s_z'' zhat + m kappa s''_rolling + m g zhat - mu v_A [T 6.18], with kappa =
    1/(1 + v_A^2/v_k^2), which tends to 1 as v_A -> 0 (the family is ours, the source leaves kappa
    open).
    """

    words = "modified reaction"
    mu: Number = number(
        KILOGRAM_PER_SECOND, "friction coefficient of -mu v_A", symbol=r"\mu", least=0
    )
    v_k: Number = number(
        METRE_PER_SECOND,
        "speed at which kappa = 1/(1 + v_A^2/v_k^2) is one half",
        symbol="v_k",
        above=0,
    )


@formula
def kappa(v2, law):
    """Return kappa = 1/(1 + v_A^2/v_k^2), the share of the rolling reaction."""
    return 1 / (1 + v2 / law.v_k**2)


# --- gliding ------------------------------------------------------------------------------------


class Scalars(NamedTuple):
    """Scalars of the quantities; names as in `gliding.Scalars`, with phi' = omega_3 = nu_y = 0.

    The last field is that which `rolling_cylinder.rolling_scalars` replaces, by its place.
    """

    z: Operand  # cos(theta)
    s2: Operand  # sin(theta)^2
    z_dot: Operand  # -theta' sin(theta)
    z_ddot_free: Operand  # -theta'^2 cos(theta)
    phi_dot_s2: Operand
    axis_speed2: Operand  # theta'^2
    L3: Operand
    v_u: Operand  # nu_x sin(theta)
    v2: Operand  # nu_x^2
    speed2: Operand  # |r'|^2, horizontal velocity of the centre of mass
    theta_dot: Operand
    s: Operand  # sin(theta)
    nu_x: Operand
    friction_force2: Operand = 0  # of a body that rolls


UNITS = filled(s=ONE, z=ONE, theta_dot=RADIAN_PER_SECOND, nu_x=METRE_PER_SECOND)
"""sin(theta), cos(theta), theta', nu_x."""

ANGLES = filled(
    theta=RADIAN,
    theta_dot=RADIAN_PER_SECOND,
    nu_x=METRE_PER_SECOND,
    x=METRE,
    work=JOULE,
    impulse=NEWTON_SECOND,
)
"""theta, not wrapped, theta', nu_x and the place of the centre of mass; then the integrals."""

State = type(UNITS)


@formula
def scalars(q, b):
    """Return the `Scalars` of a state.

    x' = nu_x + theta' h is also in `start` and in the integral `x`: a change of one is a change of
    all.
    """
    along = q.nu_x + q.theta_dot * contact.height(q.z, b)
    w2 = q.theta_dot**2
    return Scalars(
        z=q.z,
        s2=q.s**2,
        z_dot=-(q.theta_dot * q.s),
        z_ddot_free=-(q.z * w2),
        phi_dot_s2=0,
        axis_speed2=w2,
        L3=0,
        v_u=q.nu_x * q.s,
        v2=q.nu_x**2,
        speed2=along**2,
        theta_dot=q.theta_dot,
        s=q.s,
        nu_x=q.nu_x,
    )


@formula
def standard_force(c, b, law):
    """Return F_x and F_z [N] of F = g_n zhat - k g_n v_A. [T 6.3-6.5]"""
    N = contact.g_n(c, b)
    return -(slip_coefficient(c.v2, c.z, law) * N * c.nu_x), N


@formula
def modified_force(c, b, law):
    """Return F_x and F_z [N] of the law `Modified`.

    They depend on theta'', so `turn` is theta'' of `rates` under these forces, solved for.
    """
    h = contact.height(c.z, b)
    share = kappa(c.v2, law)
    turn = (
        law.mu * c.nu_x * h
        - b.m * b.c * c.axis_speed2 * c.s * (share * h + b.c * c.z)
        - b.m * b.g * b.c * c.s
    ) / (b.I1 + share * b.m * h**2 + b.m * b.c**2 * c.s2)  # theta''
    rolling_x = turn * h + b.c * c.axis_speed2 * c.s  # what m s_x'' would be in rolling
    return b.m * share * rolling_x - law.mu * c.nu_x, b.m * (
        b.g + b.c * (turn * c.s + c.axis_speed2 * c.z)
    )


contact_force = select(lambda law: modified_force if isinstance(law, Modified) else standard_force)
"""contact_force(scalars, b, law): F_x and F_z, for any law of the cylinder."""


def contact_mobility(c, b):
    """Return a number that is positive unless the contact jams.

    Under the modified reaction it never does.
    """
    return 1.0 if type(b.friction) is Modified else contact.contact_mobility(c, b)


@formula
def rates(q, b):
    """Return the rates of a state, from I theta'' = (a x F)_y and m r'' = F_x. [T 6.1, 6.2]"""
    c = scalars(q, b)
    Fx, N = contact_force(c, b, b.friction)
    h = contact.height(q.z, b)
    theta_dot2 = -(b.c * q.s * N + h * Fx) / b.I1
    # the last one is the rate of nu_x = x' - theta' h, with h' = c theta' s
    return State(
        q.z * q.theta_dot,
        -(q.s * q.theta_dot),
        theta_dot2,
        Fx / b.m - theta_dot2 * h - b.c * c.axis_speed2 * q.s,
    )


@formula
def of_angles(e, s, z, b):
    """Return the state of angles e; s, z are sin(theta), cos(theta)."""
    return State(s, z, e.theta_dot, e.nu_x)


def to_angles(units: Any) -> Callable:
    """Return to_angles(q, carried, b) of a form whose angles are state and integrals.

    They are found by name: each field of `units` is a variable of the state or an integral.
    """

    def angles(q: Any, carried: Any, b: Any) -> Any:
        """Return the record of angles: the state and the integrals."""
        known = {**q._asdict(), **carried._asdict()}
        return type(units)(*(known[name] for name in units._fields))

    return angles


def start(data: dict[str, Any], s: Any, z: Any, b: Touch) -> Any:
    """Return the record of angles from the user's numbers `data`.

    centre_at_rest may replace nu_x. It is `System.start`; s is sin(theta), z is cos(theta).
    """
    e = type(ANGLES)(*(data.get(name, 0) for name in ANGLES._fields))
    return (
        e._replace(nu_x=e.nu_x - e.theta_dot * contact.height(z, b))
        if data.get("centre_at_rest")
        else e
    )


@formula
def normal_force(c, b):
    """Return the normal force F_z [N]. [T 6.5]"""
    _, N = contact_force(c, b, b.friction)
    return N


@formula
def friction_power(c, b):
    """Return -F.v_A = -E' [W]; negative where the modified reaction feeds energy in. [T 6.23]"""
    Fx, _ = contact_force(c, b, b.friction)
    return -(Fx * c.nu_x)


@formula
def turning(c, b):
    """Return theta', the function of the event `turning`."""
    return c.theta_dot


@formula
def sliding(c, b):
    """Return |v_A|^2 less 1e-12, in internal units: the function of `settled`.

    Unlike `gliding.sliding` it does not read the coefficient of the law, which `Modified` lacks.
    The bound is in words in SETTLED: a change of one is a change of both.
    """
    return c.v2 - 1e-12


NOT_JAMMED = replace(gliding.NOT_JAMMED, formula=contact_mobility)
FORM = Form(
    "angle",
    UNITS,
    rates,
    scalars,
    of_angles,
    to_angles(ANGLES),
    integrals=(
        integral("theta", lambda q, carried, b: q.theta_dot),
        integral("x", lambda q, carried, b: q.nu_x + q.theta_dot * contact.height(q.z, b)),
        integral("work", lambda q, carried, b: friction_power(scalars(q, b), b)),
        integral("impulse", lambda q, carried, b: normal_force(scalars(q, b), b)),
    ),
    orientation=by_angles(lambda q: (q.s, q.z)),
    domains=(NOT_JAMMED,),
)
TURNING = Event("turning", "turning angle, theta' = 0", turning, sense=1)
LIFTOFF = replace(
    gliding.LIFTOFF,
    long_name="normal force falls to zero: beyond it the model is not valid",
    formula=normal_force,
)
SETTLED = replace(
    gliding.SETTLED, long_name="|v_A|^2 falls below 1e-12 of its unit", formula=sliding
)


# --- the system ---------------------------------------------------------------------------------

INITIAL = {
    "theta": Number(
        RADIAN, "angle theta of the axis of eccentricity, not wrapped", symbol=r"\theta"
    ),
    "theta_dot": Number(RADIAN_PER_SECOND, "theta'", symbol=r"\theta'"),
    "x": Number(METRE, "x of the centre of mass"),
}
LONG_NAMES = {
    **gliding.LONG_NAMES,
    **{name: parameter.long_name for name, parameter in INITIAL.items()},
    "nu_x": "velocity of the contact point of the cylinder",
}
COMMON: dict[str, Any] = {
    "parameters": Cylinder.parameters,
    "body": Cylinder.body_of,
    "scales": lambda b: (b.m, b.R),
    "normalised_to": {"m": 1.0, "R": 1.0},
    "long_names": LONG_NAMES,
    "potential": contact.height_energy,
    "theta_inertia": tippe_top.theta_inertia,
}

GLIDING_CYLINDER = of_one_phase(
    "slip",
    name="gliding-cylinder",
    title="eccentric cylinder that rolls and glides",
    source=tippe_top.SOURCE + "6",
    initial={
        **INITIAL,
        "nu_x": Number(
            METRE_PER_SECOND, "velocity of the contact point of the cylinder", symbol=r"\nu_x"
        ),
    },
    alternatives=(Alternative("centre_at_rest", ("nu_x",), flag=True),),
    start=start,
    angles=ANGLES,
    forms={"angle": FORM},
    quantities=(
        *gliding.ENERGIES,
        Quantity("normal_force", "F_z", NEWTON, "normal force", normal_force),
        Quantity("friction_power", "-E'", WATT, "power dissipated by friction", friction_power),
    ),
    integrals=(),
    events=(TURNING, LIFTOFF, gliding.EQUATOR, SETTLED),
    laws=ChainMap({"modified": Modified}, LAWS),  # it includes later additions to LAWS
    outlook=outlook.gliding_cylinder,
    opening=Opening(planar=True),
    **COMMON,
)
