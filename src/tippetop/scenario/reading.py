"""TOML text becomes tables: files, presets, and `--set` assignments."""

import copy
import math
import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from ..errors import InputError, suggestion
from .law_change import change_law


OUTPUT = ("output", "output_step", "output_times")  # one of them decides when there are rows
QUANTITY = (
    r"[-+0-9.eE/*^()]+ *[^\W\d_°%][^\"'\[\]{}=,#]*|[-+0-9.]+ *[°%]|[-+\w.(]+( "
    r"*[-+*/^()]+ *[-+\w.()]+)+\)*"
)
"""Texts that need no quotes after `--set key=` though they are not TOML: 20 g, 3/10, 2/5*m*R^2."""


def presets() -> dict[str, str]:
    """Return the built-in scenarios.

    Returns
    -------
    dict of str
        The TOML text of each, by name. `run(name)` and `load(name)` take the name.

    Examples
    --------
    >>> import tippetop as tt
    >>> sorted(tt.presets())
    >>> print(tt.presets()["inverting"])
    """
    return dict(_presets())


@cache
def _presets() -> dict[str, str]:
    folder = files("tippetop") / "scenario" / "presets"
    names = sorted(p.name.removesuffix(".toml") for p in folder.iterdir())
    return {name: (folder / f"{name}.toml").read_text(encoding="utf-8") for name in names}


@cache
def _preset(name: str) -> dict[str, Any]:
    return tomllib.loads(_presets()[name])


def read(source: str) -> dict[str, Any]:
    """Return the tables of a TOML file or of a preset. Raises InputError."""
    path = Path(source)
    try:
        if path.suffix != ".toml" and not path.is_file():
            known = _presets()
            if source not in known:
                raise InputError(
                    f"`{source}` is neither a TOML file nor a preset.{suggestion(source, known)} "
                    f"The presets are {', '.join(known)}."
                )
            return copy.deepcopy(_preset(source))
        return _parsed(path.read_text(encoding="utf-8-sig"))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"`{source}` cannot be read: {error.strerror or error}.") from None
    except ValueError as error:
        raise InputError(f"`{source}` is not valid TOML in UTF-8: {error}.") from None


def _parsed(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text. Raises ValueError."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("tables or lists are nested too deeply") from None


def override(tables: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """Return the tables with `table.key=value` assignments; values are TOML, or bare words.

    Nothing after the `=` removes the key or the table: `friction=`, `run.output_step=`. A key that
    decides when there are rows replaces such other keys, and `initial.from` replaces the start.
    Raises InputError.
    """
    words = [
        (key.strip(), text.strip()) for key, _, text in (a.partition("=") for a in assignments)
    ]
    changed = {k: dict(v) if isinstance(v, dict) else v for k, v in tables.items()}
    if isinstance(changed.get("run"), dict):
        given = {key.removeprefix("run."): text.strip("\"'") for key, text in words}
        changed["run"] = without_output(changed["run"], given)
    if any(key == "initial.from" and text for key, text in words):
        changed["initial"] = {}
    for assignment, (key, text) in zip(assignments, words, strict=True):
        place, _, name = key.rpartition(".")
        if "=" not in assignment or not re.fullmatch(r"(\w[\w-]*\.)?\w[\w-]*", key):
            raise InputError(f"--set must be table.key=value, but is `{_short(assignment)}`.")
        table: Any = changed
        if place:
            table = changed.setdefault(place, {}) if text else changed.get(place)
        if not text:
            _remove(table, key, name)
        elif not isinstance(table, dict):
            raise InputError(
                f"--set {key} must name a key of a table, but `{place}` is not a table."
            )
        else:
            table[name] = _value(key, text)
    change_law(tables, changed, [key.removeprefix("friction.") for key, _ in words])
    return changed


def _value(key: str, text: str) -> Any:
    """Return the value of an assignment: TOML, a bare word, or a quantity. Raises InputError."""
    if re.fullmatch(r"(?!(true|false|nan|inf)$)[A-Za-z][\w-]*", text):
        return text
    try:
        return _parsed(f"value = {text}")["value"]
    except ValueError:
        if key == "initial.from" or re.fullmatch(QUANTITY, text):  # a path needs no quotes
            return text
        raise InputError(
            f'--set {key} must be given a TOML value (5, 0.3, true, "word", [1.0, 2.0]), but is '
            f"`{_short(text)}`."
        ) from None


def _remove(table: Any, key: str, name: str) -> None:
    """Remove a key of a table, or a table. Raises InputError if it is not there."""
    if not isinstance(table, dict) or name not in table:
        present = ", ".join(table) if isinstance(table, dict) and table else "none"
        raise InputError(
            f"--set {key}= removes a key that is given, but `{key}` is not: the keys are {present}."
        )
    del table[name]


def without_output(run: dict[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table [run] without the times of its rows, where `given` decides them anew."""
    if not any(name in OUTPUT and (name, given[name]) != ("output", "times") for name in given):
        return run
    return {
        key: value
        for key, value in run.items()
        if key in given or key not in (*OUTPUT, "keyframe_steps")
    }


def times_until(times: list[Any], until: Any) -> list[Any]:
    """Return output times up to another end.

    A list that does not ascend, or has other values than numbers, is returned for the check to
    refuse.
    """
    numbers = all(isinstance(t, int | float) and math.isfinite(t) for t in times)
    if not numbers or any(b <= a for a, b in pairwise(times)):
        return times
    return [t for t in times if t <= until]


def _short(text: str) -> str:
    """Return the text, cut to the length of a sentence."""
    return text if len(text) <= 80 else f"{text[:77]}..."
