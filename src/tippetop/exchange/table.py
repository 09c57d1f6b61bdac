"""A table of somebody's motion: columns with names and units, from CSV or Parquet, in SI units."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, suggestion


MOST_ROWS = 2_000_000  # what a comparison or a fit holds in memory with all that it computes
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
ANGLES = {"rad": 1.0, "deg": np.pi / 180, "turn": 2 * np.pi}
RATES = {"rad/s": 1.0, "rad s-1": 1.0, "deg/s": np.pi / 180, "deg s-1": np.pi / 180, "rpm": np.pi / 30,
         "1/s": 1.0, "Hz": 2 * np.pi}  # fmt: skip
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
SPEEDS = {"m/s": 1.0, "m s-1": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
PLAIN = {"1": 1.0, "": 1.0}

COLUMNS: dict[str, tuple[dict[str, float], str]] = {
    "t": (TIMES, "time"),
    "theta": (ANGLES, "inclination of the axis"),
    "phi": (ANGLES, "azimuth of the axis"),
    "psi": (ANGLES, "turn of the body about its axis"),
    "theta_dot": (RATES, "rate of theta"),
    "phi_dot": (RATES, "rate of phi"),
    "omega3": (RATES, "angular velocity about the axis"),
    **{f"axis_{c}": (PLAIN, "unit vector along the axis, space frame") for c in "xyz"},
    **{f"q_{c}": (PLAIN, "unit quaternion, body to space") for c in "wxyz"},
    **{f"q_{i}": (PLAIN, "unit quaternion, its order named beside") for i in range(4)},
    **{c: (LENGTHS, "place of the centre of mass") for c in "xyz"},
    **{f"v{c}": (SPEEDS, "velocity of the centre of mass") for c in "xyz"},
    **{f"omega_{c}": (RATES, "angular velocity, space frame") for c in "xyz"},
    **{f"omega_body_{c}": (RATES, "angular velocity, body frame") for c in "xyz"},
    **{f"marker_{c}": (LENGTHS, "place of a marker on the body, space frame") for c in "xyz"},
}
"""Name -> units with their size in SI, and what it is."""
UNSIGNED = {"theta": np.pi}  # angles with bounds


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


def read(path: str | Path) -> Table:
    """The table of a CSV or Parquet file.

    Parameters
    ----------
    path
        A file whose header names each column and its unit: `t [s], theta [deg]`. Empty cells and NaN are gaps.

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
        raise InputError(
            [f"`{path}` must be a CSV or Parquet file, but {'is a folder' if path.is_dir() else 'is not there'}."]
        )
    header, values = _parquet(path) if path.suffix in (".parquet", ".pq") else _csv(path)
    return checked(path, header, values)


def checked(path: Path, header: list[str], values: np.ndarray) -> Table:
    """A table of a header and values (rows, columns). Raises InputError."""
    names, sizes, faults = [], [], []
    for text in header:
        name, size, fault = _column(text)
        names.append(name)
        sizes.append(size)
        faults += [fault] if fault else []
    faults += [
        f"the column `{name}` must stand once, but stands twice." for name in set(names) if names.count(name) > 1
    ]
    if "t" not in names:
        faults.append("the times must be a column `t [s]`, but there is none.")
    if faults:
        raise InputError([f"`{path}`: {sentence}" for sentence in faults])
    columns = {name: values[:, i] * sizes[i] for i, name in enumerate(names)}
    faults = _rows_faults(columns)
    if faults:
        raise InputError([f"`{path}`: {sentence}" for sentence in faults])
    kept = np.any([np.isfinite(v) for name, v in columns.items() if name != "t"], axis=0)
    return Table(path, {name: v[kept] for name, v in columns.items()})


def _column(text: str) -> tuple[str, float, str]:
    """Name, size of the unit and fault of a column, of its header."""
    match = re.fullmatch(r"\s*([A-Za-z_]\w*)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?\s*", text)
    if not match:
        return text, 1.0, f"a header must be a name and a unit such as `theta [deg]`, but has {text!r:.60}."
    name = match[1]
    unit = (match[2] if match[2] is not None else match[3]) or ""
    if name not in COLUMNS:
        known = ", ".join(name for name in COLUMNS if not re.fullmatch(r"q_\d", name))
        return name, 1.0, f"the column `{name}` is not known.{suggestion(name, COLUMNS)} The columns are {known}."
    units, _ = COLUMNS[name]
    if unit.strip() not in units:
        given = f"has `{unit}`" if unit else "has none"
        words = " or ".join(f"[{u}]" for u in units if u)
        return name, 1.0, f"the column `{name}` must have a unit, {words}, but {given}."
    return name, units[unit.strip()], ""


def _rows_faults(columns: dict[str, np.ndarray]) -> list[str]:
    t = columns["t"]
    if len(t) < 2:
        return [f"at least two rows must be there, but {'one is' if len(t) else 'none is'}."]
    if not np.isfinite(t).all():
        row = int(np.flatnonzero(~np.isfinite(t))[0]) + 1
        return [f"every row must have a time, but row {row} has none."]
    if not (np.diff(t) > 0).all():
        row = int(np.flatnonzero(~(np.diff(t) > 0))[0]) + 2
        return [f"times must ascend, but that of row {row}, {t[row - 1]:.9g} s, follows {t[row - 2]:.9g} s."]
    if len(columns) == 1:
        return ["a column beside `t` must be there, but none is."]
    faults = []
    for name, values in columns.items():
        if not np.isfinite(values).any():
            faults.append(f"the column `{name}` must have a number somewhere, but has none.")
        elif np.isinf(values).any():
            faults.append(f"the column `{name}` must be finite where it is given, but is infinite in places.")
        elif name in UNSIGNED and (np.nanmin(values) < -1e-9 or np.nanmax(values) > UNSIGNED[name] * (1 + 1e-9)):
            worst = values[np.nanargmax(np.abs(values - UNSIGNED[name] / 2))]
            faults.append(f"`{name}` must lie in 0 to pi, but is {worst:.6g} rad somewhere: is it in degrees?")
        elif name.startswith("axis_") and np.nanmax(np.abs(values)) > 1.01:
            faults.append(
                f"`{name}` is a component of a unit vector, but is {np.nanmax(np.abs(values)):.4g} somewhere."
            )
    return faults


def _csv(path: Path) -> tuple[list[str], np.ndarray]:
    """Header and values of a CSV file; lines that begin with # are comments."""
    try:
        with path.open("rb") as file:
            lines = sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 22), b""))
        if lines > MOST_ROWS + 1000:
            raise _too_long(path, lines)
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = (row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#"))
            header = [text.strip() for text in next(rows, [])]
            if not header:
                raise InputError([f"`{path}` must begin with a header such as `t [s], theta [deg]`, but is empty."])
            values = np.array([_numbers(path, k, row, len(header)) for k, row in enumerate(rows, 1)])
    except UnicodeDecodeError:
        raise InputError([f"`{path}` must be text in UTF-8, but is not."]) from None
    except csv.Error as error:
        raise InputError([f"`{path}` must be CSV, but: {error}."]) from None
    except OSError as error:
        raise InputError([f"`{path}` cannot be read: {error.strerror or error}."]) from None
    if all(_is_number(text) for text in header):
        raise InputError([f"`{path}` must begin with a header such as `t [s], theta [deg]`, but begins with numbers."])
    return header, values.reshape(-1, len(header))


def _too_long(path: Path, rows: int) -> InputError:
    return InputError([f"`{path}` must have at most {MOST_ROWS:,} rows, but has {rows:,}: keep every tenth or so."])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(path: Path, number: int, row: list[str], width: int) -> list[float]:
    """The numbers of a row; NaN where a cell is empty. Raises InputError."""
    if len(row) != width:
        raise InputError([f"`{path}`: row {number} must have {width} cells as the header has, but has {len(row)}."])
    try:
        return [float(text) if text.strip() else np.nan for text in row]
    except ValueError:
        bad = next(text for text in row if text.strip() and not _is_number(text))
        raise InputError([f"`{path}`: row {number} must have numbers, but has {bad!r:.60}."]) from None


def _parquet(path: Path) -> tuple[list[str], np.ndarray]:
    try:
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError([f"`{path}` must be CSV where pyarrow is not installed (install tippetop[export])."]) from None
    try:
        rows = pq.read_metadata(path).num_rows
        if rows > MOST_ROWS:
            raise _too_long(path, rows)
        table: Any = pq.read_table(path)
        values = [np.asarray(table[name].to_numpy(zero_copy_only=False), float) for name in table.column_names]
    except InputError:
        raise
    except Exception as error:  # the library raises what it likes
        raise InputError(
            [f"`{path}` must be a Parquet file of numbers, but: {' '.join(str(error).split())[:120]}."]
        ) from None
    return list(table.column_names), np.stack(values, axis=1) if values else np.zeros((0, 0))
