"""Surroundings of a body: air that brakes its rotation; a plane that is tilted, vibrates or turns.

Numbers of the tables [air] and [plane] go in; out come the record b.around of a body, and from it
the torque, acceleration and gravity by which `response` changes forces and equations. Everything is
seen from the plane: z is its normal, and x and y turn with it. A body has the gravity across the
plane as `g`, and the rest in its record of surroundings.

Symbols
    b         the body; b.g: gravity across the plane; b.around: a `Surroundings`
    groups    names in GROUPS: the sets of numbers that are given together
    omega, L  angular velocity and momentum, (3,), seen from the plane; Omega: that of a turntable
    carried   the record of integrals of the run, with the phase of the vibration and the place x, y
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from ...errors import InputError
from ..number import Number
from ..operand import Operand, Vector, atan2, cos, cross, dot, minus, plus, sin, sqrt, times
from ..units import (
    ANGULAR_MOMENTUM,
    INERTIA,
    METRE,
    PER_SECOND,
    RADIAN,
    RADIAN_PER_SECOND,
)


STEEPEST = 1.5
"""Inclination of the plane [rad] that must not be reached: beyond it hardly anything presses."""

GROUPS: Mapping[str, Mapping[str, Number]] = {
    "air": {
        "air.c1": Number(
            ANGULAR_MOMENTUM,
            "torque of the air per angular velocity",
            least=0,
            default=0.0,
            symbol="c_1",
        ),
        "air.c2": Number(
            INERTIA,
            "torque of the air per square of the angular velocity",
            least=0,
            default=0.0,
            symbol="c_2",
        ),
    },
    "tilt": {
        "plane.tilt": Number(
            RADIAN,
            "inclination of the plane, which falls towards its azimuth",
            above=-STEEPEST,
            below=STEEPEST,
            default=0.0,
        ),
        "plane.azimuth": Number(
            RADIAN, "direction along the plane in which it falls, from x towards y", default=0.0
        ),
    },
    "vibration": {
        "plane.amplitude": Number(
            METRE, "amplitude a of a plane that vibrates across itself", least=0
        ),
        "plane.frequency": Number(PER_SECOND, "its frequency f", above=0),
        "plane.phase": Number(
            RADIAN,
            "its phase: the plane has the height -a cos(2 pi f t + phase)",
            default=0.0,
        ),
    },
    "turntable": {
        "plane.omega": Number(
            RADIAN_PER_SECOND, "angular velocity of a plane that turns about its normal"
        ),
        "plane.x": Number(METRE, "x of its axis of turning", default=0.0),
        "plane.y": Number(METRE, "y of its axis of turning", default=0.0),
    },
}
"""The numbers of surroundings by dotted key, in groups that are given together.

`surrounded_body` gives the numbers of a group by position, `Air` and `Table` in the order of their
fields.
"""

TABLES = ("air", "plane")

SMOOTH = 1e-7
"""Angular velocity, internal units, below which the torque of c2 is smooth: at one unit this
changes it by 5e-15 of itself."""


class Air(NamedTuple):
    """The torque of the air about the centre of mass is -(c1 + c2 |omega|) omega."""

    c1: Operand  # [N m s]
    c2: Operand  # [N m s^2]


class Slope(NamedTuple):
    """Gravity along the plane [m/s^2]."""

    x: Operand
    y: Operand


class Shake(NamedTuple):
    """Gravity across a plane that vibrates: g + c cos(rate t) + s sin(rate t).

    `at_present` computes it, with the integrals `present_body.VIBRATION_PHASE`.
    """

    g: Operand  # across the plane at rest [m/s^2]
    c: Operand  # [m/s^2]
    s: Operand  # [m/s^2]
    rate: Operand  # 2 pi f [rad/s]


class Table(NamedTuple):
    """A plane that turns about x, y; `at` is the place of the body from there, once it is known."""

    omega: Operand  # about the normal of the plane [rad/s]
    x: Operand  # [m]
    y: Operand  # [m]
    at: Any = ()  # (3,) [m], third component 0; `at_present` fills it in


class Surroundings(NamedTuple):
    """All that acts on a body in addition to gravity across the plane and the contact.

    A field is () if there is no such thing.
    """

    air: Any = ()  # an `Air`
    slope: Any = ()  # a `Slope`
    shake: Any = ()  # a `Shake`
    table: Any = ()  # a `Table`


def groups_in(tables: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the groups of surroundings of a scenario: an empty table is air, or a level plane."""
    given = {name: tables[name] for name in TABLES if isinstance(tables.get(name), Mapping)}
    groups = {*groups_of(dotted_numbers(given))}
    groups |= {"air"} & {*tables}
    if "plane" in tables and groups <= {"air"}:
        groups.add("tilt")
    return tuple(name for name in GROUPS if name in groups)


def groups_of(keys: Iterable[str]) -> tuple[str, ...]:
    """Return the names of the groups to which numbers with these dotted keys belong."""
    return tuple(name for name, rules in GROUPS.items() if not rules.keys().isdisjoint(keys))


def rules_of(groups: Iterable[str]) -> dict[str, Number]:
    """Return the numbers of groups of surroundings, by dotted key."""
    return {key: rule for name in groups for key, rule in GROUPS[name].items()}


def by_table(numbers: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return numbers by table and name, of numbers by dotted key."""
    tables: dict[str, dict[str, Any]] = {}
    for key, number in numbers.items():
        table, _, name = key.partition(".")
        tables.setdefault(table, {})[name] = number
    return tables


RULES = by_table(rules_of(GROUPS))
"""All numbers of surroundings, by table and name."""


def dotted_numbers(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the numbers of surroundings among tables, by dotted key."""
    return {f"{t}.{name}": v for t in TABLES for name, v in tables.get(t, {}).items()}


def require_still(tables: Mapping[str, Any], what: str, *, tilted: bool = False) -> None:
    """Raise InputError for what holds on a level plane at rest in still air only, if there are
    other surroundings; the plane may be `tilted`.
    """
    moves = [next(iter(GROUPS[name])) for name in groups_in(tables) if name != "tilt" or not tilted]
    if moves:
        raise InputError(
            f"{what} must be on a {'' if tilted else 'level '}plane at rest in still air, but has "
            f"{' and '.join(map('`{}`'.format, moves))}, which must be removed."
        )


def moving_axes(tables: Mapping[str, Any]) -> list[str]:
    """Return [] or a note on a picture in the axes of a plane that is not level, or moves.

    `tables` are those of a scenario, SI.
    """
    given = [
        f"{name} = {value:.4g} {RULES['plane'][name].unit.symbol}"
        for name, value in tables.get("plane", {}).items()
    ]
    return [f"The picture is in the axes of the plane: {', '.join(given)}."] * bool(given)


# --- the record of a body -----------------------------------------------------------------------


def surrounded_body(body: Callable) -> Callable:
    """Return body(parameters, friction) of a body in the surroundings that the parameters have.

    `parameters` also has the numbers of surroundings, by dotted key: a group counts if it is
    complete. They may be arrays, or units, by which `in_surroundings` finds the units of the body.
    """

    def surrounded(parameters: Mapping[str, Any], friction: Any) -> Any:
        """Return the body in its surroundings: air, slope, vibration and turntable as `around`.

        Each is () if the parameters do not have it; g becomes the part along the plane's normal.
        """
        b = body(parameters, friction)
        given = {
            name: [parameters[key] for key in rules]
            for name, rules in GROUPS.items()
            if rules.keys() <= parameters.keys()
        }
        g = b.g
        around: dict[str, Any] = {}
        if "air" in given:
            around["air"] = Air(*given["air"])
        if "tilt" in given:
            tilt, azimuth = given["tilt"]
            along = g * sin(tilt)
            around["slope"] = Slope(along * cos(azimuth), along * sin(azimuth))
            g = g * cos(tilt)
        if "vibration" in given:  # after "tilt", as `Shake` takes the g across the plane
            amplitude, frequency, phase = given["vibration"]
            # 2 pi f, pi = atan2(0, -1) in the precision of the numbers
            rate = 2 * atan2(0 * frequency, 0 * frequency - 1) * frequency
            push = amplitude * rate**2  # of the plane's acceleration push cos(rate t + phase)
            around["shake"] = Shake(g, push * cos(phase), -(push * sin(phase)), rate)
        if "turntable" in given:
            around["table"] = Table(*given["turntable"])
        return b._replace(g=g, around=Surroundings(**around))

    return surrounded


COPY = "at_"
"""Begins the names of variables of a state that are copies of integrals."""


def at_present(b: Any, known: Any) -> Any:
    """Return the body at one time: g of a vibrating plane, and its place on a turntable, filled in.

    `known` is a record of integrals at that time, or a state with copies of them.
    """
    around = b.around
    if not around or not (around.shake or around.table):
        return b
    now = {name.removeprefix(COPY): value for name, value in known._asdict().items()}
    if around.shake:
        g, c, s, _ = around.shake
        b = b._replace(g=g + c * now["clock_cos"] + s * now["clock_sin"])
    if around.table:
        table = around.table
        at = Vector(now["x"] - table.x, now["y"] - table.y, 0 * now["x"])
        b = b._replace(around=around._replace(table=table._replace(at=at)))
    return b


def joined_values(units: Any, carried: Any) -> list:
    """Return the values of the variables of a state with these units that are copies of integrals.

    `carried` is the record of the integrals. The copies end the state, in the order of the result.
    """
    names = [name for name in units._fields if name.startswith(COPY)]
    return [getattr(carried, name.removeprefix(COPY)) for name in names]


def mean_gravity(b: Any) -> Any:
    """Return gravity across the plane, without the acceleration of the plane [m/s^2]."""
    return b.around.shake.g if b.around and b.around.shake else b.g


# --- torque, acceleration and power -------------------------------------------------------------


def braking(omega: Vector, b: Any) -> Vector:
    """Return the torque of the air, which is at rest, on a body, (3,) [N m].

    `b.around` must be given; omega is seen from the plane, which may turn.
    """
    if not b.around.air:
        return times(0, omega)
    c1, c2 = b.around.air
    if b.around.table:
        omega = omega._replace(z=omega.z + b.around.table.omega)
    return times(-(c1 + c2 * sqrt(dot(omega, omega) + SMOOTH**2)), omega)


def table_torque(omega: Vector, L: Vector, momentum: Callable, b: Any) -> Vector:
    """Return the torque on a body that is seen from a table that turns with Omega, (3,) [N m].

    omega and L are those seen from there, and momentum(omega) = I omega: the torque is
    I(omega x Omega) - omega x I Omega - Omega x (L + I Omega). `b.around` must have a table.
    """
    turn = Vector(0 * omega.z, 0 * omega.z, b.around.table.omega + 0 * omega.z)
    own = momentum(turn)
    of_table = plus(cross(omega, own), cross(turn, plus(L, own)))
    return minus(momentum(cross(omega, turn)), of_table)


def pushing(velocity: Any, none: Any, b: Any) -> Vector:
    """Return the acceleration of the centre of mass along the plane, (3,) [m/s^2].

    It is that by gravity and, seen from a turntable, by its turning. `velocity`, of the centre of
    mass, seen from the plane, is needed on a turntable only: there `at_present` must have filled in
    `b.around.table.at`. `none` is a zero of the type of the numbers.
    """
    if not b.around:
        return Vector(none, none, none)
    x, y = b.around.slope or (none, none)
    if b.around.table:
        turn = b.around.table.omega
        at = b.around.table.at
        x = x + turn * (turn * at.x + 2 * velocity.y)
        y = y + turn * (turn * at.y - 2 * velocity.x)
    return Vector(x + none, y + none, none)
