"""The formulas of a system as JavaScript."""

import json
import math
from collections.abc import Sequence
from typing import Any

from ..engine.expressions import component, observed
from ..mechanics.contact.body import Touch, angular_velocity, kinematics, tip_inertia
from ..mechanics.contact.gliding.catalogue import COS_INVERTED
from ..mechanics.contact.gliding.vector import axis, sliding_velocity
from ..mechanics.contact.rolling.reaction import reaction
from ..mechanics.friction import FrictionLaw, slip_coefficient
from ..mechanics.operand import Vector, atan2, cross, leaves, refill, sqrt, times
from ..mechanics.system import Form, System
from ..mechanics.systems.heavy_top import momentum_about_centre, tip_axis_rate
from ..mechanics.theory.thresholds import poles, thresholds
from ..mechanics.units import Unit
from ..mechanics.variables import Variables
from ..runs.shape import sizes
from .javascript import arrow
from .samples import well_quantities


WELL = dict.fromkeys(("z", "first", "second"))
NO_POTENTIAL = "export const potential = null;\n"
NOTHING = f"export const facts = {{}};\nexport const formulas = {{}};\n{NO_POTENTIAL}"


def potential(system: System, b: Touch) -> str:
    """Return the module `formulas.js` of the page of a run: V of the system for this body."""
    if system.potential is None:
        return NO_POTENTIAL
    numbers = refill(b, map(float, leaves(b)))
    well = arrow(WELL, lambda *z: _potential(system, z, numbers))
    return f"export const potential = {well};\n"


def motions(system: System, form: Form, laws: dict[str, type[FrictionLaw]]) -> str:
    """Return the module `formulas.js` of a page that integrates a system in a form.

    It contains the functions of each friction law by name; see `formulas.d.ts`.
    """
    variables = Variables(form)
    facts = {
        "variables": list(variables.names),
        "moving": variables.moving,
        "parameters": list(system.parameters),
        "initial": initial_names(system),
        "laws": {name: list(law.parameters) for name, law in laws.items()},
        "planar": not system.vectors,
        "near": math.acos(COS_INVERTED),
    }
    by_law = ",\n".join(
        f"{json.dumps(name)}: {_of_law(system, variables, law)}" for name, law in laws.items()
    )
    return (
        f"export const facts = {json.dumps(facts)};\nexport const formulas = "
        f"{{{by_law}}};\n{NO_POTENTIAL}"
    )


def initial_names(system: System) -> list[str]:
    """Return the initial numbers that a page needs, without their alternatives."""
    others = {a.name for a in system.alternatives}
    return [name for name in system.initial if name not in others]


def _of_law(system: System, variables: Variables, law: type[FrictionLaw]) -> str:
    """Return the functions of one friction law, as an object."""
    form, names = variables.form, [*system.parameters, *law.parameters]
    b = system.body_of(
        dict.fromkeys(system.parameters, 1.0), law._make(1.0 for _ in law.parameters)
    )
    initial, heavy = initial_names(system), "R" not in system.parameters
    y = (form.units, variables.carried(*variables.names[variables.moving :]))

    def body(p: Sequence[Any]) -> Any:
        by_name = dict(zip(names, p, strict=True))
        return system.body_of(by_name, law._make(by_name[name] for name in law.parameters))

    def rates(y: tuple[Any, Any], b: Any) -> list:
        return [*form.rates(y[0], b), *(integral.rate(*y, b) for integral in variables.integrals)]

    def start(s: Any, z: Any, d: Sequence[Any], b: Any) -> list:
        data = dict(zip(initial, d, strict=True))
        q, carried = variables.start(data, system.start(data, s, z, b), s, z, b)
        return [*q, *carried]

    def weights(b: Any) -> list:
        mass, length = system.scales(b)
        return [_power(unit, mass, length, sqrt(length / b.g)) for unit in variables.units.values()]

    parts = {
        "body": arrow({"p": tuple(names)}, body),
        "rates": arrow({"y": y, "b": b}, rates, fills=True),
        "start": arrow({"sine": None, "z": None, "d": tuple(initial), "b": b}, start),
        "weights": arrow({"b": b}, weights),
        "seen": arrow(
            {"y": y, "b": b}, lambda y, b: channels(system, form, y[0], y[1], b), fills=True
        ),
        "sizes": arrow({"b": b}, lambda b: sizes(b, heavy=heavy)),
        "thresholds": _thresholds(system, b),
        "potential": arrow(WELL | {"b": b}, lambda *z: _potential(system, z[:3], z[3]))
        if system.potential
        else "null",
    }
    return "{\n" + ",\n".join(f"{name}: {text}" for name, text in parts.items()) + "\n}"


def _potential(system: System, z: Sequence[Any], b: Touch) -> list:
    assert system.potential is not None
    return [system.potential(*z[: 1 + len(system.momenta)], b)]


def channels(system: System, form: Form, q: Any, carried: Any, b: Touch) -> list:
    """Return axes 1 and 3 of a state, then the channels of a sample from omega on: motion.js."""
    values = observed(system, form, q, carried, b)
    assert form.orientation is not None
    first, third = form.orientation.axes(q, carried, b)
    rigid = "x" not in system.initial
    if system.vectors:
        u, L = (Vector(*(values[component(v)] for v in names)) for names in system.vectors.values())
        inert = b._replace(I1=tip_inertia(b)) if rigid else b  # L is about the tip then
        omega = angular_velocity(u, L, inert)
    else:
        omega, L = Vector(0, q.theta_dot, 0), Vector(0, b.I1 * q.theta_dot, 0)
    arm = Vector(b.c * third.x, b.c * third.y, b.c * third.z - b.R)
    place = times(-1, arm) if rigid else Vector(carried.x, getattr(carried, "y", 0), -arm.z)
    slip = _slip(q, b)
    s = form.scalars(q, b)
    theta = carried.theta if "theta" in type(carried)._fields else atan2(sqrt(s.s2), s.z)
    well = [values[name] for name in well_quantities(system)]
    momenta = [*well[:-1], *[0] * (3 - len(well)), *well[-1:]] if well else [0, 0, 0]
    force = _force(system, q, b, s, slip, values)
    return [*first, *third, *omega, *place, *force, *slip[:2], 0, *L, theta, *momenta]


def _slip(q: Any, b: Touch) -> Vector:
    """Return the velocity of the contact point."""
    if hasattr(q, "vx"):
        return Vector(q.vx, q.vy, 0)
    if hasattr(q, "rx_dot"):
        return sliding_velocity(q, b)
    return Vector(getattr(q, "nu_x", 0), 0, 0)


def _force(
    system: System, q: Any, b: Touch, s: Any, slip: Vector, values: dict[str, Any]
) -> Vector:
    """Return the force of the plane: by the friction law in sliding, else the reaction."""
    normal = values.get("normal_force", 0)
    if system.frictional:
        k = slip_coefficient(s.v2, s.z, b.friction)
        return Vector(-(k * normal * slip.x), -(k * normal * slip.y), normal)
    if not system.vectors:
        return Vector(0, 0, normal)
    rigid = "x" not in system.initial
    u = axis(q)
    L = (
        momentum_about_centre(q, b)
        if rigid
        else Vector(*(values[component(v)] for v in system.vectors["L"]))
    )
    u_dot = tip_axis_rate(q, b) if rigid else times(1 / b.I1, cross(L, u))
    return reaction(u, L, u_dot, kinematics(u, L, u_dot, b), b)


def _power(unit: Unit, mass: Any, length: Any, time: Any) -> Any:
    """Return one internal unit in SI units."""
    value = 1 + 0 * mass
    for base, power in zip((mass, length, time), unit.powers, strict=True):
        value = value * base**power if power > 0 else value / base**-power if power < 0 else value
    return value


def _thresholds(system: System, b: Touch) -> str:
    """Return the thresholds of a tippe top, as a list of records; an empty one for others."""
    if not system.inverts:
        return "() => []"
    known: dict[str, Any] = {}

    def values(symbols: Touch) -> list:
        known.update(thresholds(symbols, poles(b)))
        return [t.value for t in known.values()]

    of_body = arrow({"b": b}, values)
    records = []
    for i, (name, t) in enumerate(known.items()):
        about = {"name": name, "unit": t.unit.symbol, "words": t.long_name}
        records.append(f"{{...{json.dumps(about)}, value: v[{i}]}}")
    return f"(b) => {{ const v = ({of_body})(b); return [{', '.join(records)}]; }}"
