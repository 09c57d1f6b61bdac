"""A scenario with every key that it may have: what stands in a preset, and in comments what else
there is.
"""

import json
from collections.abc import Mapping
from typing import Any

from ..errors import InputError, suggestion
from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.number import Number
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS, laws_of
from ..problem import AUTO
from ..problem.options import OPTIONS, UNITS, UNTIL
from . import reading
from .build import system_of
from .contact import system_with_contact
from .reference import keys_of
from .schema import ContactTable, RunTable


WIDTH = 34  # of a key and its value, before what it is


def template(name: str) -> str:
    """A scenario as TOML that runs, with comments.

    Parameters
    ----------
    name
        A system, of which the first preset is taken, or a preset.

    Returns
    -------
    str
        Raises InputError if there is no such system or preset.
    """
    texts = reading.presets()
    if name not in texts:
        known = {**dict.fromkeys(SYSTEMS), **dict.fromkeys(texts)}
        if name not in SYSTEMS:
            raise InputError(
                f"a system or a preset must be named, but `{name}` is "
                f"none.{suggestion(name, known)}"
            )
        of_system = [preset for preset in texts if reading.read(preset)["system"] == name]
        if not of_system:
            raise InputError(
                f"{name} has no preset to begin with: tippetop help scenario lists its keys."
            )
        name = "inverting" if "inverting" in of_system else of_system[0]
    tables = reading.read(name)
    return "\n".join(_lines(name, tables, system_with_contact(system_of(tables), tables)))


def _lines(preset: str, tables: dict[str, Any], system: System) -> list[str]:
    lines = [
        f"# From the preset {preset}, with every key; `tippetop help scenario` and `tippetop "
        "help friction` say more.",
        '# Numbers are SI, or texts: "20 g", "5.7 deg", "1480 rpm", "2/5*m*R^2".',
        _line("system", tables["system"], f"{system.title}"),
        _line(
            "form",
            tables.get("form", AUTO),
            f"{AUTO}: the cheapest that is regular there; or {', '.join(system.forms)}",
        ),
        *_table("parameters", tables["parameters"], _rules(system.parameters), {}),
    ]
    if system.frictional:
        given = tables["friction"]
        law = system.laws[given["law"]].given(given)
        lines += [
            "",
            "[friction]",
            _line("law", given["law"], f"one of {', '.join(laws_of(system))}"),
        ]
        lines += _keys(given, _rules(law.parameters), {})
    flags = {
        a.name: "true: the centre of mass does not move sideways"
        for a in system.alternatives
        if a.flag
    }
    start = {**dict.fromkeys(system.initial, 0.0), **dict.fromkeys(flags, True)}
    lines += _table(
        "initial", tables.get("initial", {}), {**_rules(system.initial), **flags}, start
    )
    contact = {**dict(ContactTable()), **tables.get("contact", {})} if system.contact else {}
    for name, given, known in (
        (
            "contact",
            contact,
            {key: f"{text}; {must}" for key, _, must, text in keys_of(ContactTable, CONTACT)},
        ),
        ("stem", tables.get("stem"), _rules(STEM)),
    ):
        lines += _table(name, given, known, {}) if given else []
    if system.opening and not system.contact:
        lines += [
            "",
            "# [contact] lets it lift off, fly and land, [stem] land on its stem: tippetop help "
            "scenario.",
        ]
    examples: dict[str, Any] = {"events": [event.name for event in system.events]}
    for name, option in OPTIONS.items():
        example = option.metadata["example"]
        examples.setdefault(name, option.default if example is None else example)
    run = {
        key: f"{text}{f' [{unit}]' if unit else ''}; {must}"
        for key, unit, must, text in keys_of(RunTable, {"until": UNTIL}, UNITS)
    }
    return [*lines, *_table("run", tables["run"], run, examples), ""]


def _rules(parameters: Mapping[str, Number]) -> dict[str, str]:
    return {
        name: f"{p.long_name} [{p.unit.symbol}]; {p.must().removeprefix('must be ')}"
        for name, p in parameters.items()
    }


def _table(
    name: str, given: Mapping[str, Any], known: Mapping[str, str], examples: Mapping[str, Any]
) -> list[str]:
    return ["", f"[{name}]", *_keys(given, known, examples)]


def _keys(
    given: Mapping[str, Any], known: Mapping[str, str], examples: Mapping[str, Any]
) -> list[str]:
    """What is given, and in comments, by examples, what is not."""
    return [
        _line(key, given[key], text) if key in given else _line(f"# {key}", examples[key], text)
        for key, text in known.items()
    ]


def _line(key: str, value: Any, text: str) -> str:
    return f"{f'{key} = {json.dumps(value)}':{WIDTH - 2}}  # {text}".replace(" [1]", "")
