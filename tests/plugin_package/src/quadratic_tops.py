"""A friction law, an event, a column and a system of one's own: all that a package needs to add
them to tippetop.
"""

from typing import Any

import tippetop as tt
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.operand import formula
from tippetop.mechanics.systems.tippe_top import TIPPE_TOP
from tippetop.mechanics.units import JOULE, ONE, SECOND_PER_METRE


# --- a friction law: its numbers and its coefficient --------------------------------------------


class Quadratic(tt.extending.FrictionLaw):
    """F = -(mu + drag v_A^2) g_n v_A.

    Viscous friction that grows with speed.
    """

    mu: tt.extending.Number = tt.extending.number(
        SECOND_PER_METRE, "viscous friction coefficient mu", least=0
    )
    drag: tt.extending.Number = tt.extending.number(
        tt.extending.Unit("s3 m-3"), "coefficient of the square of the speed", least=0
    )

    @formula
    def coefficient(v2, z, law):
        """k = mu + drag v^2 [s/m]."""
        return law.mu + law.drag * v2


# --- an event and a column: functions of the scalars of a state ---------------------------------


@formula
def eighth(s, b):
    """z - cos(pi/4)."""
    return s.z - 0.7071067811865476


@formula
def spin_energy(s, b):
    """L_3^2/(2 I3), energy of the rotation about the axis [J]."""
    return s.L3**2 / (2 * b.I3)


EIGHTH = tt.extending.Event("eighth", "theta = pi/4", eighth)
SPIN_ENERGY = tt.extending.Quantity(
    "spin_energy", "E_3", JOULE, "energy of the rotation about the axis", spin_energy
)


# --- a system: a tippe top whose moments of inertia are given in m R^2 --------------------------


def body(parameters: Any, friction: Any) -> Touch:
    """The body: I1 = k1 m R^2 and I3 = k3 m R^2."""
    m, R, alpha, k1, k3, g = (parameters[name] for name in ("m", "R", "alpha", "k1", "k3", "g"))
    return Touch(m, R, alpha * R, k1 * m * R**2, k3 * m * R**2, g, friction)


def checks(parameters: Any) -> list[str]:
    """What the parameters break together."""
    k1, k3 = parameters["k1"], parameters["k3"]
    return (
        [f"`parameters.k3` must be at most 2*k1 = {2 * k1:.6g}, but is {k3:.6g}."]
        if k3 > 2 * k1
        else []
    )


SCALED_TIPPE_TOP = TIPPE_TOP.replace(
    name="scaled-tippe-top",
    title="tippe top with scaled moments of inertia",
    parameters={
        **{name: TIPPE_TOP.parameters[name] for name in ("m", "R", "alpha")},
        "k1": tt.extending.number(ONE, "transverse moment of inertia over m R^2", above=0),
        "k3": tt.extending.number(ONE, "axial moment of inertia over m R^2", above=0),
        "g": TIPPE_TOP.parameters["g"],
    },
    body=body,
    checks=checks,
    quantities=(*TIPPE_TOP.quantities, SPIN_ENERGY),
    events=(*TIPPE_TOP.events, EIGHTH),
)
