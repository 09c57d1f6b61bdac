"""The formulas of pages, as JavaScript: potentials, and a tippe top that slips, rolls and flies.

Systems and laws go in; modules of JavaScript come out as text.

Symbols
    y         (q, carried): the state of a flight and its integrals; b: the body; p: its parameters
    per       force and torque per normal force; v_A, omega: velocities of a contact

The page has one state in all phases, that of flight; what the plane does is added to its rates.
"""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..mechanics.contact.body import Touch, arm, axis_rate, kinematics, velocities
from ..mechanics.contact.contact_phases import (
    FLIGHT,
    disc_friction,
    moving,
    patch_speed2,
    smooth_friction,
)
from ..mechanics.contact.gliding import COS_INVERTED, axis, turning
from ..mechanics.contact.response import mobility_inverse_times, resting, sliding
from ..mechanics.contact.rows import row_of_angles
from ..mechanics.operand import Vector, atan2, cross, leaves, plus, refill, sqrt
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS
from ..mechanics.theory.thresholds import spins_by_height, thresholds
from ..mechanics.variables import Variables
from ..problem import Problem
from .javascript import arrow
from .samples import well_quantities


TOP = SYSTEMS["tippe-top"]
FORM = FLIGHT.forms["vector"]
VARIABLES = Variables(FORM)
OTHERS = {alternative.name for alternative in TOP.alternatives}
INITIAL = [*(name for name in TOP.initial if name not in OTHERS), "gap", "nu_z"]
WELL_QUANTITIES = [q for name in well_quantities(TOP) for q in TOP.quantities if q.name == name]

WELL = dict.fromkeys(("z", "first", "second"))
NO_POTENTIAL = {"formulas.js": "export const potential = null;\n"}
NO_PHASES = {"phases.js": "export const facts = {};\nexport const formulas = {};\n"}


def potential(system: System, b: Touch) -> dict[str, str]:
    """Return the module `formulas.js` of the page of a run: V of the system for this body."""
    potential = system.potential
    if potential is None:
        return NO_POTENTIAL
    numbers = refill(b, map(float, leaves(b)))
    well = arrow(WELL, lambda *z: [potential(*z[: 1 + len(system.momenta)], numbers)])
    return {"formulas.js": f"export const potential = {well};\n"}


def is_movable(problem: Problem) -> bool:
    """Return whether a page can integrate a problem: a sliding tippe top without surroundings, with
    restitution by energy.
    """
    law = type(problem.friction)
    contact = problem.contact
    return (
        problem.system.name == TOP.name
        and not problem.surroundings
        and law.with_parts is not None
        and (contact is None or contact.restitution == "energetic")
    )


def numbers_for_page(problem: Problem) -> dict[str, Any]:
    """Return what a page integrates: the numbers of top, law and start, and how long.

    simulation.js and contact.js read the names. A number of the start that is absent is 0 on the
    page. With `atRest` the page computes nu_x and nu_y such that the centre of mass rests.
    """
    data = dict(problem.initial)
    contact = problem.contact
    theta = data.get("theta", 0.0)
    angles = problem.system.start(data, math.sin(theta), math.cos(theta), problem.body())
    initial = {name: float(getattr(angles, name, data.get(name, 0.0))) for name in INITIAL}
    if data.get("centre_at_rest"):
        initial |= {"nu_x": 0.0, "nu_y": 0.0}
    return {
        "parameters": {**problem.parameters, **problem.friction._asdict()},
        "law": problem.law.key,
        "initial": {name: value for name, value in initial.items() if value},
        "atRest": bool(data.get("centre_at_rest")),
        "until": problem.until,
        "e_n": contact.e_n if contact else 0.0,
        "stem": problem.tables.get("stem"),
    }


def contacts(laws: Mapping[str, Any]) -> dict[str, str]:
    """Return the module `phases.js`, with the functions of each law by name; see `phases.d.ts`.

    `laws` are classes by the name under which the page chooses one.
    """
    facts = {
        "variables": list(VARIABLES.names),
        "moving": VARIABLES.moving,
        "parameters": list(TOP.parameters),
        "initial": INITIAL,
        "laws": {name: list(law.parameters) for name, law in laws.items()},
        "keys": {name: law.key for name, law in laws.items()},
        "exact": [name for name, law in laws.items() if law.set_valued],
        "bounded": {name: law.bounded_by for name, law in laws.items()},
        "near": math.acos(COS_INVERTED),
    }
    by_law = ",\n".join(f"{json.dumps(name)}: {_of_law(law)}" for name, law in laws.items())
    text = f"export const facts = {json.dumps(facts)};\nexport const formulas = {{{by_law}}};\n"
    return {"phases.js": text}


def _of_law(law: Any) -> str:
    """Return JavaScript: an object with the functions of one friction law (a class) by name.

    `phases.d.ts` describes each. Formulas run once, with symbols instead of numbers: the values of
    b and y here do not matter, only their shapes.
    """
    names = [*TOP.parameters, *law.parameters]
    b = TOP.body_of(dict.fromkeys(TOP.parameters, 1.0), law._make(1.0 for _ in law.parameters))
    y = (FORM.units, VARIABLES.carried(*VARIABLES.names[VARIABLES.moving :]))
    potential_of: Any = TOP.potential
    force = Vector(*"xyz")
    per = (Vector(*"xyz"), Vector(*"xyz"))
    frictions = [disc_friction(region.drag, law.torque) for region in law.regions.values()]

    def body(p: Sequence[Any]) -> Any:
        """Return the body b of a list of parameters p, in the order of `names`."""
        by_name = dict(zip(names, p, strict=True))
        return TOP.body_of(by_name, law._make(by_name[name] for name in law.parameters))

    def start(s: Any, z: Any, d: Sequence[Any], b: Any) -> list:
        """Return the numbers of the state y of a flight that begins with the initial numbers d.

        d has the order of `INITIAL`; s and z are sin(theta) and cos(theta). The integrals begin as
        in `Variables.start`, those without a `start` at 0.
        """
        data = dict(zip(INITIAL, d, strict=True))
        angles: Any = row_of_angles(TOP.start(data, s, z, b), s, z, b)
        lifted = angles._replace(
            height=angles.height + data["gap"], rz_dot=angles.rz_dot + data["nu_z"]
        )
        carried = [i.start(data, s, z) if i.start else 0 * z for i in VARIABLES.integrals]
        return [*FLIGHT.enter(moving(lifted), b), *carried]

    def rates(y: Any, b: Any) -> list:
        """Return the rates of all numbers of the state y of a flight, in their order.

        They are those of `Variables.rates`, without the scale of the integrals.
        """
        q, carried = y
        return [*FORM.rates(q, b), *(one.rate(q, carried, b) for one in VARIABLES.integrals)]

    def slip(y: Any, b: Any) -> tuple[Vector, Vector]:
        """Return v_A [m/s] and omega [rad/s] of a flight, (3,) each."""
        return velocities(FLIGHT.leave(y[0], b), b)

    def point(y: Any, b: Any) -> list:
        """Return four numbers: v_A, and U^2 [m^2/s^2] of the disc of contact, 0 without one."""
        v, omega = slip(y, b)
        return [*v, patch_speed2(omega, b) if law.regions else 0 * v.x]

    def friction(per_normal_force: Any) -> str:
        """Return JavaScript: a function (y, b) -> six numbers, force and torque per normal force.

        per_normal_force(omega, v_A, z, b) -> (force, torque), (3,) each: the law in one region.
        """

        def per_force(y: Any, b: Any) -> list:
            """Return the numbers of force and torque [m] per normal force."""
            v, omega = slip(y, b)
            force, torque = per_normal_force(omega, v, y[0].uz, b)
            return [*force, *torque]

        return arrow({"y": y, "b": b}, per_force)

    def normal(y: Any, per: Any, b: Any) -> list:
        """Return the normal force [N]; `per` are force and torque per normal force, (3,) each."""
        x = turning(y[0])
        force, _ = sliding(x, lambda *of: per, x.u, b)
        return [force.z]

    def turn(y: Any, per: Any, b: Any) -> list:
        """Return the torque about the centre of mass per normal force, (3,) [m]; `per` as above."""
        return [*plus(cross(arm(axis(y[0]), b), per[0]), per[1])]

    parts = {
        "body": arrow({"p": tuple(names)}, body),
        "start": arrow({"sine": None, "z": None, "d": tuple(INITIAL), "b": b}, start),
        "rates": arrow({"y": y, "b": b}, rates, fills=True),
        "point": arrow({"y": y, "b": b}, point),
        "frictions": f"[{', '.join(map(friction, frictions or [smooth_friction]))}]",
        "normal": arrow({"y": y, "per": per, "b": b}, normal),
        "turn": arrow({"y": y, "per": per, "b": b}, turn),
        "held": arrow({"y": y, "b": b}, lambda y, b: [*resting(turning(y[0]), b)[0]]),
        "pinned": arrow(
            {"y": y, "x": force, "b": b},
            lambda y, x, b: [*mobility_inverse_times(axis(y[0]), x, b)],
        ),
        "seen": arrow({"y": y, "force": force, "b": b}, channels, fills=True),
        "sizes": arrow({"b": b}, lambda b: [b.c, b.R, b.m * b.g]),
        "thresholds": _thresholds(b),
        "potential": arrow(WELL | {"b": b}, lambda *z: [potential_of(*z)]),
    }
    return "{\n" + ",\n".join(f"{name}: {text}" for name, text in parts.items()) + "\n}"


def channels(y: Any, force: Vector, b: Any) -> list:
    """Return axes 1 and 3 of a state y, then the channels of a sample from omega on.

    `force` is that of the plane [N]. motion.js reads the numbers by their places, which are those
    of `samples.samples`.
    """
    q, carried = y
    x = FLIGHT.leave(q, b)
    assert FORM.orientation is not None
    first, third = FORM.orientation.axes(q, carried, b)
    s, (slip, omega) = kinematics(x, axis_rate(x, b), b), velocities(x, b)
    well = [quantity.formula(s, b) for quantity in WELL_QUANTITIES]
    theta = atan2(sqrt(s.s2), s.z)
    place = carried.x, carried.y, x.height
    return [*first, *third, *omega, *place, *force, slip.x, slip.y, 0, *x.L, theta, *well]


def _thresholds(b: Touch) -> str:
    """Return JavaScript: a function (b) -> a list of records, the thresholds of a tippe top.

    Their names are those of the body `b`, with alpha > 0, as of every top of the playground.
    """
    known: dict[str, Any] = {}

    def values(symbols: Touch) -> list:
        """Return the values of the thresholds, and keep their names."""
        known.update(thresholds(symbols, spins_by_height(b)))
        return [t.value for t in known.values()]

    of_body = arrow({"b": b}, values)
    records = []
    for i, (name, t) in enumerate(known.items()):
        about = {"name": name, "unit": t.unit.symbol, "words": t.long_name}
        records.append(f"{{...{json.dumps(about)}, value: v[{i}]}}")
    return f"(b) => {{ const v = ({of_body})(b); return [{', '.join(records)}]; }}"
