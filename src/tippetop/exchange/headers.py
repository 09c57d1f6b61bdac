"""Headers of tables: the known columns, by name and unit."""

import re
from collections.abc import Sequence

from ..errors import InputError, suggestion
from ..mechanics.quantity import number_of
from ..mechanics.units import (
    METRE,
    METRE_PER_SECOND,
    NEWTON,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    SECOND,
)


KINDS = {
    "axis": ("axis_x axis_y axis_z", ONE),
    "orientation": ("q_w q_x q_y q_z q_0 q_1 q_2 q_3", ONE),
    "place": ("x y z", METRE),
    "velocity": ("vx vy vz", METRE_PER_SECOND),
    "omega": ("omega_x omega_y omega_z omega_body_x omega_body_y omega_body_z", RADIAN_PER_SECOND),
    "force": ("force_x force_y force_z", NEWTON),
    "marker": ("marker_x marker_y marker_z", METRE),
}
SCALARS = {
    "t": SECOND,
    **dict.fromkeys(("theta", "phi", "psi"), RADIAN),
    **dict.fromkeys(("theta_dot", "phi_dot", "omega3"), RADIAN_PER_SECOND),
}
KIND = {name: kind for kind, (names, _) in KINDS.items() for name in names.split()}
"""Name of a component -> the quantity."""
COLUMNS = SCALARS | {name: KINDS[kind][1] for name, kind in KIND.items()}
"""Name of a column -> its SI unit. q: body to space; omega: in the space frame."""

UNITS = {
    **dict.fromkeys(("place", "marker"), "m"),
    **dict.fromkeys(("omega", "omega3", "theta_dot", "phi_dot"), "rad/s"),
    "velocity": "m/s",
    "force": "N",
}
"""Units of differences as text, by quantity; the others are angles in rad."""

OWN = {"theta", "theta_dot", "energy", "normal_force"}
"""Columns of every run, which identify a header of `tippetop export`."""

RENAMED = {"time": "t"} | {f"orientation_{c}": f"q_{c}" for c in "wxyz"}
HEADER = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*")


def heading(header: Sequence[str]) -> dict[str, tuple[int, float]]:
    """Return the place of each known column and its unit in SI units.

    Unknown columns of an exported run are ignored, and those without a unit are in SI units.
    Raises InputError."""
    own = {text.partition(" [")[0] for text in header} >= OWN
    found: dict[str, tuple[int, float]] = {}
    faults = []
    unknown = []
    for place, text in enumerate(header):
        match = HEADER.fullmatch(text)
        name = RENAMED.get(match[1], match[1]) if match else ""
        unit = COLUMNS.get(name)
        given = match and (match[2] or match[3] or "").strip()
        if match is None:
            faults.append(
                "a header must be names with units, separated by commas, such as "
                f"`t [s], theta [deg]`, but has {text!r:.60}."
            )
        elif name == "phase":  # words, which are not read
            continue
        elif unit is None:
            unknown.append(name)
        elif name in found:
            faults.append(f"the column `{name}` must occur once, but occurs more often.")
        elif not (given or own or unit == ONE):
            faults.append(
                f"the column `{match[1]}` must have a unit, such as `{match[1]} "
                f"[{unit.symbol}]`, but has none."
            )
        elif not given or given == unit.symbol:
            found[name] = place, 1.0
        else:
            try:
                found[name] = place, number_of(f"1 {given}", name, unit)
            except InputError as error:
                faults += error.sentences
    if unknown and not own:
        faults.append(
            f"the columns {', '.join(f'`{name}`' for name in unknown[:5])} are not known."
            f"{suggestion(unknown[0], COLUMNS)} The columns are {', '.join(COLUMNS)}."
        )
    if "t" not in found:
        faults.append("the times must be a column `t [s]`, but it is missing.")
    if faults:
        raise InputError(faults)
    return found
