"""A scenario with every key that it may have: those of a preset, and the others in comments.

`tippetop new` writes it.
"""

import json
from typing import Any

from ..errors import InputError, suggestion
from ..mechanics.systems import SYSTEMS, laws_of
from ..problem import AUTO
from ..problem.options import OPTIONS
from . import reading
from .build import system_of
from .contact import system_with_contact
from .reading import law_name
from .scenario_reference import keys_of
from .schema import table_models


WIDTH = 32  # columns of a key and its value


def template(name: str) -> str:
    """Return a scenario as TOML that runs, with comments.

    Parameters
    ----------
    name
        A system, of which the first preset is taken, or a preset.

    Returns
    -------
    str

    Raises
    ------
    InputError
        There is no such system or preset.
    """
    texts = reading.presets()
    if name not in texts:
        if name not in SYSTEMS:
            near = suggestion(name, [*SYSTEMS, *texts])
            raise InputError(f"a system or a preset must be named, but `{name}` is neither.{near}")
        of_system = [preset for preset in texts if reading.read(preset)["system"] == name]
        if not of_system:
            raise InputError(
                f"{name} has no preset to begin with: tippetop help scenario lists its keys."
            )
        name = "inverting" if "inverting" in of_system else of_system[0]
    return "\n".join([*_lines(name, reading.read(name)), ""])


def _lines(preset: str, tables: dict[str, Any]) -> list[str]:
    """Return the lines of a TOML file with every key of a scenario.

    Keys of the preset have their values; others are comments with an example.
    """
    system = system_with_contact(system_of(tables), tables)
    examples = {key: option.metadata["example"] for key, option in OPTIONS.items()}
    examples |= {a.name: True for a in system.alternatives if a.flag}
    examples["events"] = [event.name for event in system.events]
    law = system.laws.get(law_name(tables))
    forms = f"{AUTO}: the cheapest that is regular everywhere; or {', '.join(system.forms)}"
    laws = f"one of {', '.join(laws_of(system))}"
    lines = [
        f"# From the preset {preset}, with every key; `tippetop help scenario` and `tippetop "
        "help friction` explain more.",
        '# Numbers are SI, or texts: "20 g", "5.7 deg", "1480 rpm", "2/5*m*R^2".',
        _line("system", tables["system"], system.title),
        _line("form", tables.get("form", AUTO), forms),
    ]
    for table, model in table_models(system, law).items():
        given = tables.get(table, {})
        if not given and (table == "stem" or (table == "contact" and not system.contact)):
            continue
        lines += ["", f"[{table}]"]
        for key, unit, must, words in keys_of(model):
            must = must.removesuffix("; must be given")
            text = f"{words}{f' [{unit}]' if unit not in ('', '1') else ''}; {must}"
            # a required key has a default too, PydanticUndefined, but every preset gives it
            values = (examples.get(key), model.model_fields[key].default, 0.0)
            example = next(value for value in values if value is not None)
            lines.append(
                _line(key, given[key], laws if key == "law" else text)
                if key in given
                else _line(f"# {key}", example, text)
            )
    if system.opening and not system.contact:
        text = "# [contact] lets it lift off, fly and land; [air] and [plane] are its surroundings"
        lines += ["", f"{text}: tippetop help scenario."]
    return lines


def _line(key: str, value: Any, text: str) -> str:
    """Return a line of a template: key, value as in TOML, and `text`, its meaning, as a comment."""
    return f"{f'{key} = {json.dumps(value)}':{WIDTH}}  # {text}"
