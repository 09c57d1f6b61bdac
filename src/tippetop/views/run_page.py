"""The page of a run: the necessary samples of its rows in one file.

Columns of a trajectory go in, block by block; the text of an HTML file comes out.
"""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import capitalised, flag_words, flagged, greek, require, units_text
from ..errors import InputError, StoreError
from ..mechanics.contact.surroundings import TABLES, moving_axes
from ..mechanics.systems import find
from ..runs.attributes import headline_of
from ..runs.shape import body_of, columns_of, shape
from ..store import chunks
from . import pages, spacing
from .encoding import encode
from .phase_formulas import NO_POTENTIAL, potential
from .samples import NEEDED, needed, samples


MOST = 200_000  # samples of a page: 20 MB
MOST_EVENTS = 20_000
DEGREE = np.pi / 180
TOO_FAR = 0.2 * DEGREE  # between rows, beyond which a page has a note


Rows = Iterator[Mapping[str, np.ndarray]]


def page_of_store(
    path: Path, attrs: dict[str, Any], start: float | None, until: float | None
) -> str:
    """Return the page of a stored run, or of a part of it. Raises InputError, StoreError."""
    refuse(attrs, str(path))
    names = needed(attrs)
    groups = chunks.for_figures(path)
    return page(chunks.pieces(path, "trajectory", names), groups, attrs, start, until)


def refuse(attrs: dict[str, Any], what: str) -> None:
    """Raise InputError or StoreError if a run with these root attributes cannot be shown.

    `what` names the run in the message.
    """
    if "content" in attrs:
        raise InputError(f"`{what}` must be a run to be viewed, but is a {attrs['content']}.")
    if attrs["status"] == "running":
        raise StoreError(
            f"`{what}` must be finished to be viewed, but is not: tippetop resume {what}."
        )
    body_of(attrs)
    if not attrs["run"].get("orientation", False):
        raise InputError(
            "a page needs the column `orientation`, but the run has not kept it: set "
            "run.orientation = true."
        )
    if "columns" in attrs["run"]:
        wanted = columns_of(attrs) & {*NEEDED}
        require(sorted(wanted), attrs["run"]["columns"], "a page")


def page(
    pieces: Rows,
    groups: Mapping[str, Any],
    attrs: dict[str, Any],
    start: float | None,
    until: float | None,
) -> str:
    """Return the text of the HTML file of a run; run.js reads the names of its data.

    Parameters
    ----------
    pieces
        Columns of the trajectory by name, in SI units, in the order of time.
    groups
        Tables of the run: `events`, and `phases` and `impacts` where it has them.
    attrs
        The root attributes of its store.
    start, until
        The part that is shown [s]; by default as much from the start as a page can contain.
    """
    times, kept, rough, notes = read(pieces, attrs, start, until)
    notes += moving_axes(attrs)
    if rough > TOO_FAR:
        notes.append(
            "The rows are far apart: between two of them the drawn attitude may be off by "
            f"{rough / DEGREE:.2g}°. "
            "A run with a smaller run.output_step, or a replay with a smaller step, shows more."
        )
    log = _events(groups, times[0], times[-1])
    phases = _phases(groups, times[0], times[-1])
    body = shape(attrs)
    data = {
        "name": attrs["system"],
        "title": capitalised(attrs["title"]),
        "about": units_text(greek(headline_of(attrs).partition(" · ")[2])),
        "notes": notes,
        "body": body,
        "wound": body["kind"] == "cylinder",
        "times": encode(times, "<f8"),
        "samples": encode(kept, "<f4"),
        "events": log,
        "phases": phases,
    }
    system: Any = find(attrs["system"])
    scripts = NO_POTENTIAL if attrs.keys() & TABLES else potential(system, body_of(attrs))
    return pages.page(f"{attrs['title']} · tippetop", "page_run.js", data, scripts)


def read(
    pieces: Rows, attrs: dict[str, Any], start: float | None, until: float | None
) -> tuple[np.ndarray, np.ndarray, float, list[str]]:
    """Return times and samples of a page, the error of the attitude between rows [rad], and notes.

    `film` of the command line reads a run by it too, after `refuse`. Raises InputError if no row is
    within.
    """
    begin = start or 0.0
    end = np.inf if until is None else until
    notes = []
    times = []
    kept = []
    rough = 0.0
    span = 0.0
    for piece in pieces:
        within = (piece["time"] >= begin) & (piece["time"] <= end)
        if not within.any():
            continue
        columns = {name: values[within] for name, values in piece.items()}
        t = columns["time"]
        some = samples(columns, attrs)
        rough = max(rough, spacing.row_error(t, some))
        # from the first row that is shown to the end; not 0, by which the share is divided
        span = span or max(min(end, end_of(attrs)) - t[0], 1e-300)
        # the share of this piece in the samples of a page
        few = spacing.chosen(t, some, max(1, math.ceil(spacing.FEW * np.ptp(t) / span)))
        times.append(t[few])
        kept.append(some[few])
        if sum(map(len, times)) > MOST:
            notes.append(
                f"This is the run up to {t[-1]:.6g} s, as much as a page contains: --from and "
                "--until choose another part."
            )
            break
    if not times:
        raise InputError(
            f"the run must have rows from {begin:g} s{'' if until is None else f' to {end:g} s'} "
            "to be shown, but has none: show another part, or `tippetop replay` one."
        )
    return np.concatenate(times), np.concatenate(kept), rough, notes


def end_of(attrs: dict[str, Any]) -> float:
    """Return the time of the last row of a run [s], from root attributes."""
    return float(attrs["replay"]["until"] if "replay" in attrs else attrs["report"]["t_end"])


def _events(groups: Mapping[str, Any], begin: float, end: float) -> list[dict[str, Any]]:
    """Return the events from `begin` to `end` [s], without insignificant turnings, for JSON.

    `groups` are the tables of the run. page.js reads the names of the records.
    """
    events = groups["events"]
    keep = (events["time"].values >= begin) & (events["time"].values <= end)
    keep &= ~flagged(events["kind"], "turning") | events["significant"].values.astype(bool)
    rows = np.flatnonzero(keep)
    rows = rows[:: max(1, -(-len(rows) // MOST_EVENTS))]
    kinds = flag_words(events["kind"])
    thetas = events["theta"].values[rows].tolist()
    columns = {
        "time": events["time"].values[rows].tolist(),
        "kind": kinds[rows].tolist(),
        "theta": [theta if math.isfinite(theta) else None for theta in thetas],
        "least": (events["theta_dot_sign"].values[rows] > 0).tolist(),
    }
    return _records(columns)


def _phases(groups: Mapping[str, Any], begin: float, end: float) -> list[dict[str, Any]]:
    """Return the phases of the contact from `begin` to `end` [s], for JSON; [] without a table.

    The page reads the names of the records.
    """
    if "phases" not in groups:
        return []
    table = groups["phases"]
    columns = {
        **{name: table[name].values.tolist() for name in ("start", "end")},
        **{name: flag_words(table[name]).tolist() for name in ("phase", "ball") if name in table},
    }
    return [row for row in _records(columns) if row["end"] >= begin and row["start"] <= end]


def _records(columns: dict[str, list]) -> list[dict[str, Any]]:
    """Return the rows of columns of equal length as dicts by name."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
