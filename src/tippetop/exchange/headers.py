"""What the header of a table says: the columns that stand there, by name and unit."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import first_sentences, suggestion


TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
ANGLES = {"rad": 1.0, "deg": np.pi / 180, "turn": 2 * np.pi}
RATES = {
    "rad/s": 1.0,
    "rad s-1": 1.0,
    "deg/s": np.pi / 180,
    "deg s-1": np.pi / 180,
    "rpm": np.pi / 30,
    "1/s": 1.0,
    "Hz": 2 * np.pi,
}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
SPEEDS = {"m/s": 1.0, "m s-1": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
FORCES = {"N": 1.0, "mN": 1e-3}
PLAIN = {"1": 1.0, "": 1.0}

COLUMNS = {
    name: units
    for names, units in (
        ("t", TIMES),
        ("theta phi psi", ANGLES),
        ("theta_dot phi_dot omega3", RATES),
        ("axis_x axis_y axis_z q_w q_x q_y q_z q_0 q_1 q_2 q_3", PLAIN),
        ("x y z", LENGTHS),
        ("vx vy vz", SPEEDS),
        ("omega_x omega_y omega_z omega_body_x omega_body_y omega_body_z", RATES),
        ("force_x force_y force_z", FORCES),
        ("marker_x marker_y marker_z", LENGTHS),
    )
    for name in names.split()
}
"""Name of a column -> its units, with their size in SI.

q: body to space; omega: in the space frame.
"""

OWN = {"theta", "theta_dot", "energy", "modified_energy", "normal_force"}
"""Columns of every run: after `time` they identify a header of `tippetop export`."""
RENAMED = {"time": "t"} | {f"orientation_{c}": f"q_{c}" for c in "wxyz"}


class Heading(NamedTuple):
    """What is read of a table, by its header.

    Parameters
    ----------
    places
        Of the columns that are read, among those of the file.
    names, sizes
        Of each, and of its unit in SI.
    faults
        What is wrong, in sentences.
    """

    places: tuple[int, ...]
    names: tuple[str, ...]
    sizes: tuple[float, ...]
    faults: tuple[str, ...] = ()


def heading(header: Sequence[str]) -> Heading:
    """What is read of a table with this header; an exported run without units is in SI."""
    places: Sequence[int] = range(len(header))
    bare = [text.partition(" [")[0] for text in header]
    if bare[:1] == ["time"] and set(bare) >= OWN:
        units = [COLUMNS.get(RENAMED.get(name, name)) for name in bare]
        places = [i for i, known in enumerate(units) if known]
        header = [
            header[i] if "[" in header[i] else f"{bare[i]} [{next(iter(units[i] or ()))}]"
            for i in places
        ]
    else:
        places = [i for i, name in enumerate(bare) if name != "phase"]  # words, not numbers
        header = [header[i] for i in places]
    columns = [_column(text) for text in header]
    names, sizes, wrong = zip(*columns, strict=True) if columns else ((), (), ())
    faults = [fault for fault in wrong if fault]
    unknown = [name for name, _, fault in columns if name not in COLUMNS and not fault]
    faults += [_unknown(unknown)] if unknown else []
    faults += [
        f"the column `{name}` must stand once, but stands {'twice' if n == 2 else f'{n} times'}."
        for name, n in Counter(names).items()
        if n > 1
    ]
    if "t" not in names:
        faults.append("the times must be a column `t [s]`, but there is none.")
    return Heading(tuple(places), names, sizes, tuple(first_sentences(faults, str)))


def _column(text: str) -> tuple[str, float, str]:
    """Name, size of the unit and fault of a column, of its header; an unknown name is not a fault
    of its own.
    """
    match = re.fullmatch(r"\s*([A-Za-z_]\w*)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*", text)
    if not match:
        return (
            text,
            1.0,
            f"a header must be a name and a unit such as `theta [deg]`, but has {text!r:.60}.",
        )
    name = RENAMED.get(match[1], match[1])
    unit = ((match[2] if match[2] is not None else match[3]) or "").strip()
    units = COLUMNS.get(name)
    if units is None or unit in units:
        return name, units[unit] if units else 1.0, ""
    given = f"has `{unit}`" if unit else "has none"
    words = " or ".join(f"[{u}]" for u in units if u)
    return name, 1.0, f"the column `{match[1]}` must have a unit, {words}, but {given}."


def _unknown(names: Sequence[str]) -> str:
    """A sentence about names that are none of ours."""
    known = ", ".join(name for name in COLUMNS if not re.fullmatch(r"q_\d", name))
    if len(names) == 1:
        return (
            f"the column `{names[0]}` is not known.{suggestion(names[0], COLUMNS)} The "
            f"columns are {known}."
        )
    some = ", ".join(f"`{name}`" for name in names[:5]) + (
        f" and {len(names) - 5} more" if len(names) > 5 else ""
    )
    return f"the columns {some} are not known. The columns are {known}."
