"""The shape of a body: its balls, its stem, or the ellipsoid with its moments of inertia."""

from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanics.contact.body import Touch
from ..mechanics.contact.outline import Ball
from ..mechanics.friction import Frictionless
from ..mechanics.rotation import Quaternion, axes
from ..mechanics.systems import by_name, find
from ..problem import column_names


# Longest half axis of the ellipsoid of a heavy top, as a part of the distance from the tip.
BIGGEST = 0.78


def body_of(attrs: dict[str, Any]) -> Touch:
    """Return the body of a store, SI; without a friction law where its contact changes its phase.

    Raises InputError for what cannot be drawn.
    """
    system = find(attrs["system"])
    if system is None:
        raise InputError(
            [f"the system `{attrs['system']}` must be known here to be drawn: register it first."]
        )
    friction = attrs.get("friction", {}) if "contact" not in attrs else {}
    law = system.laws.get(friction.get("law"), Frictionless)
    body = system.body_of(attrs["parameters"], law._make(friction[name] for name in law._fields))
    refuse_outline(body, system.name)
    needed = [name for name in Touch._fields if name not in Touch._field_defaults]
    missing = [name for name in needed if not hasattr(body, name)]
    if missing:
        what = f"a body that is shown must have {', '.join(needed)}"
        raise InputError([f"{what}, but that of `{attrs['system']}` has no {missing[0]}."])
    return Touch(*(getattr(body, name) for name in needed))


def refuse_outline(body: Any, system: str) -> None:
    """Raise InputError for a body that pictures and files of simulators cannot contain yet."""
    if not isinstance(getattr(body, "outline", Ball()), Ball):
        raise InputError(
            f"a body that is drawn or exported must touch the plane with spheres, but `{system}` "
            "has another outline."
        )


def columns_of(attrs: dict[str, Any]) -> set[str]:
    """Return the names of the columns that a run of a known system can have."""
    system: Any = find(attrs["system"])
    of_contact = {"phase", "ball"} if "contact" in attrs else set()
    return {*column_names(system, system.forms[attrs["form"]], True, "double"), *of_contact}


def shape(attrs: dict[str, Any]) -> dict[str, Any]:
    """Return the body as the page draws it, from root attributes; lengths in metres.

    Returns
    -------
    dict
        kind (ball, heavy, cylinder), unit (the length that is 1 in the picture), balls (offset
        along 3hat from the centre of mass, and radius), ellipsoid (half axes across and along),
        weight [N], fixed.
    """
    b = body_of(attrs)
    system = by_name(attrs["system"])
    kind = "ball" if b.R > 0 else "heavy"
    if not system.vectors:
        kind = "cylinder"
    offset, radius, weight, *ellipsoid = map(float, sizes(b, heavy=kind == "heavy"))
    balls = [{"offset": offset, "radius": radius}]
    stem = attrs.get("stem")
    if stem:
        balls.append({"offset": offset + stem["h"], "radius": stem["r"]})
    return {
        "kind": kind,
        "unit": radius or -offset,
        "balls": balls,
        "ellipsoid": ellipsoid,
        "weight": weight,
        "fixed": kind == "heavy" and "x" not in system.initial,
    }


def sizes(b: Touch, *, heavy: bool) -> tuple[Any, ...]:
    """Return offset and radius of the ball, the weight, and the half axes of the ellipsoid.

    The ellipsoid has the moments of inertia of the body; that of a heavy top shrinks until it ends
    before the tip. Half axes are across and along 3hat. Numbers, or symbols of a page.
    """
    across2 = 2.5 * b.I3 / b.m
    across = np.sqrt(across2)
    along = np.sqrt(np.maximum(5 * b.I1 / b.m - across2, 0.02 * across2))
    size = np.minimum(1.0, -b.c * BIGGEST / np.maximum(across, along)) if heavy else 1.0
    return b.c, b.R, b.m * b.g, size * across, size * along


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrix of a unit quaternion: its columns are the axes of the body."""
    return np.array(axes(Quaternion(*quaternion))).T
