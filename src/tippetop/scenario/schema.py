"""The shape of a scenario: tables, keys and types, made from the records of its system.

A system and a law go in; pydantic models come out, by which `build` checks tables.
"""

import types
from collections.abc import Mapping
from dataclasses import MISSING
from functools import lru_cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from ..mechanics.contact.restitution import CONTACT, RESTITUTIONS, STEM
from ..mechanics.contact.surroundings import by_table
from ..mechanics.system import Number, System
from ..problem import AUTO
from ..problem.options import HINTS, OPTIONS


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _number(rule: Number, kind: Any = float) -> Any:
    """Return a type for pydantic: a number of type `kind` in the interval of `rule`."""

    def within(value: float) -> float:
        """Return the value, if it lies in the interval of the number; pydantic calls it.

        Raises PydanticCustomError, which `sentences` turns into a message.
        """
        if rule.broken(value):
            raise PydanticCustomError("interval", "{must}", {"must": rule.must(value)})
        return value

    # `scenario_reference.keys_of` reads these from the JSON schema of a table
    must = rule.must().removeprefix("must be ")
    if kind is int:
        must = must.replace("finite", "a whole number")
    more: Any = {"unit": rule.unit.symbol, "must": must, "optional": rule.optional}
    words = Field(description=rule.long_name, json_schema_extra=more)
    return Annotated[kind, AfterValidator(within), words]


def number_table(rules: Mapping[str, Number], required: bool = True, **more: Any) -> Any:
    """Return the pydantic model of a table of numbers; `more` are other keys, as for pydantic.

    Numbers without a default must be given if they are `required`; otherwise each may be left out.
    """
    fields: dict[str, Any] = {
        key: (_number(rule), (... if rule.default is None else rule.default) if required else None)
        for key, rule in rules.items()
    }
    return create_model("Numbers", __base__=Table, **more, **fields)


def _kind(hint: Any, rule: Number) -> Any:
    """Return the type in TOML of an option: a list for a tuple, numbers in an interval.

    `hint` is the annotation of its field, `rule` the `Number` with its interval.
    """
    if get_origin(hint) in (types.UnionType, Union):
        return Union[tuple(_kind(part, rule) for part in get_args(hint))]  # noqa: UP007
    if get_origin(hint) is tuple:
        return list[_kind(get_args(hint)[0], rule)]  # type: ignore[misc]
    return _number(rule, hint) if hint in (float, int) else hint


def _run_table() -> Any:
    """Return the pydantic model of the table [run], made of the fields of `RunOptions`."""
    fields: dict[str, Any] = {}
    for name, option in OPTIONS.items():
        about = option.metadata
        unit = {"unit": about["unit"].symbol} if about["unit"] else {}
        default = ... if option.default is MISSING else option.default
        field: Any = Field(default, description=about["words"], json_schema_extra=unit)
        fields[name] = _kind(HINTS[name], about["rule"]), field
    return create_model("RunTable", __base__=Table, **fields)


RunTable: Any = _run_table()
StemTable: Any = number_table(STEM)
ContactTable: Any = number_table(
    {},
    restitution=(Literal[RESTITUTIONS], Field("energetic", description="the law of impact")),
    e_n=(_number(CONTACT["e_n"]), 0.0),
)


@lru_cache(maxsize=64)
def table_models(system: System, law: Any = None) -> dict[str, Any]:
    """Return the models of the tables that a scenario of a system and a law may have, by name.

    In the order of a template. The dict is cached: not to be changed.
    """
    words = "the centre of mass does not move sideways"
    flags: Any = {
        a.name: (bool, Field(None, description=words)) for a in system.alternatives if a.flag
    }
    tables = {"parameters": number_table(system.parameters)}
    if law is not None:
        key = Literal[law.key], Field(description="the friction law")
        tables["friction"] = number_table(law.parameters, law=key)
    tables["initial"] = number_table(system.initial, required=False, **flags)
    if system.opening:
        tables["contact"] = ContactTable
        if system.opening.sphere:
            tables["stem"] = StemTable
    given = by_table(system.surroundings)
    tables |= {name: number_table(rules) for name, rules in given.items()}
    return tables | {"run": RunTable}


@lru_cache(maxsize=64)
def scenario_model(system: System, law: Any = None) -> type[BaseModel]:
    """Return the pydantic model of a scenario of a system with a friction law.

    Without a law it reports that one is missing or unknown.
    """
    models = table_models(system, law)
    fields: dict[str, Any] = {
        "system": (Literal[system.name], ...),
        "form": (Literal[(AUTO, *system.forms)], AUTO),
        **{name: (model, ...) for name, model in models.items()},
        "initial": (models["initial"], models["initial"]()),
    }
    if system.frictional and law is None:
        names: Any = Literal[tuple(system.laws)]
        fields["friction"] = create_model("Law", law=(names, ...)), ...
    optional = models.keys() & {"contact", "stem"}
    fields |= {name: (models[name] | None, None) for name in optional}
    return create_model("Scenario", __base__=Table, **fields)
