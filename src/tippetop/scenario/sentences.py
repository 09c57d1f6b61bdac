"""Sentences on the errors that pydantic finds: the requirement and the value that was found.

`build` and `sweeps.plan` convert the errors of their models by it.
"""

import re
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ..arguments import not_among
from ..errors import sentence, unknown_key
from ..mechanics.contact.surroundings import RULES
from ..mechanics.friction import LAWS, PARTS
from ..mechanics.system import System
from ..mechanics.systems import laws_of, surroundable_systems
from .reading import law_name
from .schema import scenario_model, table_models


def scenario_sentence(error: Any, system: System, tables: dict[str, Any]) -> str:
    """Return the sentence on one pydantic error of a scenario.

    `error` is an item of `ValidationError.errors`, with `loc`, `type`, `input`, `ctx` and `msg`.
    """
    law = system.laws.get(law_name(tables))
    place = error["loc"]
    key = ".".join(map(str, place))
    kind = error["type"]
    if key == "friction.law":
        return not_among(key, tables["friction"].get("law"), laws_of(system))
    if kind != "extra_forbidden":
        return error_sentence(error, key, [])
    if key == "friction":
        return (
            f"`friction` must not be given, because `{system.name}` takes no friction law: "
            "remove the table (--set friction=)."
        )
    others = [
        name
        for name, other in {**LAWS, **system.laws}.items()
        if place[0] == "friction" and place[-1] in other.parameters
    ]
    belongs = f"it belongs to law = {' or '.join(map(repr, others))}" if others else ""
    models = table_models(system, law)
    around = RULES if system.name in surroundable_systems() else {}  # of every group
    known = {name: [*rules] for name, rules in around.items()}
    known |= {name: [*its.model_fields] for name, its in models.items() if name not in known}
    keys = [f"{name}.{key}" for name, its in known.items() for key in its]
    keys += [f"friction.{part}" for part in PARTS if system.opening and system.opening.rounded]
    tables_too = dict.fromkeys([*scenario_model(system, law).model_fields, *known])
    return unknown_key(
        key, known[place[0]] if place[1:] else [*tables_too], ["system", "form", *keys], belongs
    )


def error_sentence(error: Any, key: str, known: list[str]) -> str:
    """Return the sentence on one pydantic error at `key`, whose table may have `known` keys.

    Plans are worded by it too. Without words for its type, the message of pydantic is rephrased.
    """
    context = error.get("ctx", {})
    kind = error["type"]
    if kind == "missing":
        not_taken = " (numbers of another law are not taken)" if "friction" in key else ""
        return f"`{key}` must be given, but is missing{not_taken}."
    if kind == "extra_forbidden":
        return unknown_key(key, known, [])
    must = {
        "interval": context.get("must"),
        "greater_than_equal": f"must be at least {context.get('ge')}",
        "int_type": "must be a whole number",
        "bool_type": "must be true or false",
        **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), "must be a table"),
    }.get(kind) or re.sub(
        "^(Input|List) should", "must", error["msg"].partition(" after ")[0]
    ).replace("a valid", "a")
    return sentence(key, must, error["input"])


def type_faults(kind: str, record: Any) -> list[str]:
    """Return a sentence for each field of a wrong type in a record with a name."""
    try:
        TypeAdapter(type(record)).validate_python(vars(record))
    except ValidationError as error:
        return [
            f"`{'.'.join(map(str, wrong['loc']))}` of the {kind} `{record.name}` must be "
            f"{wrong['msg'].removeprefix('Input should be ')}, but is {wrong['input']!r:.60}."
            for wrong in error.errors()
        ]
    return []
