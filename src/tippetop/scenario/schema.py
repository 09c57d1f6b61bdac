"""The shape of a scenario: tables, keys and types, made from the records of its system."""

import types
from collections.abc import Mapping
from dataclasses import MISSING
from functools import lru_cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from ..mechanics.contact.restitution import CONTACT, RESTITUTIONS, STEM
from ..mechanics.system import Number, System
from ..problem import AUTO
from ..problem.options import HINTS, OPTIONS


BOUNDS = {"above": "gt", "least": "ge", "below": "lt"}
"""pydantic's words for the bounds of a number."""


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _number(rule: Number) -> Any:
    """Return the type of a number: a float in the interval of its record."""

    def within(value: float) -> float:
        if rule.broken(value):
            raise PydanticCustomError("interval", "{must}", {"must": rule.must(value)})
        return value

    more = {"unit": rule.unit.symbol, "must": rule.must().removeprefix("must be ")}
    words = Field(description=rule.long_name, json_schema_extra=more)  # type: ignore[arg-type]
    return Annotated[float, AfterValidator(within), words]


def number_table(name: str, rules: Mapping[str, Number], required: bool = True, **more: Any) -> Any:
    """Return the model of a table of numbers; `more` are other keys."""
    fields: dict[str, Any] = {
        key: (_number(rule), (... if rule.default is None else rule.default) if required else None)
        for key, rule in rules.items()
    }
    return create_model(name, __base__=Table, **more, **fields)


def _kind(hint: Any, limits: dict[str, Any]) -> Any:
    """Return the type in TOML of an option: a list for a tuple, numbers within limits."""
    if get_origin(hint) in (types.UnionType, Union):
        return Union[tuple(_kind(part, limits) for part in get_args(hint))]  # noqa: UP007
    if get_origin(hint) is tuple:
        return list[_kind(get_args(hint)[0], limits)]  # type: ignore[misc]
    return Annotated[hint, Field(**limits)] if limits and hint in (float, int) else hint


def _run_table() -> Any:
    """Return the model of [run], from the options of a run."""
    fields: dict[str, Any] = {}
    for name, option in OPTIONS.items():
        about = option.metadata
        kind = _kind(HINTS[name], {BOUNDS[key]: at for key, at in about["interval"].items()})
        unit = {"unit": about["unit"].symbol} if about["unit"] else {}
        words: Any = Field(description=about["words"], json_schema_extra=unit)
        kind = _number(about["rule"]) if about["rule"] else Annotated[kind, words]
        fields[name] = kind, ... if option.default is MISSING else option.default
    return create_model("RunTable", __base__=Table, **fields)


RunTable: Any = _run_table()
StemTable: Any = number_table("StemTable", STEM)
ContactTable: Any = number_table(
    "ContactTable",
    {},
    restitution=(
        Annotated[Literal[RESTITUTIONS], Field(description="the law of impact")],
        "energetic",
    ),
    e_n=(_number(CONTACT["e_n"]), 0.0),
)


@lru_cache
def _friction_tables(laws: tuple[Any, ...]) -> dict[str, Any]:
    return {
        name: number_table(
            name,
            law.parameters,
            law=(Annotated[Literal[name], Field(description="the friction law")], ...),
        )
        for name, law in laws
    }


@lru_cache(maxsize=64)
def _tables(system: System) -> dict[str, Any]:
    words = "the centre of mass does not move sideways"
    flags: Any = {
        a.name: (Annotated[bool, Field(description=words)], False)
        for a in system.alternatives
        if a.flag
    }
    return {
        "parameters": number_table("Parameters", system.parameters),
        "initial": number_table("Initial", system.initial, required=False, **flags),
    }


def tables_of(system: System, law: str | None = None) -> dict[str, Any]:
    """Return the models of the tables that a scenario of a system and a law may have, by name."""
    parameters, initial = _tables(system).values()
    opens, law_tables = system.opening, _friction_tables(tuple(system.laws.items()))
    return {
        "parameters": parameters,
        **({"friction": law_tables[law]} if law in law_tables else {}),
        "initial": initial,
        **({"contact": ContactTable} if opens else {}),
        **({"stem": StemTable} if opens and opens.sphere else {}),
        "run": RunTable,
    }


def scenario_model(system: System) -> type[BaseModel]:
    """Return the pydantic model of a scenario of one system, made from the system's records."""
    return _model(system, tuple(system.laws.items()))


@lru_cache
def _model(system: System, laws: tuple[Any, ...]) -> type[BaseModel]:
    """Return the model of a system with these friction laws: more may be registered."""
    models = tables_of(system)
    fields: dict[str, Any] = {
        "system": (Literal[system.name], ...),
        "form": (Literal[(AUTO, *system.forms)], AUTO),
        "parameters": (models["parameters"], ...),
        "initial": (models["initial"], models["initial"]()),
        "run": (RunTable, ...),
    }
    if system.contact is not None:
        fields["contact"] = (ContactTable | None, None)
        if system.contact[1] > 1:
            fields["stem"] = (StemTable, ...)
    if system.frictional:
        union: Any = Union[tuple(_friction_tables(laws).values())]  # noqa: UP007
        kind = Annotated[union, Field(discriminator="law")] if len(laws) > 1 else union
        fields["friction"] = kind, ...
    return create_model("Scenario", __base__=Table, **fields)
