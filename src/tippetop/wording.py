"""The errors that pydantic finds in a table, as sentences: what must hold, and what was found."""

from typing import Any


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
