"""The shape of a body for pages and films: its surfaces, or the ellipsoid with its moments.

Symbols
    b         the body in SI units, a `contact.body.Touch` or `frame.Asymmetric`
    orientation   unit quaternions (w, x, y, z), (n, 4)

Root attributes or a body go in; out come surfaces, matrices and points in metres, for pages, films
and files for simulators. Quaternions turn body axes into space axes.
"""

from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.contact import body as contact
from ..mechanics.contact.body import Touch, Turning, arm, by_axis, touching_ball
from ..mechanics.contact.frame import Frame
from ..mechanics.contact.outline import Spheroid
from ..mechanics.contact.surroundings import dotted_numbers, surrounded_body
from ..mechanics.friction import Frictionless
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, axes
from ..mechanics.systems import by_name, find
from ..problem import column_names


# Longest half axis of the ellipsoid of a heavy top, as a part of the distance from the tip.
BIGGEST = 0.78
# Points of a meridian, at equal steps of its normal; their distance from the poles [rad]
POINTS = 62
NEAR_POLE = 1e-3
# By how much a drawn meridian is rounded, as a part of its size, and the cones at its ends rise
ROUNDED = 0.002
LEAST_TIP = 1e-6


def body_of(attrs: dict[str, Any]) -> Any:
    """Return the body of a store, SI; without a friction law where its contact changes its phase.

    It is a `Touch`, or a body with an `outline`. Raises InputError for one that cannot be drawn.
    """
    system = find(attrs["system"])
    if system is None:
        raise InputError(
            [f"the system `{attrs['system']}` must be known here to be drawn: register it first."]
        )
    friction = attrs.get("friction", {}) if "contact" not in attrs else {}
    law = system.laws.get(friction.get("law"), Frictionless)
    make = system.body_of
    if around := dotted_numbers(attrs):
        make = surrounded_body(make)
    numbers = attrs["parameters"] | around
    body = make(numbers, law._make(friction[name] for name in law._fields))
    if hasattr(body, "outline"):
        return body
    needed = [name for name in Touch._fields if name not in Touch._field_defaults]
    missing = [name for name in needed if not hasattr(body, name)]
    if missing:
        what = f"a body that is shown must have {', '.join(needed)}"
        raise InputError([f"{what}, but that of `{attrs['system']}` has no {missing[0]}."])
    return Touch(*(getattr(body, name) for name in needed))


def columns_of(attrs: dict[str, Any]) -> set[str]:
    """Return the names of the columns that a run of a known system can have."""
    system: Any = find(attrs["system"])
    of_contact = {"phase", "ball"} if "contact" in attrs else set()
    # with orientation, and without the integrated variables of quadruple runs, which are not drawn
    return {*column_names(system, system.forms[attrs["form"]], True, "double"), *of_contact}


class Surface(NamedTuple):
    """The surface of a body: an ellipsoid or, with a meridian, a surface of revolution.

    `centre` is seen from the centre of mass, in body axes; the half axes are turned against them by
    `turn` [rad] about axis 3. A meridian, (POINTS + 2, 3), has height and radius, in units of the
    half axes, and the inclination of its normal [rad], at POINTS equal steps of this, from above,
    and at a point of the axis before and after these.
    """

    centre: np.ndarray
    half: np.ndarray
    turn: float = 0.0
    meridian: Any = ()

    @property
    def axes(self) -> np.ndarray:
        """Return the axes of the surface in body axes, as the columns of a matrix."""
        k, s = np.cos(self.turn), np.sin(self.turn)
        return np.array([[k, -s, 0.0], [s, k, 0.0], [0.0, 0.0, 1.0]])


def surface_of(b: Any) -> Surface:
    """Return the surface of a body; a body that touches at its tip has half axes 0.

    Rows of a meridian are equal steps of the normal: `lowest` in `views/page/motion.js` finds a row
    by its number, without the points of the axis before and after.
    """
    outline = b.outline
    if not outline:
        return Surface(np.array([0.0, 0.0, b.c]), np.full(3, b.R))
    if isinstance(outline, Spheroid):
        half = np.array([outline.b, outline.b, outline.a])
        return Surface(np.array([0.0, 0.0, outline.c]), half)
    if hasattr(b, "I2"):
        half, centre = np.array([outline[:3], outline[5:8]])  # a, b, c and x, y, z of `Ellipsoid`
        return Surface(centre, half, float(np.arctan2(outline.sin, outline.cos)))
    normal = np.linspace(0, np.pi, POINTS)
    inner = np.clip(normal, NEAR_POLE, np.pi - NEAR_POLE)
    ball = touching_ball(-np.cos(inner), np.sin(inner) ** 2, b)
    points = ball.c + ball.R * np.exp(1j * inner)  # height + i radius
    points += ROUNDED * points.imag.max() * np.exp(1j * normal)
    middle = (points.real[0] + points.real[-1]) / 2
    along, across = points.real[0] - middle, points.imag.max()
    rows = np.array([(points.real - middle) / along, points.imag / across, normal]).T
    top, bottom = 1 + np.maximum(ROUNDED * rows[[0, -1], 1], LEAST_TIP)  # steeper than the rows
    meridian = np.vstack([[top, 0.0, 0.0], rows, [-bottom, 0.0, np.pi]])
    half = np.array([across, across, along])
    return Surface(np.array([0.0, 0.0, middle]), half, meridian=meridian)


def moments(b: Any) -> np.ndarray:
    """Return the principal moments of inertia about the centre of mass, (3,) [kg m^2]."""
    return np.array([b.I1, getattr(b, "I2", b.I1), b.I3], float)


def lies(attitude: np.ndarray, b: Any) -> Any:
    """Return how a body lies, its axis or its Frame, by unit quaternions (n, 4).

    Axes (n, 3) suffice for a body with an axis of symmetry.
    """
    if attitude.shape[1] == 3:
        return Vector(*attitude.T)
    first, _, third = axes(Quaternion(*attitude.T))
    return Frame(*third, *first)


def lowest(attitude: np.ndarray, b: Any) -> np.ndarray:
    """Return the lowest point from the centre of mass in space, (n, 3) [m]; see `lies`."""
    u = lies(attitude, b)
    return np.stack(arm(u, by_axis(u, b)), axis=1)


def angular_velocity(attitude: np.ndarray, L: np.ndarray, b: Any) -> np.ndarray:
    """Return omega in space, (n, 3) [rad/s], of L; see `lies`."""
    x = Turning(lies(attitude, b), Vector(*L.T))
    return np.stack(contact.angular_velocity(x, b), axis=1)


def shape(attrs: dict[str, Any]) -> dict[str, Any]:
    """Return the body as pages and films draw it, from root attributes; lengths in metres.

    The keys are also those of `Body` in `views/page/scene.js`.

    Returns
    -------
    dict
        kind (ball, lathe, heavy, cylinder), unit (the length that is 1 in the picture), axes (of
        the surfaces, in body axes), surfaces (centre and half axes along these axes, the stem last)
        and meridian as in `Surface`, ellipsoid (half axes) of a heavy top, weight [N], fixed,
        asymmetric.
    """
    b = body_of(attrs)
    system = by_name(attrs["system"])
    surface = surface_of(b)
    heavy = not surface.half.any()
    kind = "lathe" if len(surface.meridian) else "heavy" if heavy else "ball"
    centre = surface.centre @ surface.axes
    surfaces = [{"centre": centre.tolist(), "half": surface.half.tolist()}]
    stem = attrs.get("stem")
    if stem:
        above = [0.0, 0.0, centre[2] + stem["h"]]
        surfaces.append({"centre": above, "half": [stem["r"]] * 3})
    return {
        "kind": kind if system.vectors else "cylinder",
        "unit": float(np.max(surface.half) or -surface.centre[2]),
        "axes": surface.axes.T.tolist(),
        "surfaces": surfaces,
        "meridian": np.asarray(surface.meridian).tolist(),
        "ellipsoid": inertial_ellipsoid(b) if heavy else [],
        "weight": float(b.m * b.g),
        "fixed": heavy and "x" not in system.initial,
        "asymmetric": hasattr(b, "I2"),
    }


def inertial_ellipsoid(b: Touch) -> list[float]:
    """Return the half axes [m] of the uniform ellipsoid with the moments of inertia of a heavy top.

    The half axes are across the axis, twice, and along it. The ellipsoid is scaled down until it
    ends before the tip.
    Half axes a, a, c have I3 = 2 m a^2/5 and I1 = m (a^2 + c^2)/5; c is 0.14 a at least, so that a
    flat body can be seen.
    """
    across2 = 2.5 * b.I3 / b.m  # a^2; c^2 below, of which 0.02 a^2 is the least
    along = np.sqrt(max(5 * b.I1 / b.m - across2, 0.02 * across2))
    across = np.sqrt(across2)
    size = min(1.0, -b.c * BIGGEST / max(across, along))
    return [float(size * half) for half in (across, across, along)]


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (3, 3), body to space, of a unit quaternion wxyz (4,).

    Its columns are the axes of the body in space.
    """
    return np.array(axes(Quaternion(*quaternion))).T
