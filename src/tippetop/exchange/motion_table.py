"""Tables of motions from CSV or Parquet: columns with names and units, converted to SI units.

A file goes in; `read` returns a `Table`, whose columns `motion` converts to our conventions.
"""

import codecs
import csv
import math
import re
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Arrays
from ..errors import InputError
from .headers import heading, parsed


# Cells without a number, in any case of letters
GAPS = ("", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-")
# Standard deviations of the noise by which an angle may lie beyond its bounds, "five" in the
# docstring of `library.exchanging.fit`
BEYOND = 5.0
# Rows among which the header is, after titles
TITLES = 20
# First cell of Tracker's line of objects: alone, with the names on the next line, ",A,,B,"; or
# before one name per column, "#multi:\tA\tA\tB", and then one cell more than there are columns
MULTI = "#multi:"
# The time in a line of units
UNIT_CELL = re.compile(r"\s*[\[(]?(s|sec|ms|us|µs|min|h)[\])]?\s*")
# A number whose commas may separate thousands
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")


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
    path: str | Path,
    *,
    wrapped: bool = True,
    noise: float | None = None,
    gaps: bool = True,
    track: str | None = None,
) -> Table:
    """Read the table of a CSV or Parquet file.

    Parameters
    ----------
    path
        A file whose header names each column and its unit: `t [s], theta [deg]`, or a run that
        tippetop exported. A CSV file may be separated by commas, semicolons or tabs, have decimal
        commas, titles before its header and units in the line after it. Empty cells and the other
        `GAPS` are gaps.
    wrapped
        Whether theta must lie in 0 to pi, as the inclination of an axis does.
    noise
        Standard deviation of theta [rad], which may take it beyond; 0 if unknown, None where the
        caller has no such option, which a message would name.
    gaps
        Whether cells may be gaps; `benchmark.score` allows none.
    track
        The object whose columns are read, by its name in the line before the header.

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
        above, (_, header), *rows = _cells(path)
        for place, row in rows:
            if len(row) != len(header):
                raise InputError(
                    f"{place} must have {len(header)} cells, as the header has, but has "
                    f"{len(row)}: decimal commas must be separated by semicolons or tabs."
                )
        kept = _track(above, header, track)
        header = [header[n] for n in kept]
        rows = [(place, [row[n] for n in kept]) for place, row in rows]
        time = _time(header)
        if rows and time is not None and UNIT_CELL.fullmatch(str(rows[0][1][time])):
            units = [cell.strip(" []()") for cell in rows.pop(0)[1]]
            named = zip(header, units, strict=True)
            header = [f"{text} [{unit}]" if unit else text for text, unit in named]
        found = heading(header)
        comma = _has_decimal_commas([str(row[at]) for _, row in rows for at, _ in found.values()])
        columns = {
            name: np.array([_number(row[at], place, name, allowed, comma) for place, row in rows])
            * size
            for name, (at, size) in found.items()
        }
        _check(columns, wrapped, noise)
    except InputError as error:
        raise InputError([f"`{path}`: {sentence}" for sentence in error.sentences]) from None
    known = np.any([np.isfinite(v) for name, v in columns.items() if name != "t"], axis=0)
    if known.sum() < 2:
        raise InputError(
            f"`{path}`: two rows must have a time and another number, but {known.sum()} has."
        )
    return Table(path, {name: v[known] for name, v in columns.items()})


def _cells(path: Path) -> list[Any]:
    """Return the cells before the header, then the header and each row as (place, cells).

    A place is text for messages, such as "line 3". The first element is [] where no row is before
    the header. Empty rows of a CSV file, and lines that begin with #, are left out. Raises
    InputError.
    """
    try:
        if path.suffix in (".parquet", ".pq"):
            import pandas as pd

            frame = pd.read_parquet(path)
            cells = frame.astype(object).where(frame.notna(), "").to_numpy().tolist()
            rows = [(f"row {n}", row) for n, row in enumerate(cells, 1)]
            return [[], ("header", [*map(str, frame.columns)]), *rows]
        lines = _text(path).split("\n")
        if found := _cells_of_lines(lines):
            return found
        words = "it is empty"
    except OSError as error:
        words = error.strerror or str(error)
    except UnicodeDecodeError as error:
        words = f"byte {error.start + 1} is not UTF-8 (save it as CSV in UTF-8)"
    except Exception as error:  # pyarrow raises exceptions of many kinds
        words = " ".join(str(error).split())[:120]
    raise InputError(f"the file must be a table in CSV or Parquet, but: {words}.")


def _text(path: Path) -> str:
    """Return the text of a file in UTF-8, in UTF-16 with its mark, or in Windows-1252.

    Raises ValueError for a file that is not text; `_cells` makes an InputError of it.
    """
    data = path.read_bytes()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    if b"\0" in data:
        raise ValueError("it is not a text (save it as CSV in UTF-8)")
    with suppress(UnicodeDecodeError):
        return data.decode("utf-8-sig")
    return data.decode("cp1252")


def _cells_of_lines(lines: list[str]) -> list[Any]:
    """Return the cells of lines as `_cells` does, by the separator that finds a time in a header.

    By default the header is the first line, by the separator that gives it most cells. [] if all
    lines are empty.
    """
    kept = [n for n, line in enumerate(lines) if line.strip() and not _is_comment(line)]
    first: list[Any] = []
    for separator in ",;\t":
        reader = csv.reader(
            (lines[n] for n in kept), delimiter=separator, skipinitialspace=separator != "\t"
        )
        rows = [
            (f"line {kept[reader.line_num - 1] + 1}", row)
            for row in reader
            if any(map(str.strip, row))
        ]
        for n, (_, row) in enumerate(rows[:TITLES]):
            if _time(row) is not None:
                return [rows[n - 1][1] if n else [], *rows[n:]]
        if rows and (not first or len(rows[0][1]) > len(first[1][1])):
            first = [[], *rows]
    return first


def _time(header: list[str]) -> int | None:
    """Return the index of the time in the cells of a header; None if it has none."""
    return next((n for n, text in enumerate(header) if parsed(text)[0] == "t"), None)


def _track(above: list[str], header: list[str], track: str | None) -> list[int]:
    """Return the places of the columns of an object, named in the row before the header.

    A name is valid for the columns after it too; columns without a name, such as the time, belong
    to every object. None: all columns. Raises InputError.
    """
    if track is None:
        return [*range(len(header))]
    names = [name.strip() for name in above if name.strip() != MULTI]
    names += [""] * (len(header) - len(names))
    for n in range(1, len(names)):
        names[n] = names[n] or names[n - 1]
    if track not in names:
        known = ", ".join(dict.fromkeys(filter(None, names)))
        raise InputError(f"`track` must be an object of the table ({known}), but is {track}.")
    return [n for n in range(len(header)) if names[n] in ("", track)]


def _has_decimal_commas(cells: list[str]) -> bool:
    """Return whether commas in these cells are decimal.

    They are if no cell has a point, and one is not like 1,000.
    """
    commas = [cell for cell in cells if "," in cell]
    thousands = all(THOUSANDS.fullmatch(cell.strip()) for cell in commas)
    return not thousands and not any("." in cell for cell in cells)


def _number(cell: Any, place: str, name: str, gaps: Collection[str], comma: bool) -> float:
    """Return the number of a cell, NaN in a gap. Raises InputError.

    `gaps` are texts of gaps; `comma`: whether commas are decimal, in all cells of the table.
    """
    text = str(cell).strip()
    with suppress(ValueError):
        number = float(text.replace(",", ".") if comma else text)
        if math.isfinite(number) and "_" not in text:
            return number
    if text.lower() in gaps:
        return math.nan
    raise InputError(
        f"{place}, column `{name}`: a cell must be a number"
        f"{' or a gap (empty, NaN, NA or -)' if gaps else ''}, but is {text!r:.60}"
        f"{': write a decimal point' if ',' in text else ''}."
    )


def _check(columns: Arrays, wrapped: bool, noise: float | None) -> None:
    """Raise InputError for columns that are not those of a motion; see `read` for the others.

    Later modules rely on times that ascend and are given in every row.
    """
    t = columns["t"]
    if np.isnan(t).any():
        raise InputError(
            f"every row must have a time, but row {np.isnan(t).argmax() + 1} has a gap there: "
            "remove the row, or write its time."
        )
    if not (rises := np.diff(t) > 0).all():
        row = rises.argmin() + 1
        raise InputError(
            f"times must ascend, but that of row {row + 1}, {t[row]:.9g} s, follows "
            f"{t[row - 1]:.9g} s: sort the rows, and keep one of each time."
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
    first = re.split(r"[,;\t]", line)[0].strip()
    return first.startswith("#") and first.lower() not in (*GAPS, MULTI)
