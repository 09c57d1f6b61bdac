"""The formulas of a system as JavaScript, written down by the symbols that they are fed."""

import json
import math
from collections.abc import Callable, Sequence
from typing import Any

from ..engine.expressions import component, observed
from ..mechanics.contact.body import Touch, angular_velocity, tip_inertia
from ..mechanics.contact.gliding.catalogue import COS_INVERTED
from ..mechanics.contact.gliding.vector import axis, sliding_velocity
from ..mechanics.contact.rolling.reaction import kinematics, reaction
from ..mechanics.friction import FrictionLaw, slip_coefficient
from ..mechanics.operand import Vector, atan2, cross, leaves, refill, sqrt, times
from ..mechanics.system import Form, System
from ..mechanics.systems.heavy_top import momentum_about_centre, tip_axis_rate
from ..mechanics.theory.thresholds import poles, thresholds
from ..mechanics.units import Unit
from ..mechanics.variables import Variables
from ..mechanics.writing import JAVASCRIPT, function
from ..runs.shape import sizes
from .samples import well_quantities


NO_POTENTIAL = "export const potential = null;\n"
NOTHING = f"export const facts = {{}};\nexport const formulas = {{}};\n{NO_POTENTIAL}"


def potential(system: System, b: Touch) -> str:
    """The module `formulas.js` of the page of a run: V of the system at the momenta that it takes,
    for this body.
    """
    if system.potential is None:
        return NO_POTENTIAL
    numbers = refill(b, map(float, leaves(b)))
    names = ("z", "first", "second")
    return (
        "export const potential = "
        f"{_function(names, names, lambda symbols: _potential(system, symbols, numbers))};\n"
    )


def motions(system: System, form: Form, laws: dict[str, type[FrictionLaw]]) -> str:
    """The module `formulas.js` of a page that integrates: all that it needs of a system in a form,
    for each friction law by name; as `formulas.d.ts` says.
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
    """The initial numbers that a page asks for: of those that say the same in two ways, one."""
    others = {a.name for a in system.alternatives}
    return [name for name in system.initial if name not in others]


def _of_law(system: System, variables: Variables, law: type[FrictionLaw]) -> str:
    """The functions of one friction law, as an object."""
    form, names = variables.form, [*system.parameters, *law.parameters]
    template = system.body_of(
        dict.fromkeys(system.parameters, 1.0), law._make(1.0 for _ in law.parameters)
    )
    given, n = initial_names(system), len(variables.names)
    heavy = "R" not in system.parameters
    numbers = [f"b[{i}]" for i in range(len(leaves(template)))]
    state = [*(f"y[{i}]" for i in range(n)), *numbers]
    well = ("z", "first", "second")

    def fill(symbols: Sequence[Any]) -> Any:
        return refill(template, iter(symbols))

    def body(symbols: Sequence[Any]) -> list:
        by_name = dict(zip(names, symbols, strict=True))
        return leaves(system.body_of(by_name, law._make(by_name[name] for name in law.parameters)))

    def of(symbols: Sequence[Any]) -> tuple[Any, Any, Any]:
        q, carried = symbols[: variables.moving], symbols[variables.moving : n]
        return type(form.units)(*q), variables.carried(*carried), fill(symbols[n:])

    def rates(symbols: Sequence[Any]) -> list:
        q, carried, b = of(symbols)
        return [
            *form.rates(q, b),
            *(integral.rate(q, carried, b) for integral in variables.integrals),
        ]

    def start(symbols: Sequence[Any]) -> list:
        s, z, *rest = symbols
        data, b = dict(zip(given, rest, strict=False)), fill(rest[len(given) :])
        q, carried = variables.start(data, system.start(data, s, z, b), s, z, b)
        return [*q, *carried]

    def weights(symbols: Sequence[Any]) -> list:
        b = fill(symbols)
        mass, length = system.scales(b)
        return [_power(unit, mass, length, sqrt(length / b.g)) for unit in variables.units.values()]

    data = [f"d[{i}]" for i in range(len(given))]
    parts = {
        "body": _function(("p",), [f"p[{i}]" for i in range(len(names))], body),
        "rates": _function(("y", "b", "out"), state, rates, fills=True),
        "start": _function(("sine", "z", "d", "b"), ["sine", "z", *data, *numbers], start),
        "weights": _function(("b",), numbers, weights),
        "seen": _function(
            ("y", "b", "out"), state, lambda symbols: seen(system, form, *of(symbols)), fills=True
        ),
        "sizes": _function(("b",), numbers, lambda symbols: sizes(fill(symbols), heavy=heavy)),
        "thresholds": _thresholds(system, template, numbers),
        "potential": _function(
            (*well, "b"),
            [*well, *numbers],
            lambda symbols: _potential(system, symbols, fill(symbols[3:])),
        )
        if system.potential
        else "null",
    }
    return "{\n" + ",\n".join(f"{name}: {text}" for name, text in parts.items()) + "\n}"


def _potential(system: System, symbols: Sequence[Any], b: Touch) -> list:
    assert system.potential is not None
    return [system.potential(*symbols[: 1 + len(system.momenta)], b)]


def seen(system: System, form: Form, q: Any, carried: Any, b: Touch) -> list:
    """What the page draws of a state: axes 1 and 3, then the channels of a sample from omega on.

    [see motion.js]
    """
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
    """The velocity of the contact point."""
    if hasattr(q, "vx"):
        return Vector(q.vx, q.vy, 0)
    if hasattr(q, "rx_dot"):
        return sliding_velocity(q, b)
    return Vector(getattr(q, "nu_x", 0), 0, 0)


def _force(
    system: System, q: Any, b: Touch, s: Any, slip: Vector, values: dict[str, Any]
) -> Vector:
    """The force of the plane: by the friction law where the contact slides, else the reaction of a
    contact at rest.
    """
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
    """One internal unit in SI units."""
    value = 1 + 0 * mass
    for base, power in ((mass, unit.mass), (length, unit.length), (time, unit.time)):
        value = value * base**power if power > 0 else value / base**-power if power < 0 else value
    return value


def _thresholds(system: System, template: Touch, numbers: list[str]) -> str:
    """The thresholds of a tippe top, as a list of records; an empty one for others."""
    if not system.inverts:
        return "() => []"

    records = []

    def values(symbols: list) -> list:
        known = thresholds(refill(template, iter(symbols)), poles(template))
        for i, (name, t) in enumerate(known.items()):
            about = {"name": name, "unit": t.unit.symbol, "words": t.long_name}
            records.append(f"{{...{json.dumps(about)}, value: v[{i}]}}")
        return [t.value for t in known.values()]

    of_body = _function(("b",), numbers, values)
    return f"(b) => {{ const v = ({of_body})(b); return [{', '.join(records)}]; }}"


def _function(
    names: Sequence[str],
    inputs: Sequence[str],
    formula: Callable[[list], Sequence[Any]],
    *,
    fills: bool = False,
) -> str:
    """A function that returns its one result or a list of them, or puts them into its last
    argument.
    """
    lines, results = function(JAVASCRIPT, inputs, formula)
    if fills:
        lines += [f"{names[-1]}[{i}] = {result};" for i, result in enumerate(results)]
    else:
        value = ", ".join(results)
        lines.append(f"return {value if len(results) == 1 else f'[{value}]'};")
    return f"({', '.join(names)}) => {{\n{chr(10).join(lines)}\n}}"
