"""The phases of a run's contact and its impacts, as tables of its store."""

from typing import Any

import numpy as np

from ..columns import Column, column
from ..engine.contact.tables import FLAGS, IMPACT_COLUMNS, PHASE_COLUMNS, as_table
from ..mechanics.units import JOULE, METRE_PER_SECOND, NEWTON_SECOND, SECOND


PER_CHUNK = 4096  # rows
DIMENSIONS = {"phases": "interval", "impacts": "impact"}
MEASURED: dict[str, Any] = {
    "start": (SECOND, "when the phase began"),
    "end": (SECOND, "when it ended"),
    "time": (SECOND, "time of the impact"),
    "v_n_before": (METRE_PER_SECOND, "vertical velocity of the contact point before"),
    "v_n_after": (METRE_PER_SECOND, "vertical velocity of the contact point after"),
    "speed_before": (METRE_PER_SECOND, "sliding speed before"),
    "speed_after": (METRE_PER_SECOND, "sliding speed after"),
    "impulse": (NEWTON_SECOND, "normal impulse"),
    "friction_impulse": (NEWTON_SECOND, "size of the horizontal impulse"),
    "work": (JOULE, "energy that the body gained, negative where it lost"),
}
NAMED = {
    "phase": "phase of the contact",
    "ball": "what touches the plane, or did last",
    "reason": "why the phase began",
    "mode": "how friction ended within the impact",
}


def columns(name: str, table: dict[str, np.ndarray]) -> dict[str, Column]:
    """Rows of a table as columns of the store's group of this name."""
    dims = (DIMENSIONS[name],)
    result = {}
    for key, values in table.items():
        if key in MEASURED:
            unit, words = MEASURED[key]
            result[key] = column(values, unit, words, dims)
            continue
        flags = {"flag_values": list(range(len(FLAGS[key]))), "flag_meanings": " ".join(FLAGS[key])}
        result[key] = Column(dims, values, {"units": "1", "long_name": NAMED[key], **flags})
    return result


def empty() -> dict[str, dict[str, Column]]:
    """The tables without rows, by name."""
    names = {"phases": PHASE_COLUMNS, "impacts": IMPACT_COLUMNS}
    return {name: columns(name, as_table(of, [])) for name, of in names.items()}


def joined(parts: dict[str, list[dict[str, np.ndarray]]]) -> dict[str, dict[str, Column]]:
    """Tables whose rows came in parts."""
    whole = {}
    for name, tables in parts.items():
        whole[name] = columns(name, {key: np.concatenate([t[key] for t in tables]) for key in tables[0]})
    return whole
