"""Headers of tables: the known columns, by name and unit.

The cells of a header go in; places, names and units of columns come out.
"""

import re
from collections.abc import Sequence
from contextlib import suppress

from ..errors import InputError, suggestion
from ..mechanics.quantity import number_of
from ..mechanics.units import (
    METRE,
    METRE_PER_SECOND,
    METRE_PER_SECOND2,
    NEWTON,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    SECOND,
)


KINDS = {
    "orientation": (
        "q_w q_x q_y q_z q_0 q_1 q_2 q_3",
        ONE,
        "unit quaternion, body to space; `--quaternion` names the order of q_0 ... q_3",
    ),
    "axis": ("axis_x axis_y axis_z", ONE, "3hat, the axis of the body"),
    "place": ("x y z", METRE, "place of the centre of mass"),
    "velocity": ("vx vy vz", METRE_PER_SECOND, "velocity of the centre of mass"),
    "omega": (
        "omega_x omega_y omega_z",
        RADIAN_PER_SECOND,
        "angular velocity along space axes; omega_z is the turn about the vertical, positive "
        "counter-clockwise seen from above",
    ),
    "gyroscope": (
        "omega_body_x omega_body_y omega_body_z",
        RADIAN_PER_SECOND,
        "angular velocity along body axes, as a gyroscope in the body measures it",
    ),
    "accelerometer": (
        "accelerometer_x accelerometer_y accelerometer_z",
        METRE_PER_SECOND2,
        "specific force at a chip in the body (`--chip`; by default at the centre of mass), along "
        "body axes: acceleration of the place in space less that of gravity; +g along an axis at "
        "rest that points up",
    ),
    "force": ("force_x force_y force_z", NEWTON, "force of the contact on the body"),
    "marker": ("marker_x marker_y marker_z", METRE, "place of a marker on the body (`--marker`)"),
}
"""Kind of measurement -> names of its components, SI unit and meaning; directions are in space."""
SCALARS = {
    "t": (SECOND, "time, from the start of the motion"),
    "theta": (RADIAN, "inclination of 3hat from the vertical, 0 to pi"),
    "phi": (RADIAN, "azimuth of 3hat, from x towards y"),
    "psi": (RADIAN, "turn of the body about 3hat"),
    "theta_dot": (RADIAN_PER_SECOND, "rate of theta"),
    "phi_dot": (RADIAN_PER_SECOND, "rate of phi"),
    "omega3": (
        RADIAN_PER_SECOND,
        "spin: angular velocity about 3hat, psi' + phi' cos(theta), positive counter-clockwise "
        "seen from the end of 3hat",
    ),
}
"""Name of a column -> its SI unit and meaning."""
KIND = {name: kind for kind, (names, *_) in KINDS.items() for name in names.split()}
"""Name of a component -> the kind."""
COLUMNS = {
    **{name: unit for name, (unit, _) in SCALARS.items()},
    **{name: KINDS[kind][1] for name, kind in KIND.items()},
}
"""Name of a column -> its SI unit."""
CAMERA = re.compile(r"camera_(-?\d+(?:\.\d+)?)(?:_(-?\d+(?:\.\d+)?))?")
LEAN = (
    "camera_AZIMUTH, camera_AZIMUTH_ELEVATION",
    RADIAN.symbol,
    "direction of 3hat in the picture of a far camera that looks at the top from there (degrees, "
    "from x towards y, and above the horizon): atan2(3hat.right, 3hat.up), 0 upright, positive to "
    "the right",
)

UNITS = {
    **dict.fromkeys(("place", "marker"), "m"),
    **dict.fromkeys(("omega", "gyroscope", "omega3", "theta_dot", "phi_dot"), "rad/s"),
    "velocity": "m/s",
    "accelerometer": "m/s2",
    "force": "N",
}
"""Units of differences as text, by quantity; the others are angles in rad.

A stated noise applies to those that are missing here: see `Observation.stated`.
"""

OWN = {"theta", "theta_dot", "energy", "normal_force"}
"""Columns of every run, which identify a header of `tippetop export`."""

RENAMED = {
    "time": "t",
    **{f"orientation_{c}": f"q_{c}" for c in "wxyz"},
    **{f"gyroscope {c}": f"omega_body_{c}" for c in "xyz"},
    **{f"acceleration {c}": f"accelerometer_{c}" for c in "xyz"},
}
"""Other names of columns; those with a space are phyphox's."""
IGNORED = ("phase", "absolute", "absolute acceleration")
"""Columns that are not read: words, and what others contain."""
SUFFIXES = "s|ms|deg|rad|m|cm|mm|rpm"
HEADER = re.compile(
    r"\s*([^\W\d][\w.-]*?(?: \w+)*)\s*"
    rf"(?:\[([^\]]*)\]|\(([^)]*)\)|/\s*([^,;\t]+)|_({SUFFIXES}))?\s*"
)
ANGLES = "rad mrad deg degree degrees ° rpm rev turn"
"""Parts of units of which those of an angle must have one: a speed in min-1 is one in turns."""
# Parts of units: others of pint's are traps, such as px (of printers) and Grad (giga-radian)
PARTS = f"s sec second seconds ms us µs min h m cm mm um µm km {ANGLES} N mN kN g_0"
PART = re.compile(r"[A-Za-zµ°]+(?:_0)?")


def parsed(text: str) -> tuple[str, str]:
    """Return the name of a column and its unit, empty if it has none; no name: not a header.

    The name is ours, see `RENAMED`; whether it is known is left to `heading`.
    """
    match = HEADER.fullmatch(text)
    if match is None:
        return "", ""
    name, *units = match.groups(default="")
    name = name.lower() if len(name) > 1 else name
    return RENAMED.get(name, name), "".join(units).strip(" ()")


def heading(header: Sequence[str]) -> dict[str, tuple[int, float]]:
    """Return the index of each known column among the cells, and its unit in SI units, by name.

    Unknown columns of an exported run are ignored, and those without a unit are in SI units.
    Raises InputError, with a sentence for each fault.
    """
    own = {text.partition(" [")[0] for text in header} >= OWN
    found: dict[str, tuple[int, float]] = {}
    faults = []
    unknown = []
    for place, text in enumerate(header):
        name, given = parsed(text)
        unit = RADIAN if CAMERA.fullmatch(name) else COLUMNS.get(name)
        if not text.strip():
            continue
        if not name:
            faults.append(
                "a header must be names with units, separated by commas, semicolons or tabs, such "
                f"as `t [s], theta [deg]`, but has {text!r:.60}."
            )
        elif name in IGNORED:
            continue
        elif unit is None:
            unknown.append(name)
        elif name in found:
            faults.append(
                f"the column `{name}` must occur once, but occurs more often: choose one "
                "of several objects (`track`)."
            )
        elif not (given or own or unit == ONE):
            faults.append(
                f"the column `{text.strip()}` must have a unit, such as `{text.strip()} "
                f"[{unit.symbol}]`, but has none."
            )
        elif not given or given == unit.symbol:
            found[name] = place, 1.0
        elif strange := (parts := {*PART.findall(given)}) - {*PARTS.split()}:
            faults.append(
                f"the unit of `{name}` must be made of {PARTS.replace(' ', ', ')}, but has "
                f"`{strange.pop()}`."
            )
        else:
            turning = unit in (RADIAN, RADIAN_PER_SECOND)
            if not turning or not parts.isdisjoint(ANGLES.split()):
                with suppress(InputError):
                    found[name] = place, number_of(f"1 {given}", name, unit)
            if name in found:
                continue
            turns = " (turns per minute are `rpm`)" if unit == RADIAN_PER_SECOND else ""
            faults.append(
                f"the unit of `{name}` must be {unit.symbol} or of the same kind{turns}, but is "
                f"`{given}`."
            )
    if unknown and not own:
        faults.append(
            f"the columns {', '.join(f'`{name}`' for name in unknown[:5])} are not known: rename "
            f"them or leave them out.{suggestion(unknown[0], COLUMNS)} The columns are "
            f"{', '.join(COLUMNS)}, camera_AZIMUTH."
        )
    if "t" not in [parsed(text)[0] for text in header]:
        faults.append(
            "the times must be a column `t [s]`, but it is missing: divide numbers of frames by "
            "the frames per second."
        )
    if faults:
        raise InputError(faults)
    return found
