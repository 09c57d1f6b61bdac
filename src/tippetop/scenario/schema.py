"""The shape of a scenario: tables, keys and types, made from a system's own record."""

from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model

from ..mechanics.system import Parameter, System


# --- the shape of a scenario ----------------------------------------------------------------------------------------


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class RunTable(Table):
    until: Annotated[float, Field(gt=0)]
    output_step: Annotated[float, Field(gt=0)] | None = None
    output_times: list[Annotated[float, Field(ge=0)]] | None = None
    output: Literal["times", "events", "steps"] = "times"
    stop_when: Literal["until", "settled"] = "until"
    events: list[str] | None = None
    on_liftoff: Literal["stop", "continue"] = "stop"
    precision: Literal["double", "longdouble", "quad"] = "double"
    tolerance: Annotated[float, Field(ge=0, lt=1)] = 0.0
    orientation: bool = True  # whether the turn of the body about its axis is integrated and stored too


def _number(parameter: Parameter) -> Any:
    bounds: dict[str, Any] = {"gt": parameter.above, "ge": parameter.least, "lt": parameter.below, "le": parameter.most}
    return Annotated[float, Field(**{k: v for k, v in bounds.items() if v is not None})]


def table_model(name: str, parameters: dict[str, Parameter], *, required: bool, **extra: Any) -> type[BaseModel]:
    fields: dict[str, Any] = {
        n: (_number(p), ...) if required else (_number(p) | None, None) for n, p in parameters.items()
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
        "form": (Literal[tuple(system.forms)], next(iter(system.forms))),
        "parameters": (table_model("Parameters", system.parameters, required=True), ...),
        "run": (RunTable, ...),
    }
    flags = {"centre_at_rest": (bool, False)} if "nu_x" in system.initial else {}
    initial = table_model("Initial", system.initial, required=False, **flags)
    fields["initial"] = (initial, initial())
    if system.frictional:
        union: Any = None
        for name in laws:
            table = table_model(name, system.laws[name].parameters, required=True, law=(Literal[name], ...))
            union = table if union is None else union | table
        fields["friction"] = (Annotated[union, Field(discriminator="law")], ...)
    return create_model("Scenario", __base__=Table, **fields)
