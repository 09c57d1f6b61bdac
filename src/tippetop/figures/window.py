"""A part of a run, from one time to another, as figures are made of it."""

from typing import Any

import numpy as np

from ..errors import InputError


def handed_over(groups: dict[str, Any]) -> list[float]:
    """The times at which another ball touches than before [s]."""
    if "impacts" not in groups:
        return []
    balls, begun = groups["phases"]["ball"].values, groups["phases"]["start"].values
    return [
        float(time)
        for time, now, before in zip(begun[1:], balls[1:], balls[:-1], strict=True)
        if now != before
    ]


def in_window(
    groups: dict[str, Any], attrs: dict[str, Any], start: float | None, until: float | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The part of a run from one time to another [s], and its attributes with the row that it began
    with: changes are measured from there. Raises InputError if nothing is in between.
    """
    if start is None and until is None:
        return groups, attrs
    low, high = -np.inf if start is None else start, np.inf if until is None else until
    if not low < high:
        raise InputError(
            [
                f"the part that is shown must begin before it ends, but goes from {low:g} to "
                f"{high:g} s."
            ]
        )
    whole = groups["trajectory"]
    cut = dict(groups)
    for name in ("trajectory", "events", "impacts"):
        if name in groups:
            times = groups[name]["time"].values
            cut[name] = _rows(groups[name], (times >= low) & (times <= high))
    if len(cut["trajectory"]["time"].values) < 2:
        raise InputError(
            [f"at least two rows must be from t = {low:g} to {high:g} s, but there are fewer."]
        )
    if "phases" in groups:
        phases = groups["phases"]
        limits = cut["trajectory"]["time"].values[[0, -1]]
        kept = _rows(
            phases, (phases["end"].values > limits[0]) & (phases["start"].values < limits[1])
        )
        cut["phases"] = {name: kept[name] for name in kept}
        for name in ("start", "end"):
            column, values = kept[name], np.clip(kept[name].values, *limits)
            is_plain = hasattr(column, "_replace")
            cut["phases"][name] = (
                column._replace(values=values) if is_plain else column.copy(data=values)
            )
    first = {name: float(whole[name].values[0]) for name in whole if whole[name].values.ndim == 1}
    return cut, attrs | {"first_row": first}


def _rows(group: Any, keep: Any) -> Any:
    """Some rows of a Dataset or of columns by name."""
    if hasattr(group, "isel"):
        return group.isel({group["time" if "time" in group else "start"].dims[0]: keep})
    return {name: column._replace(values=column.values[keep]) for name, column in group.items()}
