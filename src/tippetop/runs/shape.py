"""What a body looks like: its balls, its stem, or the uniform ellipsoid that has its moments of inertia."""

import math
from typing import Any

from ..errors import InputError, a_system
from ..mechanics.contact.body import Body
from ..mechanics.friction import Frictionless
from ..mechanics.systems import find


BIGGEST = 0.78  # of the distance from the tip: half axes of the ellipsoid of a heavy top that are longer are cut


def body_of(attrs: dict[str, Any]) -> Body:
    """The body of a store, SI; without a friction law where its contact changes its phase. Raises InputError for what
    cannot be drawn."""
    system = find(attrs["system"])
    if system is None:
        raise InputError([f"the system `{attrs['system']}` must be known here to be drawn: register it first."])
    friction = attrs.get("friction", {}) if "contact" not in attrs else {}
    law = getattr(system.laws.get(friction.get("law")), "record", Frictionless)
    body = system.body_of(attrs["parameters"], law(**{name: friction[name] for name in law._fields}))
    if not isinstance(body, Body):
        raise InputError([f"only tops and cylinders can be shown; this is {a_system(attrs['system'])}."])
    return body


def is_planar(attrs: dict[str, Any]) -> bool:
    """Whether the body is a cylinder."""
    system = find(attrs["system"])
    return system is not None and not system.vectors


def is_fixed(attrs: dict[str, Any]) -> bool:
    """Whether the tip of a heavy top is fixed."""
    system = find(attrs["system"])
    return system is not None and "x" not in system.initial


def shape(attrs: dict[str, Any]) -> dict[str, Any]:
    """The body as the page draws it, by the root attributes of its store; lengths in metres.

    Returns
    -------
    dict
        kind (ball, heavy, cylinder), unit (the length that is 1 in the picture), balls (offset along 3hat from the
        centre of mass, and radius), ellipsoid (half axes across and along), weight [N], fixed.
    """
    b = body_of(attrs)
    balls, stem = [{"offset": b.c, "radius": b.R}], attrs.get("stem")
    if stem:
        balls.append({"offset": b.c + stem["h"], "radius": stem["r"]})
    kind = "cylinder" if is_planar(attrs) else "ball" if b.R > 0 else "heavy"
    across2 = 2.5 * b.I3 / b.m
    across, along = math.sqrt(across2), math.sqrt(max(5 * b.I1 / b.m - across2, 0.02 * across2))
    size = min(1.0, BIGGEST * abs(b.c) / along, BIGGEST * abs(b.c) / across) if kind == "heavy" else 1.0
    return {
        "kind": kind,
        "unit": b.R if b.R > 0 else -b.c,
        "balls": balls,
        "ellipsoid": [size * across, size * along],
        "weight": b.m * b.g,
        "fixed": kind == "heavy" and is_fixed(attrs),
    }


def with_shape(trajectory: Any, events: Any, attrs: dict[str, Any]) -> tuple[Any, dict[str, Any], dict[str, Any]]:
    """What the film strip of a run is made of: its rows, its attributes, its body."""
    return trajectory, attrs, shape(attrs)
