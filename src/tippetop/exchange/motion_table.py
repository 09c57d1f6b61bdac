"""Tables of motions from CSV or Parquet: columns with names and units, converted to SI units."""

import csv
import math
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Arrays
from ..errors import InputError
from .headers import heading


# Cells without a number, in any case of letters
GAPS = ("", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-")
# Standard deviations of the noise by which an angle may lie beyond its bounds
BEYOND = 5.0


@dataclass(frozen=True)
class Table:
    """Columns by name, (rows,) each, SI; NaN where a value is missing.

    Parameters
    ----------
    path
        The file.
    columns
        `t` among them, ascending.
    """

    path: Path
    columns: Arrays

    @property
    def t(self) -> np.ndarray:
        """Times [s], (rows,)."""
        return self.columns["t"]

    def has(self, *names: str) -> bool:
        """Return whether all of these columns are there."""
        return all(name in self.columns for name in names)


def read(
    path: str | Path, *, wrapped: bool = True, noise: float | None = None, gaps: bool = True
) -> Table:
    """Read the table of a CSV or Parquet file.

    Parameters
    ----------
    path
        A file whose header names each column and its unit: `t [s], theta [deg]`, or a run that
        tippetop exported. Empty cells and the other `GAPS` are gaps.
    wrapped
        Whether theta must lie in 0 to pi, as the inclination of an axis does.
    noise
        Standard deviation of theta [rad], which may take it beyond; None if unknown.
    gaps
        Whether cells may be gaps.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If it is not such a table.
    """
    path = Path(path)
    allowed = GAPS if gaps else ()
    try:
        (_, header), *rows = _cells(path).items()
        found = heading(header)
        for place, row in rows:
            if len(row) != len(header):
                raise InputError(
                    f"{place} must have {len(header)} cells, as the header has, but has {len(row)}."
                )
        columns = {
            name: np.array([_number(row[at], place, name, allowed) for place, row in rows]) * size
            for name, (at, size) in found.items()
        }
        _check(columns, wrapped, noise)
    except InputError as error:
        raise InputError([f"`{path}`: {sentence}" for sentence in error.sentences]) from None
    kept = np.any([np.isfinite(v) for name, v in columns.items() if name != "t"], axis=0)
    if kept.sum() < 2:
        raise InputError(
            f"`{path}`: two rows must have a time and another number, but {kept.sum()} has."
        )
    return Table(path, {name: v[kept] for name, v in columns.items()})


def _cells(path: Path) -> dict[str, list]:
    """Return the cells of each row of a file by its place, the header first.

    Empty lines of a CSV file, and those that begin with #, are left out. Raises InputError.
    """
    try:
        if path.suffix in (".parquet", ".pq"):
            import pandas as pd

            frame = pd.read_parquet(path)
            cells = frame.astype(object).where(frame.notna(), "").to_numpy().tolist()
            rows = {f"row {n}": row for n, row in enumerate(cells, 1)}
            return {"header": [*map(str, frame.columns)], **rows}
        lines = path.read_text(encoding="utf-8-sig").split("\n")
        kept = [n for n, line in enumerate(lines) if line.strip() and not _is_comment(line)]
        reader = csv.reader((lines[n] for n in kept), skipinitialspace=True)
        if found := {f"line {kept[reader.line_num - 1] + 1}": row for row in reader}:
            return found
        words = "it is empty"
    except OSError as error:
        words = error.strerror or str(error)
    except UnicodeDecodeError as error:
        words = f"byte {error.start + 1} is not UTF-8 (save it as CSV in UTF-8)"
    except Exception as error:  # pyarrow raises exceptions of many kinds
        words = " ".join(str(error).split())[:120]
    raise InputError(f"the file must be a table in CSV or Parquet, but: {words}.")


def _number(cell: Any, place: str, name: str, gaps: Collection[str]) -> float:
    """Return the number of a cell, NaN in a gap. Raises InputError."""
    text = str(cell).strip()
    with suppress(ValueError):
        if math.isfinite(number := float(text)) and "_" not in text:
            return number
    if text.lower() in gaps:
        return math.nan
    raise InputError(
        f"{place}, column `{name}`: a cell must be a number"
        f"{' or a gap (empty, NaN, NA or -)' if gaps else ''}, but is {text!r:.60}."
    )


def _check(columns: Arrays, wrapped: bool, noise: float | None) -> None:
    """Raise InputError for columns that are not those of a motion."""
    t = columns["t"]
    if not (rises := np.diff(t) > 0).all():
        row = rises.argmin() + 1
        raise InputError(
            f"times must ascend, but that of row {row + 1}, {t[row]:.9g} s, follows "
            f"{t[row - 1]:.9g} s."
        )
    for name, values in columns.items():
        if not np.isfinite(values).any():
            raise InputError(f"the column `{name}` must have finite numbers, but has not.")
    if wrapped and "theta" in columns:
        theta = columns["theta"]
        beyond = np.nan_to_num(np.abs(theta - np.pi / 2) - np.pi / 2)
        row = beyond.argmax()
        if beyond[row] > BEYOND * (noise or 0.0) + 1e-9:
            hint = "" if noise is None else ": noise may explain it (--noise)"
            raise InputError(
                f"`theta` must lie in 0 to pi, but is {theta[row]:.6g} rad "
                f"({np.rad2deg(theta[row]):.6g} deg) in row {row + 1}{hint}."
            )


def _is_comment(line: str) -> bool:
    """Return whether a line begins with `#`, and not with a gap such as `#N/A`."""
    first = line.partition(",")[0].strip()
    return first.startswith("#") and first.lower() not in GAPS
