"""Scenarios whose contact changes its phase: those of the reference, and one that bounces."""

from collections import namedtuple
from fractions import Fraction
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from examples import ANGLES, stored_reference
from examples import CANONICAL as BODY

from tippetop.engine.impacts import ImpactMotions
from tippetop.mechanics.contact.body import Moving, Turning, centre_velocity, velocities
from tippetop.mechanics.contact.response import kicked
from tippetop.mechanics.operand import Vector


ROLLS_THEN_SLIDES = {
    "theta": 0.9923530071805531,
    "phi_dot": -8.355486315805702,
    "omega3": 88.18683753238034,
    "theta_dot": -17.927807956520134,
}
ROLLS_THEN_SLIDES_MU = 0.5935203956711167
"""A start, and mu of Coulomb friction under which it rolls until 0.036 s."""

LEINE_GLOCKER = {"m": 0.006, "R": 0.015, "alpha": 0.2, "I1": 8e-7, "I3": 7e-7, "g": 9.81}
STEM = {"r": 0.005, "h": 0.013}
DRILLING = {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 1e-5}
TOSSED = dict(theta=0.5, theta_dot=60.0, phi_dot=5.0, omega3=30.0, nu_x=0.1, nu_y=-0.2)

BOUNCE: dict[str, Any] = {
    "system": "tippe-top",
    "parameters": BODY,
    "friction": {"law": "coulomb", "mu": 0.3},
    "contact": {"e_n": 0.5},
    "initial": {"theta": 0.5, "omega3": 60.0, "gap": 0.01},
    "run": {"until": 0.4},
}
"""A top that falls, bounces, slips and rolls."""

STANDING: dict[str, Any] = {
    "system": "tippe-top",
    "parameters": LEINE_GLOCKER,
    "friction": {"law": "viscous", "mu": 2.0},
    "stem": STEM,
    "contact": {"e_n": 0.02},
    "initial": {"theta": 2.447, "phi_dot": -20.0, "omega3": 60.0},
    "run": {"until": 0.05},
}
"""A top that strikes the plane with its stem, hops from one ball to the other, and stands on both.
"""


ROCKING: dict[str, Any] = {
    "system": "tippe-top",
    "parameters": LEINE_GLOCKER,
    "friction": {"law": "contensou", "mu": 0.06, "patch": 2e-3},
    "initial": {"theta": 0.5, "omega3": 0.3, "theta_dot": 1.0},
    "run": {"until": 0.5},
}
"""A top on a large disc, which rests, gives way, and rests again."""


def reference(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The tables of a case of the reference, with rows at its times, and the case."""
    case = stored_reference(name)
    system = "gliding-cylinder" if "theta_unwrapped" in case else "tippe-top"
    exact = {
        key: float(Fraction(value))
        for key, value in case["parameters_exact"].items()
        if key != "restitution"
    }
    body = {"m", "R", "alpha", "g"}
    inertia = (
        {"I": exact["I1"]}
        if system == "gliding-cylinder"
        else {"I1": exact["I1"], "I3": exact["I3"]}
    )
    initial = {
        ANGLES.get(key, key): value if isinstance(value, bool) else float(Fraction(value))
        for key, value in case["initial_exact"].items()
    }
    times = [float(t) for t in case["t"]]
    tables = {
        "system": system,
        "parameters": {key: exact[key] for key in body} | inertia,
        "friction": {"law": "coulomb", "mu": exact["mu"]},
        "contact": {"e_n": exact["e_n"], "restitution": case["parameters_exact"]["restitution"]},
        "initial": initial,
        "run": {"until": times[-1], "output_times": times},
    }
    return tables, case


TURNING = reference("caseC6_cylinder_coulomb")[0]
"""A cylinder that slides back and forth, rolls, and slides again."""

THROWN = reference("caseC3_liftoff_flight_plastic_landing")[0]
"""A top that slides, flies, lands, slides and rolls."""


def table_of(solution: Any, name: str) -> dict[str, np.ndarray]:
    """A table of a run, which came in parts, slice by slice."""
    parts = solution.others[name]
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}


def mobility(s: Any, z: Any, b: Any) -> SimpleNamespace:
    """What impulses along e, 2hat, zhat add to the velocity of the contact."""
    H, lever = b.R - b.c * z, b.c * s
    return SimpleNamespace(
        ee=1 / b.m + H**2 / b.I1,
        zz=1 / b.m + lever**2 / b.I1,
        ez=lever * H / b.I1,
        tt=1 / b.m + (b.c - b.R * z) ** 2 / b.I1 + (b.R * s) ** 2 / b.I3,
    )


CARRIED = namedtuple("Carried", "work impulse jellett_lost")(0.0, 0.0, 0.0)
"""Integrals that impacts change."""


def inertia(u: np.ndarray, b: Any) -> np.ndarray:
    """The tensor of inertia of a body, space frame."""
    return b.I1 * np.eye(3) + (b.I3 - b.I1) * np.outer(u, u)


def gained(v: Any, made: Any, Omega_z: Any = 0) -> Any:
    """The energy p.(v- + v+)/2 that the impulses of an impact give, those of torques included."""
    after = made.v_e, made.v_2, made.v_n
    pushed = (p * (a + b) for p, a, b in zip(made.p, v, after, strict=True))
    return sum(pushed, made.twist.z * (Omega_z + made.Omega_z)) / 2


impact_motions = cache(ImpactMotions)


def struck(
    v: Any,
    s: Any,
    z: Any,
    b: Any,
    e_n: Any = 0.0,
    restitution: str = "energetic",
    Omega_z: Any = 0.0,
    precision: str = "double",
) -> SimpleNamespace:
    """The impact of a body that arrives with v = (v_e, v_2, v_n) and turns about the vertical, and
    whose axis lies in the x-z plane."""
    if precision == "double":
        s, z, *v = map(float, (s, z, *v))
    none = 0 * s
    along = (b.I3 - b.I1) * (Omega_z * z)
    u, L = Vector(s, none, z), Vector(along * s, none, along * z + b.I1 * Omega_z)
    velocity = centre_velocity(Turning(u, L), Vector(*v), b)
    x = Moving(u, L, velocity, none, CARRIED)
    made = impact_motions(type(b.friction), restitution, precision).struck(x, b, e_n)
    after = kicked(x, b, made.p, made.twist)
    velocity, omega = velocities(after, b)
    names = ("v_e", "v_2", "v_n", "p_e", "p_2", "p_z")
    return SimpleNamespace(
        **made._asdict(),
        **dict(zip(names, (*velocity, *made.p), strict=True)),
        energy=made.gained,
        work_t=made.gained - made.work_n,
        after=after,
        Omega_z=omega.z,
        makes_energy=made.makes_energy,
    )
