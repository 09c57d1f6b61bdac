"""TOML text becomes tables: files, presets, and `--set` assignments."""

import math
import pickle
import re
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from ..errors import InputError, suggestion
from .law_change import change_law


OUTPUT = ("output", "output_step", "output_times")  # one of them says when rows are wanted
QUANTITY = (
    r"[-+0-9.eE/*^()]+ *[^\W\d_°%][^\"'\[\]{}=,#]*|[-+0-9.]+ *[°%]|[-+\w.(]+( "
    r"*[-+*/^()]+ *[-+\w.()]+)+\)*"
)
"""What may stand without quotes after `--set key=`, and is no TOML: 20 g, 3/10, 2/5*m*R^2."""


# --- reading ------------------------------------------------------------------------------------


def presets() -> dict[str, str]:
    """The built-in scenarios.

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


@lru_cache(maxsize=1)
def _presets() -> dict[str, str]:
    folder = files("tippetop") / "scenario" / "presets"
    named = {p.name.removesuffix(".toml"): p for p in folder.iterdir() if p.name.endswith(".toml")}
    return {name: named[name].read_text(encoding="utf-8") for name in sorted(named)}


@lru_cache(maxsize=64)
def _preset(name: str) -> bytes:
    """The tables of a preset, pickled: it is faster to read than the text, or to copy."""
    return pickle.dumps(tomllib.loads(_presets()[name]))


def read(source: str) -> dict[str, Any]:
    """The tables of a TOML file or of a preset. Raises InputError."""
    path = Path(source)
    try:
        if path.suffix != ".toml" and not path.is_file():
            known = _presets()
            if source not in known:
                raise InputError(
                    f"`{source}` is neither a TOML file nor a preset.{suggestion(source, known)} "
                    f"The presets are {', '.join(known)}."
                )
            return pickle.loads(_preset(source))
        return _parsed(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        if isinstance(error, OSError):
            raise InputError(f"`{source}` cannot be read: {error.strerror or error}.") from None
        raise InputError(f"`{source}` is not valid TOML in UTF-8: {error}.") from None


def _parsed(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text. Raises ValueError."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("tables or lists are nested too deeply") from None


def override(tables: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """The tables with `table.key=value` assignments applied; values are TOML, a bare word is a
    string.

    Nothing after the `=` removes the key or the table: `friction=`, `run.output_step=`. A key that
    says when rows are wanted takes the place of another such key, and `initial.from` that of the
    start. Raises InputError.
    """
    words = [
        (key.strip(), text.strip()) for key, _, text in (a.partition("=") for a in assignments)
    ]
    given = {
        key.removeprefix("run."): text.strip("\"'") for key, text in words if key.startswith("run.")
    }
    if isinstance(tables.get("run"), dict):
        tables = tables | {"run": without_output(tables["run"], given)}
    if any(key == "initial.from" and text.strip() for key, text in words) and isinstance(
        tables.get("initial"), dict
    ):
        tables = tables | {"initial": {}}
    changed = {k: dict(v) if isinstance(v, dict) else v for k, v in tables.items()}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        parts = key.strip().split(".")
        if not equals or not all(re.fullmatch(r"\w[\w-]*", p) for p in parts) or len(parts) > 2:
            raise InputError(f"--set must be table.key=value, but is `{_short(assignment)}`.")
        if not text.strip():
            _remove(changed, key.strip(), parts)
            continue
        word = re.fullmatch(r"[A-Za-z][\w-]*", text.strip()) and text.strip() not in (
            "true",
            "false",
            "nan",
            "inf",
        )
        try:
            value = text.strip() if word else _parsed(f"value = {text}")["value"]
        except ValueError:
            if key.strip() != "initial.from" and not re.fullmatch(
                QUANTITY, text.strip()
            ):  # a path needs no quotes
                raise InputError(
                    f'--set {key} must be given a TOML value (5, 0.3, true, "word", [1.0, 2.0]), '
                    f"but is `{_short(text)}`."
                ) from None
            value = text.strip()
        table = changed.setdefault(parts[0], {}) if len(parts) == 2 else changed
        if not isinstance(table, dict):
            raise InputError(
                f"--set {key} must name a key of a table, but `{parts[0]}` is not a table."
            )
        table[parts[-1]] = value
    change_law(tables, changed, [key.removeprefix("friction.") for key, _ in words])
    return changed


def without_output(run: dict[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """A table `run` without what says when rows are wanted, where what is `given` anew says so."""
    if not any(name in OUTPUT and (name, given[name]) != ("output", "times") for name in given):
        return run
    return {
        key: value
        for key, value in run.items()
        if key in given or key not in (*OUTPUT, "keyframe_steps")
    }


def times_until(times: list[Any], until: Any) -> list[Any]:
    """Output times up to another end.

    What is no ascending list of numbers stays, for the check to say so.
    """
    numbers = all(isinstance(t, int | float) and math.isfinite(t) for t in times)
    if not numbers or any(b <= a for a, b in pairwise(times)):
        return times
    return [t for t in times if t <= until]


def _short(text: str) -> str:
    """The text as a sentence can hold it."""
    return text if len(text) <= 80 else f"{text[:77]}..."


def _remove(tables: dict[str, Any], key: str, parts: list[str]) -> None:
    """Removes a key of a table, or a table. Raises InputError where there is nothing to remove."""
    table = tables.get(parts[0]) if len(parts) == 2 else tables
    if not isinstance(table, dict) or parts[-1] not in table:
        present = ", ".join(table) if isinstance(table, dict) and table else "none"
        raise InputError(
            f"--set {key}= removes a key that is given, but `{key}` is not: the keys are {present}."
        )
    del table[parts[-1]]
