"""Named columns in SI units, as the store and a Dataset keep them.

`engine.observables` and `runs` make `Column`s; `runs.attributes` makes Datasets of them. Functions
on Datasets read columns of codes (`flag_values`) and prepare tables for other formats.
"""

from __future__ import annotations

import contextlib
import json
import re
import unicodedata
from collections.abc import Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .errors import InputError
from .mechanics.units import Unit


if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


GREEK = {
    "mu": "μ",
    "mu_r": "μᵣ",
    "mu_d": "μ_d",
    "eps": "ε",
    "pi": "π",
    "lambda_s": "λₛ",
    "omega_3": "ω₃",
    "gamma": "γ",
    "lambda": "λ",
    "sigma": "σ",
    "theta": "θ",
}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def greek(text: str) -> str:
    """Write a long_name with the letters of the formulas: `omega_3` is ω₃.

    Short names are whole words.
    """
    names = "|".join(rf"\b{name}\b" if len(name) < 4 else name for name in GREEK)
    return re.sub(names, lambda word: GREEK[word[0]], text)


def capitalised(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


def units_text(units: str) -> str:
    """Write units with superscripts: `kg m2 s-1` is kg m² s⁻¹."""
    return re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power[0].translate(SUPERSCRIPTS), units)


def symbol(tex: str) -> str:
    """Return a symbol in TeX as figures write it: `\\omega_3` as ω₃, others as formulas."""
    if greek := re.fullmatch(r"\\(?:var)?([a-z]+)(?:_(\d))?('*)", tex):
        subscript = chr(ord("₀") + int(greek[2])) if greek[2] else ""
        with contextlib.suppress(KeyError):  # another symbol, such as \\ell
            name = greek[1].replace("lambda", "lamda")
            return unicodedata.lookup(f"GREEK SMALL LETTER {name}") + subscript + greek[3]
    return f"${tex}$" if re.search(r"[\\_]", tex) else tex


Arrays = dict[str, np.ndarray]
"""Arrays by name."""


class Column(NamedTuple):
    """An array with the names of its dimensions and its attributes, as in a store."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, Any]


def column(
    values: np.ndarray, unit: Unit, long_name: str, dims: Any = ("time",), **extra: str
) -> Column:
    """Return values as a column of doubles with its unit and meaning; `extra` are attributes."""
    return Column(
        dims,
        np.asarray(values, dtype=np.float64),
        {"units": unit.symbol, "long_name": long_name, **extra},
    )


def without_rows(columns: dict[str, Column]) -> dict[str, Column]:
    """Return columns of the same names, dimensions and types without a row."""
    return {name: each._replace(values=each.values[:0]) for name, each in columns.items()}


def on_sphere(trajectory: Any) -> np.ndarray:
    """Return at which rows of a run the sphere itself touches the plane, (n,) of bool.

    `trajectory` is a Dataset; without the columns `phase` and `ball` it always touches.
    """
    away = np.zeros(len(trajectory["time"].values), bool)
    for name, words in (("ball", "stem"), ("phase", "flight")):
        away |= flagged(trajectory[name], words) if name in trajectory else away
    return ~away


def flagged(flags: Any, name: str) -> np.ndarray:
    """Return where a column of flags has the meaning `name`, (n,) of bool.

    Nowhere, if the `flag_meanings` among its attributes lack this name.
    """
    meanings = flags.attrs["flag_meanings"].split()
    return np.asarray(flags.values == (meanings.index(name) if name in meanings else -1))


def significant_turnings(events: Any) -> np.ndarray:
    """Select the significant turnings of a table of events, (rows,) of bool."""
    return flagged(events["kind"], "turning") & events["significant"].values.astype(bool)


def counted(numbers: np.ndarray, words: Sequence[str]) -> dict[str, int]:
    """Return how often each word occurs, for words that occur, in the order of `words`.

    `numbers` (n,) are their indices, as in a column of flags.
    """
    counts = np.bincount(numbers, minlength=len(words)).tolist()
    return {word: n for word, n in zip(words, counts, strict=True) if n}


def flag_words(flags: Any) -> np.ndarray:
    """Return the name of each value of flags, with their `flag_meanings`, in their shape."""
    return np.array(flags.attrs["flag_meanings"].split())[flags.values]


def require(names: Iterable[str], kept: Container[Any], subject: str) -> None:
    """Raise InputError if a run does not keep the columns that something needs.

    Parameters
    ----------
    names
        Columns that are needed.
    kept
        Columns of the run.
    subject
        The beginning of the sentence, which they are needed for.
    """
    if missing := ", ".join(f"`{name}`" for name in names if name not in kept):
        raise InputError(
            f"{subject} must have {missing}: add the missing columns to the `columns` of the run."
        )


LETTERS = ("xyz", "wxyz")
"""Dimensions of vectors and of quaternions; their names are their labels."""


def dataframe(table: xr.Dataset) -> pd.DataFrame:
    """Return a table as a pandas DataFrame: words for codes, a column per component of a vector.

    Parameters
    ----------
    table : xarray.Dataset
        A table of a run, an ensemble, a sweep or derivatives.

    Returns
    -------
    pandas.DataFrame
        The index is `time`, or the number of the row; several dimensions form a MultiIndex.

    Examples
    --------
    >>> import tippetop as tt
    >>> print(tt.dataframe(tt.run("flying", until=1.0).phases))
    """
    import xarray as xr

    if not isinstance(table, xr.Dataset):
        raise InputError(f"`table` must be an xarray.Dataset, but is {table!r:.60}.")
    columns: dict[Any, Any] = {}
    for name, variable in table.variables.items():
        letters = next((dim for dim in LETTERS if dim in variable.dims), "")
        if "flag_meanings" in variable.attrs:
            columns[name] = variable.dims, flag_words(variable)
        elif not letters:
            columns[name] = variable
        elif name != letters:
            for i, part in enumerate(letters):
                columns[f"{name}_{part}"] = variable.isel({letters: i})
    return xr.Dataset(columns).to_dataframe()


def with_coordinates(table: xr.Dataset) -> xr.Dataset:
    """Add the coordinates of a table: letters of vectors, time, and kinds of events."""
    labels = {name: (name, list(name)) for name in LETTERS if name in table.dims}
    named = [name for name in ("time", "kind") if name in table and table[name].ndim == 1]
    return table.assign_coords(labels).set_coords(named)


def plain_attributes(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Return attributes as any file can contain them: numbers, texts, and others as JSON texts.

    True and False are JSON texts too; attributes that are None are left out. Readers of a Dataset,
    such as `sweeps.sweep_summary.plan_of`, parse the JSON again.
    """
    return {
        name: value
        if isinstance(value, int | float | str) and not isinstance(value, bool)
        else json.dumps(value)
        for name, value in attrs.items()
        if value is not None
    }


def flag_attributes(names: tuple[str, ...], text: str) -> dict[str, Any]:
    """Return the attributes of a column of codes: the name of each code, and the meaning.

    By the CF conventions names are one text, separated by spaces: a name has none. Stores contain
    codes, so a new name goes to the end.
    """
    return {
        "flag_values": list(range(len(names))),
        "flag_meanings": " ".join(names),
        "long_name": text,
        "units": "1",
    }
