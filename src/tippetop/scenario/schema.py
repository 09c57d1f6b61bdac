"""The shape of a scenario: tables, keys and types, made from a system's own record."""

import types
from dataclasses import MISSING
from functools import lru_cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.contact.struck import RESTITUTIONS
from ..mechanics.system import Number, System
from ..problem import AUTO
from ..problem.options import HINTS, OPTIONS


# --- the shape of a scenario --------------------------------------------------------------------


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _number(parameter: Number) -> Any:
    """The type of a number: a float in the parameter's interval."""

    def within(value: float) -> float:
        if parameter.broken(value):
            raise PydanticCustomError("interval", "{must}", {"must": parameter.must(value)})
        return value

    return Annotated[float, AfterValidator(within)]


def _run_table() -> type[BaseModel]:
    """Return the model of [run], from the options of a run."""
    fields: dict[str, Any] = {}
    for name, option in OPTIONS.items():
        about = option.metadata
        limits: dict[str, Any] = {
            BOUNDS[bound]: limit for bound, limit in about["interval"].items()
        }
        kind = _number(about["rule"]) if about["rule"] else _kind(HINTS[name], limits)
        default = ... if option.default is MISSING else option.default
        fields[name] = Annotated[kind, Field(description=about["words"])], default
    return create_model("RunTable", __base__=Table, **fields)


BOUNDS = {"above": "gt", "least": "ge", "below": "lt"}
"""pydantic's words for the bounds of a number."""


def _kind(hint: Any, limits: dict[str, Any]) -> Any:
    """Return the type that TOML gives for the type of an option: lists for tuples, numbers within
    limits.
    """
    if get_origin(hint) in (types.UnionType, Union):
        return Union[tuple(_kind(part, limits) for part in get_args(hint))]  # noqa: UP007
    if get_origin(hint) is tuple:
        return list[_kind(get_args(hint)[0], limits)]  # type: ignore[misc]
    return Annotated[hint, Field(**limits)] if limits and hint in (float, int) else hint


RunTable: Any = _run_table()


class ContactTable(Table):
    restitution: Annotated[
        Literal[RESTITUTIONS],  # type: ignore[valid-type]
        Field(description="the law of impact"),
    ] = "energetic"
    e_n: _number(CONTACT["e_n"]) = 0.0  # type: ignore[valid-type]


def table_model(
    name: str, parameters: dict[str, Number], *, required: bool, **extra: Any
) -> type[BaseModel]:
    fields: dict[str, Any] = {
        n: (_number(p), (... if p.default is None else p.default) if required else None)
        for n, p in parameters.items()
    }
    return create_model(name, __base__=Table, **extra, **fields)


def scenario_model(system: System) -> type[BaseModel]:
    """The pydantic model of a scenario of one system, made from the system's own record."""
    return _model(system, tuple(system.laws))


@lru_cache
def _model(system: System, laws: tuple[str, ...]) -> type[BaseModel]:
    """The model of a system as long as it has these friction laws: more may be registered."""
    fields: dict[str, Any] = {
        "system": (Literal[system.name], ...),
        "form": (Literal[(AUTO, *system.forms)], AUTO),
        "parameters": (table_model("Parameters", system.parameters, required=True), ...),
        "run": (RunTable, ...),
    }
    flags: Any = {a.name: (bool, False) for a in system.alternatives if a.flag}
    initial = table_model("Initial", system.initial, required=False, **flags)
    fields["initial"] = (initial, initial())
    if system.contact is not None:
        fields["contact"] = (ContactTable | None, None)
        if system.contact[1] > 1:
            fields["stem"] = (table_model("Stem", STEM, required=True), ...)
    if system.frictional:
        union: Any = None
        for name in laws:
            table = table_model(
                name, system.laws[name].parameters, required=True, law=(Literal[name], ...)
            )
            union = table if union is None else union | table
        fields["friction"] = (Annotated[union, Field(discriminator="law")], ...)
    return create_model("Scenario", __base__=Table, **fields)
