"""The shape of a scenario: tables, keys and types, made from a system's own record."""

from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from ..mechanics.contact.phases.rules import CONTACT, STEM
from ..mechanics.system import Parameter, System
from ..problem import AUTO, UNTIL


# --- the shape of a scenario ----------------------------------------------------------------------------------------


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _number(parameter: Parameter) -> Any:
    """The type of a number: a float in the parameter's interval."""

    def within(value: float) -> float:
        if parameter.broken(value):
            raise PydanticCustomError("interval", "{must}", {"must": parameter.must(value)})
        return value

    return Annotated[float, AfterValidator(within)]


class RunTable(Table):
    until: _number(UNTIL)  # type: ignore[valid-type]
    output_step: Annotated[float, Field(gt=0)] | None = None
    output_times: list[Annotated[float, Field(ge=0)]] | None = None
    output: Literal["times", "events", "steps", "keyframes"] = "times"
    keyframe_steps: Annotated[int, Field(ge=1)] | None = None
    stop_when: Literal["until", "settled"] = "until"
    events: list[str] | None = None
    on_liftoff: Literal["stop", "continue", "fly"] | None = None  # "fly" where the contact may change its phase
    precision: Literal["double", "longdouble", "quad"] = "double"
    tolerance: Annotated[float, Field(ge=0, lt=1)] = 0.0
    columns: list[str] | None = None  # of the rows, beside the time; all
    orientation: bool | None = None  # whether the turn of the body about its axis is integrated; if a column needs it


class ContactTable(Table):
    restitution: Literal["energetic", "poisson", "newton"] = "energetic"
    e_n: _number(CONTACT["e_n"]) = 0.0  # type: ignore[valid-type]


def table_model(name: str, parameters: dict[str, Parameter], *, required: bool, **extra: Any) -> type[BaseModel]:
    fields: dict[str, Any] = {
        n: (_number(p), ... if p.default is None else p.default) if required else (_number(p) | None, None)
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
        if system.contact[1]:
            fields["stem"] = (table_model("Stem", STEM, required=True), ...)
    if system.frictional:
        union: Any = None
        for name in laws:
            table = table_model(name, system.laws[name].parameters, required=True, law=(Literal[name], ...))
            union = table if union is None else union | table
        fields["friction"] = (Annotated[union, Field(discriminator="law")], ...)
    return create_model("Scenario", __base__=Table, **fields)
