"""What the header of a table says: the columns that stand there, by name and unit."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import first_sentences, suggestion


TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
ANGLES = {"rad": 1.0, "deg": np.pi / 180, "turn": 2 * np.pi}
RATES = {"rad/s": 1.0, "rad s-1": 1.0, "deg/s": np.pi / 180, "deg s-1": np.pi / 180, "rpm": np.pi / 30,
         "1/s": 1.0, "Hz": 2 * np.pi}  # fmt: skip
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
SPEEDS = {"m/s": 1.0, "m s-1": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
PLAIN = {"1": 1.0, "": 1.0}

COLUMNS: dict[str, tuple[dict[str, float], str]] = {
    "t": (TIMES, "time"),
    "theta": (ANGLES, "inclination of the axis"),
    "phi": (ANGLES, "azimuth of the axis"),
    "psi": (ANGLES, "turn of the body about its axis"),
    "theta_dot": (RATES, "rate of theta"),
    "phi_dot": (RATES, "rate of phi"),
    "omega3": (RATES, "angular velocity about the axis"),
    **{f"axis_{c}": (PLAIN, "unit vector along the axis, space frame") for c in "xyz"},
    **{f"q_{c}": (PLAIN, "unit quaternion, body to space") for c in "wxyz"},
    **{f"q_{i}": (PLAIN, "unit quaternion, its order named beside") for i in range(4)},
    **{c: (LENGTHS, "place of the centre of mass") for c in "xyz"},
    **{f"v{c}": (SPEEDS, "velocity of the centre of mass") for c in "xyz"},
    **{f"omega_{c}": (RATES, "angular velocity, space frame") for c in "xyz"},
    **{f"omega_body_{c}": (RATES, "angular velocity, body frame") for c in "xyz"},
    **{f"marker_{c}": (LENGTHS, "place of a marker on the body, space frame") for c in "xyz"},
}
"""Name -> units with their size in SI, and what it is."""

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


def is_own(header: Sequence[str]) -> bool:
    """Return whether a header is that of an exported run; without units it is in SI."""
    names = [text.partition(" [")[0] for text in header]
    return names[:1] == ["time"] and set(names) >= OWN


def heading(header: Sequence[str]) -> Heading:
    """What is read of a table with this header."""
    places: Sequence[int] = range(len(header))
    if is_own(header):
        bare = [text.partition(" [")[0] for text in header]
        places = [i for i, name in enumerate(bare) if RENAMED.get(name, name) in COLUMNS]
        header = [header[i] if "[" in header[i] else _with_unit(bare[i]) for i in places]
    columns = [_column(text) for text in header]
    names = tuple(name for name, _, _ in columns)
    faults = [fault for _, _, fault in columns if fault]
    faults += [_unknown([name for name, _, fault in columns if name not in COLUMNS and not fault])]
    faults += [
        f"the column `{name}` must stand once, but stands {'twice' if n == 2 else f'{n} times'}."
        for name, n in Counter(names).items()
        if n > 1
    ]
    if "t" not in names:
        faults.append("the times must be a column `t [s]`, but there is none.")
    sizes = tuple(size for _, size, _ in columns)
    sentences = first_sentences([fault for fault in faults if fault], str)
    return Heading(tuple(places), names, sizes, tuple(sentences))


def _with_unit(name: str) -> str:
    """Return the header of an exported column without unit: SI, the first unit of its kind."""
    return f"{name} [{next(iter(COLUMNS[RENAMED.get(name, name)][0]))}]"


def _column(text: str) -> tuple[str, float, str]:
    """Name, size of the unit and fault of a column, of its header; an unknown name is not a fault of its own."""
    match = re.fullmatch(r"\s*([A-Za-z_]\w*)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*", text)
    if not match:
        return text, 1.0, f"a header must be a name and a unit such as `theta [deg]`, but has {text!r:.60}."
    name = RENAMED.get(match[1], match[1])
    unit = ((match[2] if match[2] is not None else match[3]) or "").strip()
    if name not in COLUMNS or unit in COLUMNS[name][0]:
        return name, COLUMNS[name][0][unit] if name in COLUMNS else 1.0, ""
    given = f"has `{unit}`" if unit else "has none"
    words = " or ".join(f"[{u}]" for u in COLUMNS[name][0] if u)
    return name, 1.0, f"the column `{match[1]}` must have a unit, {words}, but {given}."


def _unknown(names: Sequence[str]) -> str:
    """A sentence about names that are none of ours; empty if there are none."""
    if not names:
        return ""
    known = ", ".join(name for name in COLUMNS if not re.fullmatch(r"q_\d", name))
    if len(names) == 1:
        return f"the column `{names[0]}` is not known.{suggestion(names[0], COLUMNS)} The columns are {known}."
    some = ", ".join(f"`{name}`" for name in names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    return f"the columns {some} are not known. The columns are {known}."
