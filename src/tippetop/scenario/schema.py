"""The shape of a scenario: tables, keys and types, made from a system's own record."""

from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.contact.struck import RESTITUTIONS
from ..mechanics.system import Number, System
from ..problem import AUTO, UNTIL


# --- the shape of a scenario ----------------------------------------------------------------------------------------


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


class RunTable(Table):
    """How long, how accurately, and what is kept; the descriptions are those of the key reference."""

    until: Annotated[_number(UNTIL), Field(description="how long")]  # type: ignore[valid-type]
    output_step: Annotated[
        Annotated[float, Field(gt=0)] | None,
        Field(description="time between two rows [s]; one of output_step, output_times where output is times"),
    ] = None
    output_times: Annotated[
        list[Annotated[float, Field(ge=0)]] | None, Field(description="the times of the rows [s], instead")
    ] = None
    output: Annotated[
        Literal["times", "events", "steps", "keyframes"],
        Field(
            description="rows at times, at events, at the integrator's own steps, or none: its exact state now and then"
        ),
    ] = "times"
    keyframe_steps: Annotated[
        Annotated[int, Field(ge=1)] | None, Field(description="steps between two keyframes; 8192")
    ] = None
    stop_when: Annotated[
        Literal["until", "settled"], Field(description="end at `until`, or once the axis is at rest")
    ] = "until"
    events: Annotated[list[str] | None, Field(description="the kinds of events that are logged; all of the system")] = (
        None
    )
    on_liftoff: Annotated[
        Literal["stop", "continue", "fly"] | None,  # "fly" where the contact may change its phase
        Field(description="where the normal force vanishes: end the run, continue as if the contact pulled, or fly"),
    ] = None
    precision: Annotated[
        Literal["double", "longdouble", "quad"], Field(description="of all numbers: 53, 64 or 113 bits")
    ] = "double"
    tolerance: Annotated[
        Annotated[float, Field(ge=0, lt=1)], Field(description="error of a step, relative; 0: the precision's rounding")
    ] = 0.0
    columns: Annotated[list[str] | None, Field(description="the columns that rows have beside the time; all")] = None
    sensitivities: Annotated[
        list[str] | None,
        Field(description="numbers, such as friction.mu, by which columns and events are differentiated too; none"),
    ] = None
    orientation: Annotated[
        bool | None,
        Field(description="whether the turn of the body about its axis is integrated; where a column needs it"),
    ] = None


class ContactTable(Table):
    restitution: Annotated[Literal[RESTITUTIONS], Field(description="the law of impact")] = "energetic"  # type: ignore[valid-type]
    e_n: _number(CONTACT["e_n"]) = 0.0  # type: ignore[valid-type]


def table_model(name: str, parameters: dict[str, Number], *, required: bool, **extra: Any) -> type[BaseModel]:
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
        if system.contact[1] > 1:
            fields["stem"] = (table_model("Stem", STEM, required=True), ...)
    if system.frictional:
        union: Any = None
        for name in laws:
            table = table_model(name, system.laws[name].parameters, required=True, law=(Literal[name], ...))
            union = table if union is None else union | table
        fields["friction"] = (Annotated[union, Field(discriminator="law")], ...)
    return create_model("Scenario", __base__=Table, **fields)
