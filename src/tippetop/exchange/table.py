"""A table of somebody's motion: columns with names and units, from CSV or Parquet, in SI units."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..problem.one import UNTIL
from .headers import Heading, heading


MOST_ROWS = 2_000_000  # what a comparison or a fit holds in memory with all that it computes
# Standard deviations of the noise by which an angle may lie beyond its bounds
BEYOND = 5.0


@dataclass(frozen=True)
class Table:
    """Columns by name, (rows,) each, SI; NaN where a value is missing.

    Parameters
    ----------
    path
        Where it was read.
    columns
        `t` among them, ascending.
    """

    path: Path
    columns: dict[str, np.ndarray]

    @property
    def t(self) -> np.ndarray:
        """Times [s], (rows,)."""
        return self.columns["t"]

    def has(self, *names: str) -> bool:
        """Whether all of these columns are there."""
        return all(name in self.columns for name in names)

    def stacked(self, *names: str) -> np.ndarray:
        """Columns side by side, (rows, columns)."""
        return np.stack([self.columns[name] for name in names], axis=1)


def read(
    path: str | Path, *, wrapped: bool = True, noise: float | None = None, gaps: bool = True
) -> Table:
    """The table of a CSV or Parquet file.

    Parameters
    ----------
    path
        A file whose header names each column and its unit: `t [s], theta [deg]`, or a run that
        tippetop exported. Empty cells and NaN are gaps.
    wrapped
        Whether theta must lie in 0 to pi, as the inclination of an axis does.
    noise
        Standard deviation of theta [rad], which may take it beyond; None: there is none.
    gaps
        Whether cells may be empty or NaN.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        With a sentence for what is wrong.
    """
    path = Path(path)
    if not path.is_file():
        kind = (
            "is a folder"
            if path.is_dir()
            else "is no plain file"
            if path.exists()
            else "is not there"
        )
        raise InputError([f"`{path}` must be a CSV or Parquet file, but {kind}."])
    names, values = _parquet(path) if path.suffix in (".parquet", ".pq") else _csv(path)
    columns = dict(zip(names, values.T, strict=True))
    faults = _rows_faults(columns, wrapped, noise) or ([] if gaps else _gap_faults(columns))
    if faults:
        raise InputError([f"`{path}`: {sentence}" for sentence in faults])
    kept = np.any([np.isfinite(v) for name, v in columns.items() if name != "t"], axis=0)
    return Table(path, {name: v[kept] for name, v in columns.items()})


def _heading(path: Path, header: list[str]) -> Heading:
    """What is read of a file with this header. Raises InputError."""
    columns = heading(header)
    if columns.faults:
        raise InputError([f"`{path}`: {sentence}" for sentence in columns.faults])
    return columns


def _rows_faults(columns: dict[str, np.ndarray], wrapped: bool, noise: float | None) -> list[str]:
    t = columns["t"]
    if len(t) < 2:
        return [f"at least two rows must be there, but {'one is' if len(t) else 'none is'}."]
    if (lacks := ~np.isfinite(t)).any():
        return [f"every row must have a time, but row {lacks.argmax() + 1} has none."]
    if (falls := np.diff(t) <= 0).any():
        row = falls.argmax() + 2
        return [
            f"times must ascend, but that of row {row}, {t[row - 1]:.9g} s, follows "
            f"{t[row - 2]:.9g} s."
        ]
    if max(-t[0], t[-1]) > UNTIL.most:
        return [f"times must be within {UNTIL.most:g} s, but are from {t[0]:g} to {t[-1]:g} s."]
    if len(columns) == 1:
        return ["a column beside `t` must be there, but none is."]
    faults = []
    for name, values in columns.items():
        if not np.isfinite(values).any():
            faults.append(f"the column `{name}` must have a number somewhere, but has none.")
        elif np.isinf(values).any():
            faults.append(
                f"the column `{name}` must be finite where it is given, but is infinite in places."
            )
        elif (
            wrapped
            and name == "theta"
            and (beyond := _beyond(values)).max() > BEYOND * (noise or 0.0) + 1e-9
        ):
            worst = int(np.argmax(beyond))
            value = (
                f"{values[worst]:.6g} rad ({np.rad2deg(values[worst]):.6g} deg) in row {worst + 1}"
            )
            hint = "."
            if values[worst] > 2 * np.pi:
                hint = ": is it in degrees?"
            elif noise == 0:
                hint = ': noise that explains it must be stated (--noise "1 deg").'
            elif noise is not None:
                hint = f": a noise of {np.rad2deg(noise):.3g} deg (--noise) does not explain it."
            faults.append(f"`{name}` must lie in 0 to pi, but is {value}{hint}")
        elif name.startswith("axis_") and (most := np.nanmax(np.abs(values))) > 1.01:
            faults.append(f"`{name}` is a component of a unit vector, but is {most:.4g} somewhere.")
    return faults


def _gap_faults(columns: dict[str, np.ndarray]) -> list[str]:
    """Return a sentence about the first cell that is empty or NaN."""
    for name, values in columns.items():
        if (lacks := np.isnan(values)).any():
            return [
                f"every cell must be a number, but `{name}` is missing or NaN in row "
                f"{lacks.argmax() + 1}."
            ]
    return []


def _beyond(theta: np.ndarray) -> np.ndarray:
    """Return how far theta is beyond 0 to pi."""
    return np.nan_to_num(np.abs(theta - np.pi / 2) - np.pi / 2)


def _csv(path: Path) -> tuple[Sequence[str], np.ndarray]:
    """Names of the columns and values (rows, columns), SI, of a CSV file; lines that begin with #
    are comments.
    """
    try:
        with path.open("rb") as file:
            lines = sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 22), b""))
        if lines > MOST_ROWS + 1000:
            raise _too_long(path, lines)
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = (row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#"))
            header = [text.strip() for text in next(rows, [])]
            if not header:
                raise InputError(
                    [
                        f"`{path}` must begin with a header such as `t [s], theta [deg]`, but "
                        "is empty."
                    ]
                )
            if all(_is_number(text) for text in header):
                raise InputError(
                    [
                        f"`{path}` must begin with a header such as `t [s], theta [deg]`, but "
                        "begins with numbers."
                    ]
                )
            for letter, words in (
                (";", " (and points in its numbers), not `;`."),
                ("\t", ", not tabs."),
            ):
                if len(header) == 1 and letter in header[0]:
                    raise InputError([f"`{path}` must have commas between columns{words}"])
            read = _heading(path, header)
            width, places = len(header), read.places
            values = np.array(
                [_numbers(path, k, row, width, places) for k, row in enumerate(rows, 1)]
            )
    except UnicodeDecodeError:
        raise InputError([f"`{path}` must be text in UTF-8, but is not."]) from None
    except csv.Error as error:
        raise InputError([f"`{path}` must be CSV, but: {error}."]) from None
    except OSError as error:
        raise InputError([f"`{path}` cannot be read: {error.strerror or error}."]) from None
    return read.names, values.reshape(-1, len(places)) * read.sizes


def _too_long(path: Path, rows: int) -> InputError:
    return InputError(
        [
            f"`{path}` must have at most {MOST_ROWS:,} rows, but has {rows:,}: keep every tenth "
            "or so."
        ]
    )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(
    path: Path, number: int, row: list[str], width: int, places: Sequence[int]
) -> list[float]:
    """The numbers of a row at some places; NaN where a cell is empty. Raises InputError."""
    if len(row) != width:
        raise InputError(
            [
                f"`{path}`: row {number} must have {width} cells as the header has, but has "
                f"{len(row)}."
            ]
        )
    cells = [row[i] for i in places]
    try:
        return [float(text) if text.strip() else np.nan for text in cells]
    except ValueError:
        bad = next(text for text in cells if text.strip() and not _is_number(text))
        raise InputError(
            [f"`{path}`: row {number} must have numbers, but has {bad!r:.60}."]
        ) from None


def _parquet(path: Path) -> tuple[Sequence[str], np.ndarray]:
    """As `_csv`, of a Parquet file."""
    try:
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError(
            [f"`{path}` must be CSV where pyarrow is not installed (install tippetop[export])."]
        ) from None
    try:
        rows = pq.read_metadata(path).num_rows
        if rows > MOST_ROWS:
            raise _too_long(path, rows)
        header = list(pq.read_schema(path).names)
        read = _heading(path, header)
        table: Any = pq.read_table(path, columns=[header[i] for i in read.places])
        values = [
            np.asarray(column.to_numpy(zero_copy_only=False), float) for column in table.columns
        ]
    except InputError:
        raise
    except Exception as error:  # the library raises what it likes
        raise InputError(
            [
                f"`{path}` must be a Parquet file of numbers, but: "
                f"{' '.join(str(error).split())[:120]}."
            ]
        ) from None
    return read.names, np.stack(values, axis=1) * read.sizes
