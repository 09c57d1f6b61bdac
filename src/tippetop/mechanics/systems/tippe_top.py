"""The tippe top: a sphere that rolls and glides. [T ch. 3, 4]

`TippeTop` takes the numbers of the user; the constants at the end are the `System` TIPPE_TOP, whose
equations are those of `contact.gliding`. The functions are quantities and the effective potential,
which the theory of the thesis has and other bodies do not. With alpha < 0 it is a peg: its centre
of mass lies above the centre of the sphere where theta = 0.

Symbols
    b         the body, a `Touch`: radius R, c = alpha R, moments I1, I3 about the centre of mass
    s         the scalars of a state: z = cos(theta), L3 = L.3hat, and others; z_dot = z'
    D         Routh's function; lambda, lam: Jellett's integral; both constant in pure rolling
    d(z)      a number that relates D to L3, see `spinning.d`; gamma = I1/I3, sigma = m R^2/I3
    E~, V     modified energy g(z) theta'^2 + V(z, D, lambda), and the effective potential
    v_A       velocity of the contact point; 3hat: the axis of the body
"""

from collections.abc import Mapping
from typing import Any

from ..contact import body as contact
from ..contact import gliding
from ..contact.body import Top, Touch
from ..number import Number, number
from ..operand import formula, sqrt
from ..potential_coefficients import PotentialCoefficients
from ..system import Landscape, Momentum, Opening, Quantity, of_one_phase
from ..theory.spinning import d
from ..theory.thresholds import two_wells_from
from ..units import (
    ANGULAR_MOMENTUM,
    INERTIA,
    JELLETT,
    KILOGRAM,
    METRE,
    METRE_PER_SECOND2,
    ONE,
    PER_METRE_SECOND,
    PER_SECOND,
)
from . import outlook


class TippeTop(Top):
    """A tippe top: a sphere whose centre of mass lies alpha*R below its centre; a peg if alpha < 0.

    Each number may be a text: with a unit, "20 g", or arithmetic of the others, "2/5*m*R^2", whose
    dimension must fit. Rutstam, N.: Study of equations for Tippe Top and related rigid bodies.
    Linkoping (2010), chapter 3.

    >>> import tippetop as tt
    >>> tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-6, I3=3.2e-6, g=9.82)
    TippeTop(m=0.02, R=0.02, alpha=0.3, I1=2.994e-06, I3=3.2e-06, g=9.82)
    """

    gliding = "tippe-top"
    resting = "rolling-tippe-top"
    faults = staticmethod(contact.inertia_faults)

    m: Number = number(KILOGRAM, "mass", symbol="m", above=0)
    R: Number = number(METRE, "radius of the sphere", symbol="R", above=0)
    alpha: Number = number(
        ONE,
        "eccentricity: the centre of mass lies alpha*R below the centre, above it if negative",
        symbol=r"\alpha",
        above=-1,
        below=1,
        nonzero=True,
    )
    I1: Number = number(
        INERTIA, "transverse moment of inertia about the centre of mass", symbol="I_1", above=0
    )
    I3: Number = number(
        INERTIA, "axial moment of inertia about the centre of mass", symbol="I_3", above=0
    )
    g: Number = number(METRE_PER_SECOND2, "acceleration of gravity", symbol="g", above=0)

    def seen(self, friction: Any) -> Touch:
        """Return the body as the `b` of formulas, a `Touch` with c = alpha R.

        `friction` is the record of a law.
        """
        return Touch(self.m, self.R, self.alpha * self.R, self.I1, self.I3, self.g, friction)


def is_peg(parameters: Mapping[str, Any]) -> bool:
    """Return whether these are numbers of a peg, which is lowest near theta = pi."""
    return parameters.get("alpha", 0.0) < 0


@formula
def routh(s, b):
    """Return Routh's function D = I3 omega_3 sqrt(d(z)) [kg m^2/s]; constant in pure rolling.

    [T 4.7, 4.14]
    """
    return s.L3 * sqrt(d(s.z, b))


@formula
def routh_rate(z, push, b):
    """Return D' = gamma m R/sqrt(d) push [kg m^2/s^2], push = (zhat x 3hat).(dv_A/dt).

    [T 4.17]
    """
    return b.I1 / b.I3 * b.m * b.R / sqrt(d(z, b)) * push


@formula
def theta_inertia(z, b):
    """Return g(z) [kg m^2], the factor of theta'^2 in E~ = g(z) theta'^2 + V(z, D, lambda).

    `cylinder` has it too, with its own V(z).

    [T 4.11]
    """
    return (b.I1 + b.m * contact.arm2(z, b)) / 2


@formula
def X(z, D, lam, b):
    """Return X(z) = lambda sqrt(d(z)) + R(alpha - z) D, from which phi' follows. [T 4.9]

    phi' sin(theta)^2 = X/(R I1 sqrt(d)).
    """
    return lam * sqrt(d(z, b)) + (b.c - b.R * z) * D


@formula
def potential(z, D, lam, b):
    """Return the effective potential V(z, D, lambda) [J], z = cos(theta) in (-1, 1).

    [equal to T 4.12]
    """
    w = (1 - z) * (1 + z)
    return (
        contact.height_energy(z, b)
        + b.I3 / (2 * (b.I1 * b.R) ** 2) * X(z, D, lam, b) ** 2 / w
        + D**2 / (2 * b.I1)
        - b.m * lam**2 / (2 * b.I1 * b.I3)
    )


def coefficients(b) -> PotentialCoefficients:
    """Return V in the variable of the landscape, q = tan(theta/2)^2: see `PotentialCoefficients`.

    V of them must equal `potential` (the law of `Landscape`), and K fits d(z) of `spinning.d`.
    `landscape.landscape_body` calls it with a body of decimals, by which no digit is lost, although
    the marked lines cancel. The coefficients of a peg are those of the body with its axis reversed,
    where D is -D.
    """
    turned = b.c < 0
    b = b._replace(c=abs(b.c))
    gamma = b.I1 / b.I3
    sigma = b.m * b.R**2 / b.I3
    alpha = b.c / b.R
    d0 = sqrt(d(1, b))
    d1 = sqrt(d(-1, b))
    per = 2 * b.R * sqrt(2 * b.I1)
    return PotentialCoefficients(
        height_energy=contact.height_energy(1, b),
        height_gain=2 * b.m * b.g * b.c,
        gamma=gamma,
        root_gamma_gain=sqrt(2 * gamma * b.m * b.g * b.c),
        sqrt_d0=d0,
        sqrt_d1=d1,
        K=(gamma - sigma * (1 - alpha) * (1 + alpha) - d0 * d1) / 2 + sigma * gamma,
        a1=(b.R - b.c if turned else b.c - b.R) / per,
        a2=d0 / per,
        b1=(-(b.c + b.R) if turned else b.c + b.R) / per,
        b2=d1 / per,
        k=1 / per,
        spin1=1 / sqrt(2 * b.I3),
        spin2=sqrt(sigma / (2 * b.I3)) / b.R,
        spin22_by_k=sigma / (2 * b.I3 * b.R**2) * per,
    )


LANDSCAPE = Landscape(
    momenta=(
        Momentum("D", ANGULAR_MOMENTUM, "Routh's function D", PER_SECOND, "routh"),
        Momentum("lambda", JELLETT, "Jellett's integral lambda", PER_METRE_SECOND, "jellett"),
    ),
    coefficients=coefficients,
    two_wells=lambda b: two_wells_from(b) < b.I1 / b.I3,
)

MOMENTA = (
    gliding.JELLETT_QUANTITY,
    Quantity("routh", "D", ANGULAR_MOMENTUM, "Routh's function", routh),
)
QUANTITIES = (*MOMENTA, *gliding.QUANTITIES)


@formula
def own_routh_rate(s, b):
    """Return D' [kg m^2/s^2] of a gliding state with these scalars. [T 4.17]"""
    return routh_rate(s.z, contact.push_n(s, b), b)


ON_REQUEST = (
    Quantity("routh_rate", "D'", gliding.TORQUE, "rate of Routh's function", own_routh_rate),
    gliding.MODIFIED_ENERGY_RATE,
)

SOURCE = (
    "Rutstam, N.: Study of equations for Tippe Top and related rigid bodies. Linkoping (2010), "
    "chapter "
)
COMMON: dict[str, Any] = {
    "parameters": TippeTop.parameters,
    "body": TippeTop.body_of,
    "scales": lambda b: (b.m, b.R),
    "normalised_to": {"m": 1.0, "R": 1.0},
    "checks": TippeTop.faults,
    "potential": potential,
    "theta_inertia": theta_inertia,
    "momenta": ("routh", "jellett"),
    "landscape": LANDSCAPE,
    "classes": ("tumbling", "upright", "inverted"),
}
"""Fields of the systems of a tippe top, gliding or rolling. `momenta`, and those of LANDSCAPE, have
the order of the arguments of `potential`.
"""

TIPPE_TOP = of_one_phase(
    "slip",
    name="tippe-top",
    title="rolling and gliding tippe top",
    source=SOURCE + "3",
    quantities=QUANTITIES,
    on_request=ON_REQUEST,
    integrals=("jellett",),
    outlook=outlook.tippe_top,
    opening=Opening(sphere=True, routh=routh, outlook=outlook.tippe_top_with_contact),
    borders=outlook.tippe_top_borders,
    inverts=True,
    **gliding.OF_SYSTEM,
    **COMMON,
)
