"""The page of a run: its rows are read, as many as needed are kept, and written into one file."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import flag_names, flagged, greek, units_text
from ..errors import InputError, StoreError
from ..runs.attributes import headline_of
from ..runs.shape import body_of, is_planar, shape
from ..store import chunks
from . import formulas, pages, thinning
from .given import encoded
from .samples import needed, plain, samples, without


MOST = 200_000  # samples of a page: 20 MB
MOST_EVENTS = 20_000
DEGREE = np.pi / 180
TOO_FAR = 0.2 * DEGREE  # between rows: a page that shows less says so


Rows = Iterator[Mapping[str, np.ndarray]]


def page_of_store(
    path: Path, attrs: dict[str, Any], start: float | None = None, until: float | None = None
) -> str:
    """The page of a stored run, or of a part of it. Raises InputError, StoreError."""
    refuse(attrs, str(path))
    names = needed(attrs)
    groups = chunks.for_figures(path)
    return page(chunks.pieces(path, "trajectory", names), groups, attrs, start, until)


def refuse(attrs: dict[str, Any], what: str) -> None:
    """Raises where a run cannot be shown: InputError, StoreError."""
    if attrs["status"] == "running":
        raise StoreError(
            f"`{what}` must be finished to be viewed, but is not: tippetop resume {what}."
        )
    body_of(attrs)
    if "columns" in attrs["run"] and "orientation" not in attrs["run"]["columns"]:
        raise InputError(
            [
                "a page needs the column `orientation`, which is not among the run.columns of "
                "this run."
            ]
        )
    if not attrs["run"].get("orientation", False):
        raise InputError(
            [
                "a page needs the column `orientation`, which this run has not kept: say "
                "run.orientation = true."
            ]
        )
    if missing := ", ".join(f"`{name}`" for name in without(attrs)):
        raise InputError(
            [
                f"a page must have the columns {missing}, which this run has not kept: see its "
                "run.columns."
            ]
        )
    if attrs["run"].get("output") == "keyframes" and "replay" not in attrs:
        raise InputError(["a page is made of rows, and this run keeps none: replay a part of it."])


def page(
    pieces: Rows,
    groups: Mapping[str, Any],
    attrs: dict[str, Any],
    start: float | None = None,
    until: float | None = None,
) -> str:
    """The page of a run whose rows come in pieces.

    Parameters
    ----------
    pieces
        Columns of the trajectory by name, in SI units, in the order of time.
    groups
        Tables of the run: `events`, and `phases` and `impacts` where it has them.
    attrs
        The root attributes of its store.
    start, until
        The part that is shown [s]; without them all, or as much from the start as a page can hold.

    Returns
    -------
    str
        The text of an HTML file.
    """
    times, kept, rough, notes = gathered(pieces, attrs, start, until)
    if rough > TOO_FAR:
        notes.append(
            "The rows are far apart: between two of them the drawn attitude may be off by "
            f"{rough / DEGREE:.2g}°. "
            "A run with a smaller run.output_step, or a replay with a smaller step, shows more."
        )
    log, phases = _events(groups, times[0], times[-1]), _phases(groups, times[0], times[-1])
    data = {
        "name": attrs["system"],
        "title": attrs["title"][0].upper() + attrs["title"][1:],
        "about": units_text(greek(headline_of(attrs).partition(" · ")[2])),
        "notes": notes,
        "body": shape(attrs),
        "wound": is_planar(attrs),
        "times": encoded(times, "<f8"),
        "samples": encoded(kept, "<f4"),
        "events": log,
        "phases": phases,
    }
    scripts = {"formulas.js": formulas.potential(plain(attrs), body_of(attrs))}
    return pages.page(f"{attrs['title']} · tippetop", "page_run.js", data, scripts)


def gathered(
    pieces: Rows, attrs: dict[str, Any], start: float | None, until: float | None
) -> tuple[np.ndarray, np.ndarray, float, list[str]]:
    """Times and samples that a page keeps, by how much the attitude may be missed between rows
    [rad], and sentences on what is left out. Raises InputError where no row is within.
    """
    begin, end, notes = start or 0.0, np.inf if until is None else until, []
    if not begin < end:
        raise InputError(
            [
                f"the part that is shown must begin before it ends, but goes from {begin:g} to "
                f"{end:g} s."
            ]
        )
    times, kept, rough, total, last = [], [], 0.0, 0, None
    for piece in pieces:
        within = (piece["time"] >= begin) & (piece["time"] <= end)
        if not within.any():
            continue
        columns = {name: values[within] for name, values in piece.items()}
        t, some = columns["time"], samples(columns, attrs)
        rough = max(rough, thinning.between(t, some))
        if last is None:
            span = max(min(end, end_of(attrs)) - t[0], 1e-300)
        few = thinning.kept(t, some, max(1, math.ceil(thinning.FEW * (t[-1] - t[0]) / span)))
        times.append(t[few])
        kept.append(some[few])
        total, last = total + len(few), t[-1]
        if total > MOST:
            notes.append(
                f"This is the run up to {last:.6g} s, as much as a page holds: --from and "
                "--until choose another part."
            )
            break
    if last is None and start is None and until is None:
        raise InputError(["a page must have rows, but this run has kept none."])
    if last is None:
        raise InputError(
            [f"a page must have rows between {begin:g} and {end:g} s, but this run has none there."]
        )
    return np.concatenate(times), np.concatenate(kept), rough, notes


def end_of(attrs: dict[str, Any]) -> float:
    """The time of the last row of a run [s]."""
    return float(attrs["replay"]["until"] if "replay" in attrs else attrs["report"]["t_end"])


def _events(groups: Mapping[str, Any], begin: float, end: float) -> list[dict[str, Any]]:
    """The events within a part of a run, turnings only where they are significant."""
    events = groups["events"]
    names = events["kind"].attrs["flag_meanings"].split()
    keep = (events["time"].values >= begin) & (events["time"].values <= end)
    keep &= ~flagged(events["kind"], "turning") | events["significant"].values.astype(bool)
    rows = np.flatnonzero(keep)
    rows = rows[:: max(1, -(-len(rows) // MOST_EVENTS))]
    columns = (
        events[name].values[rows].tolist() for name in ("time", "kind", "theta", "theta_dot_sign")
    )
    return [
        {
            "time": t,
            "kind": names[kind],
            "theta": theta if math.isfinite(theta) else None,
            "least": sign > 0,
        }
        for t, kind, theta, sign in zip(*columns, strict=True)
    ]


def _phases(groups: Mapping[str, Any], begin: float, end: float) -> list[dict[str, Any]]:
    """The phases of the contact within a part of a run."""
    if "phases" not in groups:
        return []
    table = groups["phases"]
    columns = [
        table["start"].values.tolist(),
        table["end"].values.tolist(),
        flag_names(table["phase"]),
        flag_names(table["ball"]),
    ]
    rows = (
        dict(zip(("start", "end", "phase", "ball"), row, strict=True))
        for row in zip(*columns, strict=True)
    )
    return [row for row in rows if row["end"] >= begin and row["start"] <= end]
