"""The errors that pydantic finds, as sentences: what must hold, and what was found."""

from typing import Any, get_args

from pydantic import BaseModel, TypeAdapter, ValidationError

from ..errors import sentence, suggestion, unknown_key
from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.friction import LAWS
from ..mechanics.system import System
from ..mechanics.systems import laws_of
from .law_change import law_name


def scenario_sentence(
    error: Any, system: System, tables: dict[str, Any], shape: type[BaseModel]
) -> str:
    """One pydantic error of a scenario as `key` must ..., but is ...."""
    laws = system.laws
    place = [p for p in error["loc"] if not (p in laws and error["loc"][0] == "friction")]
    key, context, kind = ".".join(map(str, place)), error.get("ctx", {}), error["type"]
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        given = repr(context.get("tag")) if kind == "union_tag_invalid" else "missing"
        known = laws_of(system)
        near = suggestion(str(context.get("tag", "")), known)
        return f"`{key}.law` must be one of {', '.join(known)}, but is {given}.{near}"
    if kind != "extra_forbidden":
        return error_sentence(error, key, [])
    if key == "friction":
        return (
            f"`friction` must not be given, because `{system.name}` takes no friction law: "
            "remove the table "
            "(--set friction=)."
        )
    others = [
        name
        for name, law in {**LAWS, **laws}.items()
        if place[0] == "friction" and place[-1] in law.parameters
    ]
    belongs = f"it belongs to law = {' or '.join(map(repr, others))}" if others else ""
    return unknown_key(
        key, _known(system, tables, shape, place), _all_keys(system, tables, shape), belongs
    )


def _known(
    system: System, tables: dict[str, Any], shape: type[BaseModel], place: list
) -> list[str]:
    """The keys that a table of the scenario may have."""
    if place[0] == "friction" and len(place) > 1:
        return ["law", *system.laws[tables["friction"]["law"]].parameters]
    model: Any = shape
    for part in place[:-1]:
        model = _model(model, part)
    return list(model.model_fields)


def _all_keys(system: System, tables: dict[str, Any], shape: type[BaseModel]) -> list[str]:
    """Every dotted key that a scenario of this system and friction law may have."""
    keys = [name for name in shape.model_fields if not _model(shape, name)]
    for name in shape.model_fields:
        model = _model(shape, name)
        if model is not None:
            keys += [f"{name}.{key}" for key in model.model_fields]
    law = system.laws.get(law_name(tables) or "")
    if system.opening:  # tables that a scenario may have, whether or not it has one
        keys += ["contact.restitution", *(f"contact.{key}" for key in CONTACT)]
        keys += [f"stem.{key}" for key in STEM] if system.opening.sphere else []
    return keys + ([f"friction.{key}" for key in ("law", *law.parameters)] if law else [])


def _model(shape: type[BaseModel], name: str) -> Any:
    """The pydantic model of a table of the scenario, None where the key holds a plain value (or a
    choice of laws).
    """
    annotation: Any = shape.model_fields[name].annotation
    return next(
        (a for a in (annotation, *get_args(annotation)) if hasattr(a, "model_fields")), None
    )


def error_sentence(error: Any, key: str, known: list[str]) -> str:
    """One pydantic error at `key` as a sentence; `known` are the keys that its table may have."""
    context, kind = error.get("ctx", {}), error["type"]
    if kind == "missing":
        return f"`{key}` must be given, but is missing."
    if kind == "extra_forbidden":
        return unknown_key(key, known, [])
    must = {
        "interval": context.get("must"),
        "greater_than": f"must be greater than {context.get('gt')}",
        "greater_than_equal": f"must be at least {context.get('ge')}",
        "less_than": f"must be less than {context.get('lt')}",
        "less_than_equal": f"must be at most {context.get('le')}",
        "finite_number": "must be a finite number",
        "float_type": "must be a number",
        "float_parsing": "must be a number",
        "int_type": "must be a whole number",
        "bool_type": "must be true or false",
        "string_type": "must be a string",
        "list_type": "must be a list",
        "dict_type": "must be a table",
        "too_short": f"must have at least {context.get('min_length')} items",
        "too_long": f"must have at most {context.get('max_length')} items",
        "literal_error": f"must be {context.get('expected')}",
        "model_type": "must be a table",
        "model_attributes_type": "must be a table",
    }.get(kind, f"must be valid ({error['msg']})")
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
