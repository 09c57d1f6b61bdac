"""The errors that pydantic finds, as sentences: what must hold, and what was found."""

from typing import Any, get_args

from pydantic import BaseModel

from ..mechanics.system import System


def scenario_sentence(error: Any, system: System, tables: dict[str, Any], shape: type[BaseModel]) -> str:
    """One pydantic error of a scenario as `key` must ..., but is ...."""
    laws = system.laws
    place = [p for p in error["loc"] if not (p in laws and error["loc"][0] == "friction")]
    key, context, kind = ".".join(map(str, place)), error.get("ctx", {}), error["type"]
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        found = repr(context.get("tag")) if kind == "union_tag_invalid" else "missing"
        return f"`{key}.law` must be one of {', '.join(laws)}, but is {found}."
    return worded(error, key, _known(system, tables, shape, place) if kind == "extra_forbidden" else [])


def _known(system: System, tables: dict[str, Any], shape: type[BaseModel], place: list) -> list[str]:
    """The keys that a table of the scenario may have."""
    if place[0] == "friction" and len(place) > 1:
        return ["law", *system.laws[tables["friction"]["law"]].parameters]
    model: Any = shape
    for part in place[:-1]:
        annotation = model.model_fields[part].annotation
        model = next((a for a in get_args(annotation) if hasattr(a, "model_fields")), annotation)
    return list(model.model_fields)


def worded(error: Any, key: str, known: list[str]) -> str:
    """One pydantic error at `key` as a sentence; `known` are the keys that its table may have."""
    context, kind = error.get("ctx", {}), error["type"]
    found = repr(error["input"]) if not isinstance(error["input"], dict) else "a table"
    if len(found) > 60:
        found = found[:57] + "..."
    if kind == "missing":
        return f"`{key}` must be given, but is missing."
    if kind == "extra_forbidden":
        return f"`{key}` must not be there: known keys are {', '.join(known)}."
    must = {
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
    return f"`{key}` {must}, but is {found}."
