"""Tables of motions from CSV or Parquet: columns with names and units, converted to SI units."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from .headers import heading


if TYPE_CHECKING:
    import pandas as pd


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
    columns: dict[str, np.ndarray]

    @property
    def t(self) -> np.ndarray:
        """Times [s], (rows,)."""
        return self.columns["t"]

    def has(self, *names: str) -> bool:
        """Return whether all of these columns are there."""
        return all(name in self.columns for name in names)

    def stacked(self, *names: str) -> np.ndarray:
        """Return several columns as an array (rows, columns)."""
        return np.stack([self.columns[name] for name in names], axis=1)


def read(
    path: str | Path, *, wrapped: bool = True, noise: float | None = None, gaps: bool = True
) -> Table:
    """Read the table of a CSV or Parquet file.

    Parameters
    ----------
    path
        A file whose header names each column and its unit: `t [s], theta [deg]`, or a run that
        tippetop exported. Empty cells and NaN are gaps.
    wrapped
        Whether theta must lie in 0 to pi, as the inclination of an axis does.
    noise
        Standard deviation of theta [rad], which may take it beyond; None if unknown.
    gaps
        Whether cells may be empty or NaN.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If it is not such a table.
    """
    import pandas as pd

    path = Path(path)
    try:
        if path.suffix in (".parquet", ".pq"):
            frame = pd.read_parquet(path)
        else:
            with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):
                frame = pd.read_csv(
                    path,
                    comment="#",
                    skipinitialspace=True,
                    encoding="utf-8-sig",
                    index_col=False,
                    low_memory=False,
                )
    except OSError as error:
        raise InputError(f"`{path}` cannot be read: {error.strerror or error}.") from None
    except Exception as error:  # pyarrow raises exceptions of many kinds
        words = " ".join(str(error).split())[:120]
        raise InputError(f"`{path}` must be a table in CSV or Parquet, but: {words}.") from None
    try:
        columns = {
            name: _numbers(frame.iloc[:, place]) * size
            for name, (place, size) in heading(list(map(str, frame.columns))).items()
        }
        _check(columns, wrapped, noise)
        if not gaps:
            _check_complete(columns)
    except InputError as error:
        raise InputError([f"`{path}`: {sentence}" for sentence in error.sentences]) from None
    kept = np.any([np.isfinite(v) for name, v in columns.items() if name != "t"], axis=0)
    if kept.sum() < 2:
        raise InputError(
            f"`{path}`: two rows must have a time and another number, but {kept.sum()} has."
        )
    return Table(path, {name: v[kept] for name, v in columns.items()})


def _numbers(column: "pd.Series") -> np.ndarray:
    """Return the numbers of a column; NaN in empty cells. Raises InputError."""
    import pandas as pd

    values = pd.to_numeric(column, errors="coerce")
    if (wrong := (values.isna() & column.notna()).to_numpy()).any():
        row = int(wrong.argmax())
        raise InputError(f"row {row + 1} must have numbers, but has {column.iloc[row]!r:.60}.")
    return values.to_numpy(float)


def _check_complete(columns: dict[str, np.ndarray]) -> None:
    """Raise InputError for the first cell that is empty or NaN."""
    for name, values in columns.items():
        if (lacks := np.isnan(values)).any():
            row = int(lacks.argmax()) + 1
            raise InputError(
                f"every cell must be a number, but `{name}` is missing or NaN in row {row}."
            )


def _check(columns: dict[str, np.ndarray], wrapped: bool, noise: float | None) -> None:
    """Raise InputError for columns that are not those of a motion."""
    t = columns["t"]
    if not (rises := np.diff(t) > 0).all():
        row = rises.argmin() + 1
        raise InputError(
            f"times must ascend, but that of row {row + 1}, {t[row]:.9g} s, follows "
            f"{t[row - 1]:.9g} s."
        )
    for name, values in columns.items():
        if not np.isfinite(values).any() or np.isinf(values).any():
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
