"""Parts of runs, from one time to another."""

from typing import Any

import numpy as np

from ..errors import InputError


def datasets(groups: dict[str, Any]) -> dict[str, Any]:
    """Return the groups of a run as Datasets, given as Datasets or as columns by name."""
    import xarray as xr

    return {
        name: group
        if isinstance(group, xr.Dataset)
        else xr.Dataset({key: column[:3] for key, column in group.items()})
        for name, group in groups.items()
    }


def handed_over(groups: dict[str, Any]) -> np.ndarray:
    """Return the times at which another ball touches the plane than before [s]."""
    if "impacts" not in groups:
        return np.empty(0)
    return groups["phases"]["start"].values[1:][np.diff(groups["phases"]["ball"].values) != 0]


def in_window(
    groups: dict[str, Any], attrs: dict[str, Any], start: float | None, until: float | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a part of a run [s], and its attributes with the first row of the whole run.

    Changes are measured from that row. Raises InputError if nothing is in between.
    """
    groups = datasets(groups)
    if start is None and until is None:
        return groups, attrs
    low, high = -np.inf if start is None else start, np.inf if until is None else until
    if not low < high:
        raise InputError(
            "the part that is shown must begin before it ends, but goes from "
            f"{low:g} to {high:g} s."
        )
    whole, cut = groups["trajectory"], dict(groups)
    for name in ("trajectory", "events", "impacts"):
        if name in groups:
            time = groups[name]["time"]
            keep = ((time >= low) & (time <= high)).values
            cut[name] = groups[name].isel({time.dims[0]: keep})
    times = cut["trajectory"]["time"].values
    if len(times) < 2:
        raise InputError(
            f"at least two rows must be from t = {low:g} to {high:g} s, but there are fewer."
        )
    if "phases" in groups:
        phases = groups["phases"]
        keep = ((phases["end"] > times[0]) & (phases["start"] < times[-1])).values
        phases = phases.isel({phases["start"].dims[0]: keep})
        limits = {name: phases[name].clip(times[0], times[-1]) for name in ("start", "end")}
        cut["phases"] = phases.assign(limits)
    row = whole.isel(time=0)
    first = {name: float(row[name]) for name in row.variables if row[name].shape == ()}
    return cut, attrs | {"first_row": first}
