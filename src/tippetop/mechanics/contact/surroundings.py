"""Surroundings of a body: air that brakes its rotation, and a plane that is tilted.

Space axes are those of the plane: z is its normal. A body has the gravity across the plane as `g`,
and the rest in its record of surroundings.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

from ...errors import InputError
from ..number import Number
from ..operand import Operand, Vector, cos, dot, sin, sqrt, times
from ..units import ANGULAR_MOMENTUM, INERTIA, METRE_PER_SECOND2, RADIAN


STEEPEST = 1.5
"""Inclination of the plane [rad] that must not be reached: beyond it hardly anything presses."""

SURROUNDINGS: Mapping[str, Mapping[str, Number]] = {
    "air": {
        "c1": Number(
            ANGULAR_MOMENTUM,
            "torque of the air per angular velocity",
            least=0,
            default=0.0,
            symbol="c_1",
        ),
        "c2": Number(
            INERTIA,
            "torque of the air per square of the angular velocity",
            least=0,
            default=0.0,
            symbol="c_2",
        ),
    },
    "plane": {
        "tilt": Number(
            RADIAN,
            "inclination of the plane, which falls towards its azimuth",
            above=-STEEPEST,
            below=STEEPEST,
            default=0.0,
        ),
        "azimuth": Number(
            RADIAN, "direction along the plane in which it falls, from x towards y", default=0.0
        ),
    },
}
"""The numbers of surroundings, by table and name."""

SMOOTH = 1e-7
"""Angular velocity, internal units, below which the torque of c2 is smooth: at one unit this
changes it by 5e-15 of itself."""


class Air(NamedTuple):
    """The torque of the air about the centre of mass is -(c1 + c2 |omega|) omega."""

    c1: Operand
    c2: Operand


class Slope(NamedTuple):
    """Gravity along the plane [m/s^2]."""

    x: Operand
    y: Operand


class Surroundings(NamedTuple):
    """What acts besides gravity across the plane and the contact; (): nothing."""

    air: Any = ()
    slope: Any = ()


def rules_of(tables: tuple[str, ...]) -> dict[str, Number]:
    """Return the numbers of tables of surroundings, by dotted key."""
    return {f"{t}.{name}": rule for t in tables for name, rule in SURROUNDINGS[t].items()}


def tables_of(keys: Iterable[str]) -> tuple[str, ...]:
    """Return the tables of numbers of surroundings by dotted key."""
    return tuple(dict.fromkeys(key.partition(".")[0] for key in keys))


def dotted_numbers(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the numbers of surroundings among tables, by dotted key."""
    return {
        f"{table}.{name}": value
        for table in SURROUNDINGS
        for name, value in tables.get(table, {}).items()
    }


def require_still(tables: Collection[str], what: str) -> None:
    """Raise InputError for what holds on a level plane in still air only, if there are tables of
    surroundings.
    """
    if given := [f"[{name}]" for name in SURROUNDINGS if name in tables]:
        raise InputError(
            f"{what} must be on a level plane in still air, but has {' and '.join(given)}."
        )


def surrounded_body(body: Callable) -> Callable:
    """Return body(parameters, friction) of a body in the surroundings that the parameters have.

    These are numbers by dotted key.
    """

    def surrounded(parameters: Mapping[str, Any], friction: Any) -> Any:
        b = body(parameters, friction)
        g = b.g
        air: Any = ()
        slope: Any = ()
        if "air.c1" in parameters:
            air = Air(parameters["air.c1"], parameters["air.c2"])
        if "plane.tilt" in parameters:
            tilt = parameters["plane.tilt"]
            azimuth = parameters["plane.azimuth"]
            along = g * sin(tilt)
            slope = Slope(along * cos(azimuth), along * sin(azimuth))
            g = g * cos(tilt)
        return b._replace(g=g, around=Surroundings(air, slope))

    return surrounded


def surrounded_units(body_units: Callable, tables: tuple[str, ...]) -> Callable:
    """Return body_units(law) of a body in surroundings of these tables."""
    air = Air(ANGULAR_MOMENTUM, INERTIA) if "air" in tables else ()
    slope = Slope(METRE_PER_SECOND2, METRE_PER_SECOND2) if "plane" in tables else ()
    around = Surroundings(air, slope)
    return lambda law: body_units(law)._replace(around=around)


def braking(omega: Vector, b: Any) -> Vector:
    """Return the torque of the air on a body, (3,) [N m]."""
    if not (b.around and b.around.air):
        return times(0, omega)
    c1, c2 = b.around.air
    return times(-(c1 + c2 * sqrt(dot(omega, omega) + SMOOTH**2)), omega)


def downhill(none: Any, b: Any) -> Vector:
    """Return gravity along the plane, (3,) [m/s^2]; `none` is a zero of the type of its numbers."""
    x, y = (b.around and b.around.slope) or (none, none)
    return Vector(x + none, y + none, none)


def taken(omega: Vector, velocity: Vector, b: Any) -> Any:
    """Return the power that the air and gravity along the plane take from a body [W]."""
    along = downhill(0 * omega.z, b)
    return -dot(braking(omega, b), omega) - b.m * dot(along, velocity)
