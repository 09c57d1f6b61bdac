"""Parts of runs, from one time to another.

Tables of a run go in and come out, for `library.plots`.
"""

from typing import Any

import numpy as np

from ..errors import InputError


def in_window(
    groups: dict[str, Any], attrs: dict[str, Any], start: float | None, until: float | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a part of a run [s], and its attributes with `first_row`, scalars of its first row.

    `conservation.changes` measures from that row. Raises InputError if fewer than two rows are in
    between.
    """
    if start is None and until is None:
        return groups, attrs
    low = -np.inf if start is None else start
    high = np.inf if until is None else until
    if not low < high:
        raise InputError(
            "the part that is shown must begin before it ends, but goes from "
            f"{low:g} to {high:g} s."
        )
    cut = dict(groups)
    for name in groups.keys() & {"trajectory", "events", "impacts"}:
        time = groups[name]["time"]
        cut[name] = groups[name].isel({time.dims[0]: ((time >= low) & (time <= high)).values})
    times = cut["trajectory"]["time"].values
    if len(times) < 2:
        raise InputError(
            f"at least two rows must be from t = {low:g} to {high:g} s, but there are fewer."
        )
    if "phases" in groups:
        begin, end = (groups["phases"][name].clip(times[0], times[-1]) for name in ("start", "end"))
        phases = groups["phases"].assign(start=begin, end=end)
        cut["phases"] = phases.isel({begin.dims[0]: (end > begin).values})
    row = groups["trajectory"].isel(time=0)
    first = {name: float(row[name]) for name in row.variables if row[name].shape == ()}
    return cut, attrs | {"first_row": first}
