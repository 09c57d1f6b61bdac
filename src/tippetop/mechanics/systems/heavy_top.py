"""Heavy symmetric tops, and the one whose tip is fixed. [T ch. 2]

`HeavyTop` takes the numbers of the user: mass m, distance l from the tip to the centre of mass, I1
and I3 about the latter. HEAVY_TOP is the `System` with a fixed tip; the other one glides on a
plane: `gliding_heavy_top`. Both are bodies with R = 0, c = -l.

Symbols
    b         the body, a `contact.body.Touch`; I1* = I1 + m l^2: transverse moment about the tip
    q         a state of the vector form: 3hat and L_A; e: one of angles; s, z: sin, cos of theta
    s         in (s, b): the scalars of a state, about the centre of mass
    L_A       angular momentum about the tip; L = L_A - m l^2 3hat x 3hat' about the centre of mass
    L3, Lz    L.3hat, the same about both points; L_A.zhat
    V, E~     effective potential V(z, Lz, L3), energy E~ = I1* theta'^2/2 + V; z = cos(theta)
"""

from dataclasses import replace
from typing import Any

from ..contact import body as contact
from ..contact import gliding, rolling
from ..contact.body import Top, Touch, tip_inertia
from ..contact.body_axes import carried_along
from ..contact.gliding import axis, turning
from ..contact.integrals import integral
from ..number import Number, number, reuse
from ..operand import cross, formula, plus, sqrt, times
from ..potential_coefficients import PotentialCoefficients
from ..system import Form, Landscape, Momentum, Quantity, of_one_phase
from ..units import (
    ANGULAR_MOMENTUM,
    METRE,
    NEWTON_SECOND,
    PER_SECOND,
    RADIAN,
)
from . import outlook
from .tippe_top import SOURCE, TippeTop


class HeavyTop(Top):
    """A heavy symmetric top: with a fixed tip, or with a tip that glides on the plane.

    Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping (2010),
    chapters 2 and 5.
    """

    gliding = "gliding-heavy-top"
    resting = "heavy-top"
    faults = staticmethod(contact.inertia_faults)

    m: Number = reuse(TippeTop.parameters["m"])
    l: Number = number(METRE, "distance from the tip to the centre of mass", symbol="l", above=0)
    I1: Number = reuse(TippeTop.parameters["I1"])
    I3: Number = reuse(TippeTop.parameters["I3"])
    g: Number = reuse(TippeTop.parameters["g"])

    def seen(self, friction: Any) -> Touch:
        """Return the body as the `b` of formulas, a `Touch` with R = 0 and c = -l.

        `friction` is the record of a law.
        """
        return Touch(self.m, 0 * self.l, -self.l, self.I1, self.I3, self.g, friction)


# --- quantities ---------------------------------------------------------------------------------


@formula
def potential(z, Lz, L3, b):
    """Return the effective potential V(z, L_z, L_3) [J] of both heavy tops; L_z, L_3 about the tip.

    [T 2.38, 5.26]
    """
    return (
        L3**2 / (2 * b.I3)
        + (Lz - L3 * z) ** 2 / (2 * tip_inertia(b) * ((1 - z) * (1 + z)))
        - b.m * b.g * b.c * z
    )


def coefficients(b) -> PotentialCoefficients:
    """Return V of both heavy tops, seen upside down, in q = cot(theta/2)^2.

    The momenta are (L3, Lz); see `PotentialCoefficients`. V of them must equal `potential`, which
    takes (Lz, L3). Zeros and ones have the type of the numbers of b, such as Decimal.
    """
    zero = 0 * b.m
    one = 1 + 0 * b.m
    per = 2 * sqrt(2 * tip_inertia(b))
    return PotentialCoefficients(
        height_energy=b.m * b.g * b.c,
        height_gain=-2 * b.m * b.g * b.c,
        gamma=one,
        root_gamma_gain=sqrt(-2 * b.m * b.g * b.c),
        sqrt_d0=one,
        sqrt_d1=one,
        K=zero,
        a1=1 / per,
        a2=1 / per,
        b1=-1 / per,
        b2=1 / per,
        k=zero,
        spin1=1 / sqrt(2 * b.I3),
        spin2=zero,
        spin22_by_k=zero,
    )


LANDSCAPE = Landscape(
    momenta=(
        Momentum("L3", ANGULAR_MOMENTUM, "angular momentum L_3 about the axis", PER_SECOND, "L3"),
        Momentum(
            "Lz",
            ANGULAR_MOMENTUM,
            "angular momentum L_z about the vertical, at the tip",
            PER_SECOND,
            "Lz",
        ),
    ),
    coefficients=coefficients,
)


@formula
def theta_inertia(z, b):
    """Return I1*/2, the factor of theta'^2 in E~ = I1* theta'^2/2 + V(z, L_z, L_3) [kg m^2].

    [T 2.38, 5.26]
    """
    return tip_inertia(b) / 2


@formula
def L3(s, b):
    """Return L3 = I3 omega_3 [kg m^2/s] from the scalars; constant for any force at the tip.

    [T 2.37, 5.7]
    """
    return s.L3


@formula
def Lz(s, b):
    """Return Lz = L_A.zhat [kg m^2/s] from the scalars; constant where the tip is fixed.

    [T 2.36, 5.19]
    """
    return s.Lz + b.m * b.c**2 * s.phi_dot_s2


@formula
def tip_axis_rate(q, b):
    """Return 3hat' = L_A x 3hat/I1*, (3,) [1/s], of a state q. [T 2.24]"""
    return times(1 / tip_inertia(b), cross(turning(q).L, axis(q)))


@formula
def momentum_about_centre(q, b):
    """Return L = L_A - m l^2 3hat x 3hat', (3,) [kg m^2/s], of a state q.

    `fixed_scalars` takes it, because scalars are about the centre of mass.
    """
    return plus(turning(q).L, times(-(b.m * b.c**2), cross(axis(q), tip_axis_rate(q, b))))


# --- fixed tip ----------------------------------------------------------------------------------


@formula
def fixed_scalars(q, b):
    """Return the scalars of a state q: those of a body that rolls with R = 0.

    `rolling.euler_scalars` of the same motion are equal, and serve the form in Euler angles.
    """
    x = contact.Turning(axis(q), momentum_about_centre(q, b))
    u_dot = tip_axis_rate(q, b)
    return rolling.scalars(x, u_dot, times(b.c, u_dot), b)


@formula
def fixed_rates(q, b):
    """Return the rates of a state q: 3hat' = L_A x 3hat/I1*, L_A' = l 3hat x (-m g zhat).

    [T 2.24]
    """
    u = axis(q)
    u_dot = tip_axis_rate(q, b)
    weight = b.m * b.g * b.c
    return rolling.VectorState(u_dot.x, u_dot.y, u_dot.z, weight * u.y, -(weight * u.x), 0 * u.z)


@formula
def vertical_reaction(q, carried, b):
    """Return the vertical reaction at the tip, m (g - c z'') [N].

    I1* z'' = (L_A' x 3hat)_z + (L_A x (L_A x 3hat))_z/I1*. It is not computed by 3hat': an
    expression that shares products with the equations of motion changes how they are compiled, and
    so their bits.
    """
    turn = q.Lz * (q.Lx * q.ux + q.Ly * q.uy) - q.uz * (q.Lx * q.Lx + q.Ly * q.Ly)
    weight = b.m * b.g * b.c * ((1 - q.uz) * (1 + q.uz))
    inertia = tip_inertia(b)
    return b.m * (b.g - b.c * ((weight + turn / inertia) / inertia))


ANGLES = contact.filled(**rolling.EULER_UNITS._asdict(), phi=RADIAN, impulse=NEWTON_SECOND)
"""theta, theta', phi', omega_3, phi; and the integral of the vertical reaction."""


def vector_of_angles(e, s, z, b):
    """Return the state q of angles e; s, z are sin(theta), cos(theta).

    With I1* in place of I1 the momentum is that about the tip.
    """
    return rolling.vector_of_angles(e, s, z, b._replace(I1=tip_inertia(b)))


angles_of_vector = gliding.angles_by(ANGLES, fixed_scalars)
FIXED_VECTOR = Form(
    "vector",
    rolling.VECTOR_UNITS,
    fixed_rates,
    fixed_scalars,
    vector_of_angles,
    angles_of_vector,
    integrals=(integral("impulse", vertical_reaction),),
    orientation=carried_along(tip_axis_rate, rolling.spin),
)
FIXED_EULER = gliding.in_euler_angles(
    ANGLES,
    rolling.EULER_UNITS,
    rolling.euler_rates,
    rolling.euler_scalars,
    (integral("impulse", rolling.vertical_force),),
)


# --- the system ---------------------------------------------------------------------------------

MOMENTA = (
    Quantity("L3", "L_3", ANGULAR_MOMENTUM, "angular momentum about the axis", L3),
    Quantity(
        "Lz", "L_z", ANGULAR_MOMENTUM, "angular momentum about the vertical through the tip", Lz
    ),
)
COMMON: dict[str, Any] = {
    "parameters": HeavyTop.parameters,
    "body": HeavyTop.body_of,
    "scales": lambda b: (b.m, -b.c),
    "normalised_to": {"m": 1.0, "R": 0.0, "c": -1.0},
    "checks": HeavyTop.faults,
    "potential": potential,
    "theta_inertia": theta_inertia,
    "momenta": ("Lz", "L3"),  # as arguments of `potential`; LANDSCAPE has L3 first
    "landscape": LANDSCAPE,
    "classes": ("tumbling", "upright", "inverted"),
}
HEAVY_TOP = of_one_phase(
    "fixed",
    name="heavy-top",
    title="heavy symmetric top whose tip is fixed",
    source=SOURCE + "2",
    quantities=(*MOMENTA, *gliding.ENERGIES, *rolling.REACTION[:2]),
    outlook=outlook.heavy_top,
    motion=outlook.heavy_top_motion,
    **rolling.OF_SYSTEM
    | {
        "initial": {
            name: rule
            for name, rule in rolling.OF_SYSTEM["initial"].items()
            if name not in ("x", "y")
        },
        "start": gliding.start_of(ANGLES),
        "angles": ANGLES,
        "forms": {"vector": FIXED_VECTOR, "euler": FIXED_EULER},
        "integrals": ("L3", "Lz", "energy"),
        "events": (
            gliding.TURNING,
            replace(
                rolling.LIFTOFF,
                long_name="vertical reaction falls to zero: beyond it a tip that merely stood "
                "would lift off",
                ends=None,
            ),
            gliding.EQUATOR,
        ),
        "long_names": {**gliding.LONG_NAMES, "L": "angular momentum about the tip, space frame"},
    },
    **COMMON,
)
