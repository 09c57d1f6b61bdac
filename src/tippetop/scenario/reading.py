"""TOML text becomes tables: files, presets, and `--set` assignments.

`runs.starting` and `library` call it; tables are plain dicts, not checked yet.
"""

import os
import re
import tomllib
from collections.abc import Collection, Mapping
from functools import cache, lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..arguments import TOO_DEEP, PlainData, plain
from ..errors import InputError, suggestion


OUTPUT = ("output", "output_step", "output_times")  # one of them decides when there are rows


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
    """Return the TOML text of each preset by name, read once."""
    folder = files("tippetop") / "scenario" / "presets"
    names = sorted(p.name.removesuffix(".toml") for p in folder.iterdir())
    return {name: (folder / f"{name}.toml").read_text(encoding="utf-8") for name in names}


def read(source: str) -> PlainData:
    """Return the tables of a TOML file or of a preset. Raises InputError."""
    path = Path(source)
    try:
        if path.suffix != ".toml" and not os.path.isfile(path):
            known = _presets()
            if source not in known:
                if os.path.isdir(path):
                    raise InputError(
                        f"`{_short(source)}` must be a TOML file or a preset, but is a folder: "
                        "`tippetop info` describes a store."
                    )
                raise InputError(
                    f"`{_short(source)}` is neither a TOML file nor a preset."
                    f"{suggestion(source, known)} "
                    f"The presets are {', '.join(known)}."
                )
            text = known[source]
        else:
            text = path.read_text(encoding="utf-8-sig")
        return plain(_parsed(text))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"`{source}` cannot be read: {error.strerror or error}.") from None
    except ValueError as error:
        raise InputError(f"`{source}` is not valid TOML in UTF-8: {error}.") from None


@lru_cache(maxsize=64)
def _parsed(text: str) -> PlainData:
    """Return the tables of a TOML text, cached: to be copied. Raises ValueError."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(TOO_DEEP) from None


def override(tables: PlainData, assignments: list[str] | None) -> PlainData:
    """Return the tables with `table.key=value` assignments; values are TOML, or bare words.

    Nothing after the `=` removes the key or the table: `friction=`, `run.output_step=`.
    Raises InputError.
    """
    given: dict[str, PlainData] = {}
    listed = [] if assignments is None else assignments
    if not isinstance(listed, list | tuple) or not all(isinstance(each, str) for each in listed):
        raise InputError(f"`assignments` must be a list of texts, but is {assignments!r:.60}.")
    for assignment in listed:
        key, equals, text = (part.strip() for part in assignment.partition("="))
        if not equals or not re.fullmatch(r"(\w[\w-]*\.)?\w[\w-]*", key):
            raise InputError(f"--set must be table.key=value, but is `{_short(assignment)}`.")
        table, _, name = key.rpartition(".")
        given.setdefault(table, {})[name] = _value(key, text) if text else None
    for table, values in given.items():
        old = tables.get(table, {}) if table else tables
        for name, value in values.items():
            key = f"{table}.{name}" if table else name
            if not isinstance(old, dict):
                raise InputError(
                    f"--set {key} must name a key of a table, but `{table}` is not a table."
                )
            if value is None and name not in old:
                raise InputError(
                    f"--set {key}= removes a key that is given, but `{key}` is not: the keys are "
                    f"{', '.join(old) or 'none'}."
                )
        new = {k: v for k, v in merged(table, old, values).items() if v is not None}
        tables = {**tables, table: new} if table else new
    return tables


def merged(table: str, old: PlainData, given: Mapping[str, Any]) -> PlainData:
    """Return a table of a scenario with other values, without those that they replace.

    `initial.from` replaces the start, another law replaces the numbers of the law, and a key that
    decides when there are rows replaces the other such keys, except that `output = "times"` keeps
    given times. `--set` and the `set` of a plan use it.
    """
    replaced: Collection[str] = ()
    law = old.get("law")
    if (table == "initial" and "from" in given) or (
        table == "friction" and given.get("law", law) != law
    ):
        replaced = old
    elif table == "run" and any(
        key in OUTPUT and (key, value) != ("output", "times") for key, value in given.items()
    ):
        replaced = (*OUTPUT, "keyframe_steps")
    return {key: value for key, value in old.items() if key not in replaced} | dict(given)


def law_name(tables: Mapping[str, Any]) -> str:
    """Return the name of the law in the tables of a scenario, "" without one."""
    friction = tables.get("friction")
    name = friction.get("law") if isinstance(friction, dict) else None
    return name if isinstance(name, str) else ""


def _value(key: str, text: str) -> Any:
    """Return the value of an assignment: TOML, or a text without quotes. Raises InputError."""
    try:
        return _parsed(f"value = {text}")["value"]
    except ValueError:
        if key == "initial.from" or not re.search(r"[\"'\[\]{}=,#]", text):
            return text
        raise InputError(
            f'--set {key} must be given a TOML value (5, 0.3, true, "word", [1.0, 2.0]), but is '
            f"`{_short(text)}`."
        ) from None


def _short(text: str) -> str:
    """Return the text, cut to the length of a sentence."""
    return text if len(text) <= 80 else f"{text[:77]}..."
