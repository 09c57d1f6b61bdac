"""The door: a TOML scenario becomes a checked Problem, or a list of sentences that say all that is wrong with it."""

import itertools
import math
import re
import tomllib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from .friction import LAWS
from .operand import leaves
from .problem import PRECISIONS, Problem
from .system import Parameter, System
from .systems import SYSTEMS
from .systems.gliding import POLE
from .times import Given, Grid
from .trajectory import View
from .wording import worded


MOST_ROWS = 10**12  # more is a slip of the pen: 200 TB


class ScenarioError(ValueError):
    """A scenario that cannot be run; `sentences` says each thing that must hold and what was found."""

    def __init__(self, sentences: list[str]):
        super().__init__("\n".join(sentences))
        self.sentences = sentences


# --- reading --------------------------------------------------------------------------------------------------------


def presets() -> dict[str, str]:
    """The built-in scenarios: name -> TOML text."""
    folder = files("tippetop") / "scenarios"
    named = {p.name.removesuffix(".toml"): p for p in folder.iterdir() if p.name.endswith(".toml")}
    return {name: named[name].read_text(encoding="utf-8") for name in sorted(named)}


def read(source: str) -> dict[str, Any]:
    """The tables of a TOML file or of a preset. Raises ScenarioError."""
    path = Path(source)
    try:
        if path.suffix != ".toml" and not path.is_file():
            known = presets()
            if source not in known:
                raise ScenarioError(
                    [f"`{source}` must be a TOML file or one of the presets {', '.join(known)}, but is neither."]
                )
            return tomllib.loads(known[source])
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        if isinstance(error, ScenarioError):
            raise
        if isinstance(error, OSError):
            raise ScenarioError([f"`{source}` must be a readable file, but: {error.strerror or error}."]) from None
        raise ScenarioError([f"`{source}` must be TOML in UTF-8, but: {error}."]) from None


def override(tables: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """The tables with `table.key=value` assignments applied; values are TOML, a bare word is a string."""
    changed = {k: dict(v) if isinstance(v, dict) else v for k, v in tables.items()}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        parts = key.strip().split(".")
        if not equals or not all(re.fullmatch(r"\w[\w-]*", p) for p in parts) or len(parts) > 2:
            raise ScenarioError([f"--set must be table.key=value, but is `{assignment}`."])
        word = re.fullmatch(r"[A-Za-z][\w-]*", text.strip()) and text.strip() not in ("true", "false", "nan", "inf")
        try:
            value = text.strip() if word else tomllib.loads(f"value = {text}")["value"]
        except ValueError:
            raise ScenarioError([f"--set {key} must be given a TOML value, but is `{text}`."]) from None
        table = changed.setdefault(parts[0], {}) if len(parts) == 2 else changed
        if not isinstance(table, dict):
            raise ScenarioError([f"--set {key} must name a key of a table, but `{parts[0]}` is none."])
        table[parts[-1]] = value
    return changed


# --- the shape of a scenario ----------------------------------------------------------------------------------------


class Table(BaseModel):
    """A table of TOML: no unknown keys, no conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class _Run(Table):
    until: Annotated[float, Field(gt=0)]
    output_step: Annotated[float, Field(gt=0)] | None = None
    output_times: list[Annotated[float, Field(ge=0)]] | None = None
    output: Literal["times", "events", "steps"] = "times"
    stop_when: Literal["until", "settled"] = "until"
    events: list[str] | None = None
    on_liftoff: Literal["stop", "continue"] = "stop"
    precision: Literal["double", "longdouble", "quad"] = "double"
    tolerance: Annotated[float, Field(ge=0, lt=1)] = 0.0


def _number(parameter: Parameter) -> Any:
    bounds: dict[str, Any] = {"gt": parameter.above, "ge": parameter.least, "lt": parameter.below, "le": parameter.most}
    return Annotated[float, Field(**{k: v for k, v in bounds.items() if v is not None})]


def _table(name: str, parameters: dict[str, Parameter], *, required: bool, **extra: Any) -> type[BaseModel]:
    fields: dict[str, Any] = {
        n: (_number(p), ...) if required else (_number(p) | None, None) for n, p in parameters.items()
    }
    return create_model(name, __base__=Table, **extra, **fields)


@lru_cache
def _shape(name: str) -> type[BaseModel]:
    """The pydantic model of a scenario of one system, made from the system's own record."""
    system = SYSTEMS[name]
    fields: dict[str, Any] = {
        "system": (Literal[name], ...),
        "form": (Literal[tuple(system.forms)], next(iter(system.forms))),
        "parameters": (_table("Parameters", system.parameters, required=True), ...),
        "run": (_Run, ...),
    }
    flags = {"centre_at_rest": (bool, False)} if "nu_x" in system.initial else {}
    initial = _table("Initial", system.initial, required=False, **flags)
    fields["initial"] = (initial, initial())
    if system.frictional:
        laws = [_table(n, law.parameters, required=True, law=(Literal[n], ...)) for n, law in system.laws.items()]
        union: Any = laws[0]
        for law in laws[1:]:
            union = union | law
        fields["friction"] = (Annotated[union, Field(discriminator="law")], ...)
    return create_model("Scenario", __base__=Table, **fields)


# --- checking -------------------------------------------------------------------------------------------------------


def problem(tables: dict[str, Any]) -> Problem:
    """The checked Problem of a scenario's tables. Raises ScenarioError with every fault that was found."""
    name = tables.get("system")
    if not isinstance(name, str) or name not in SYSTEMS:
        found = "is missing" if name is None else f"is {name!r}"
        raise ScenarioError([f"`system` must be one of {', '.join(SYSTEMS)}, but {found}."])
    system, shape = SYSTEMS[name], _shape(name)
    try:
        scenario: Any = shape.model_validate(tables)
    except ValidationError as error:
        raise ScenarioError([_sentence(e, tables, shape) for e in error.errors(include_url=False)]) from None
    parameters = scenario.parameters.model_dump()
    initial = {k: v for k, v in scenario.initial.model_dump().items() if v is not None and v is not False}
    run = scenario.run
    events = tuple(run.events) if run.events is not None else tuple(e.name for e in system.events)
    faults = [*system.checks(parameters), *_initial_faults(system, scenario.form, initial), *_run_faults(system, run)]
    if faults:
        raise ScenarioError(faults)
    law = system.laws[scenario.friction.law] if system.frictional else LAWS["none"]
    values = scenario.friction.model_dump() if system.frictional else {}
    built = Problem(
        system=system,
        form=system.forms[scenario.form],
        parameters=parameters,
        friction=law.record(*(values[n] for n in law.parameters)),
        friction_units=law.units(),
        initial=initial,
        until=run.until,
        times=_times(run),
        events=events,
        on_liftoff=run.on_liftoff,
        precision=run.precision,
        tolerance=run.tolerance,
        output=run.output,
        stop_when=run.stop_when,
    )
    _check_start(built)
    return built


def load(source: str, assignments: list[str] | None = None, until: float | None = None) -> Problem:
    """The Problem of a TOML file or preset, with `--set` assignments and another `until`. Raises ScenarioError."""
    tables = override(read(source), assignments or [])
    return problem(tables if until is None else ending(tables, until))


def ending(tables: dict[str, Any], until: float) -> dict[str, Any]:
    """The tables with another `run.until`; output times beyond it go."""
    tables = override(tables, [f"run.until={float(until)!r}"])
    times = tables["run"].get("output_times")
    if isinstance(times, list):
        tables["run"]["output_times"] = [t for t in times if isinstance(t, int | float) and t <= until]
    return tables


def tables_of(attrs: dict[str, Any]) -> dict[str, Any]:
    """The tables that a store's root attributes hold: what `resolved` wrote."""
    names = ("system", "form", "parameters", "friction", "initial", "run")
    return {name: attrs[name] for name in names if name in attrs}


def law_name(problem: Problem) -> str:
    """The name of the friction law of a problem, as in `[friction] law`."""
    laws = {**LAWS, **problem.system.laws}
    return next(name for name, law in laws.items() if law.record is type(problem.friction))


def resolved(problem: Problem) -> dict[str, Any]:
    """The scenario as it was understood, defaults filled in: plain data, also what the store keeps."""
    return {
        "system": problem.system.name,
        "form": problem.form.name,
        "parameters": dict(problem.parameters),
        **({"friction": {"law": law_name(problem), **problem.friction._asdict()}} if problem.system.frictional else {}),
        "initial": dict(problem.initial),
        "run": {
            "until": problem.until,
            **_output(problem),
            "events": list(problem.events),
            "on_liftoff": problem.on_liftoff,
            "precision": problem.precision,
            "tolerance": problem.tolerance,
            "stop_when": problem.stop_when,
        },
    }


def _output(problem: Problem) -> dict[str, Any]:
    """The keys of [run] that say when rows are wanted."""
    if problem.output != "times":
        return {"output": problem.output}
    if isinstance(problem.times, Grid):
        return {"output_step": problem.times.step}
    return {"output_times": problem.times.times.tolist()}


def _initial_faults(system: System, form: str, initial: dict[str, Any]) -> list[str]:
    faults = []
    if "psi_dot" in initial and "omega3" in initial:
        faults.append("`initial.psi_dot` must stand alone, but `initial.omega3` is given too.")
    if initial.get("centre_at_rest") and ("nu_x" in initial or "nu_y" in initial):
        faults.append("`initial.centre_at_rest` must stand alone, but `initial.nu_x` or `initial.nu_y` is given too.")
    singular = form in system.forms and POLE in system.forms[form].hazards
    if singular and initial.get("theta", 0.0) in (0.0, math.pi):
        faults.append(f'`initial.theta` must not be 0 or pi where form = "{form}" is singular; form = "vector" can.')
    return faults


def _run_faults(system: System, run: _Run) -> list[str]:
    faults = []
    known = [event.name for event in system.events]
    faults += [
        f"`run.events` must be of {', '.join(known)}, but has {e!r}." for e in run.events or [] if e not in known
    ]
    if run.output_step is not None and run.output_times is not None:
        faults.append("`run.output_step` must stand alone, but `run.output_times` is given too.")
    if run.output_step is not None and not run.until / run.output_step <= MOST_ROWS:
        faults.append(
            f"`run.output_step` must give at most {MOST_ROWS:.0e} rows, but {run.output_step:g} gives "
            f"{run.until / run.output_step:.3g}."
        )
    if run.output != "times" and (run.output_step is not None or run.output_times is not None):
        faults.append('`run.output` must be "times" where `run.output_step` or `run.output_times` is given.')
    times = run.output_times or []
    if any(b <= a for a, b in itertools.pairwise(times)):
        faults.append("`run.output_times` must ascend strictly, but do not.")
    if times and times[-1] > run.until:
        faults.append(f"`run.output_times` must not exceed run.until = {run.until:g}, but reach {times[-1]:g}.")
    return faults


def _times(run: _Run) -> Grid | Given:
    """Times of the rows [s]; a grid always ends with `until` itself."""
    if run.output_times is not None:
        return Given(np.array(run.output_times, dtype=float))
    return Grid(run.output_step or run.until / 1000, run.until)


def _check_start(built: Problem) -> None:
    """Numbers that are finite one by one may still overflow together, or start where the model has no solution."""
    with np.errstate(all="ignore"):
        try:
            start, view = built.start()[None, :], View(built)
            numbers = [leaves(built.internal_body), start[0], built.weights(built.form)]
            values = view.values(start)
            numbers.append([values[quantity.name][0] for quantity in built.system.quantities])
            finite = all(math.isfinite(float(v)) for group in numbers for v in group)
        except (OverflowError, ZeroDivisionError):
            finite = False
        if not finite:
            raise ScenarioError(["`parameters` and `initial` must stay finite together, but they overflow."])
        hazards = view.hazards(start)
    for meaning, least in hazards.items():
        if not least > 0:
            raise ScenarioError([f"`initial` must allow a motion, but {meaning}."])


def _sentence(error: Any, tables: dict[str, Any], shape: type[BaseModel]) -> str:
    """One pydantic error of a scenario as `key` must ..., but is ...."""
    laws = SYSTEMS[tables["system"]].laws
    place = [p for p in error["loc"] if not (p in laws and error["loc"][0] == "friction")]
    key, context, kind = ".".join(map(str, place)), error.get("ctx", {}), error["type"]
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        found = repr(context.get("tag")) if kind == "union_tag_invalid" else "missing"
        return f"`{key}.law` must be one of {', '.join(laws)}, but is {found}."
    return worded(error, key, _known(tables, shape, place) if kind == "extra_forbidden" else [])


def _known(tables: dict[str, Any], shape: type[BaseModel], place: list) -> list[str]:
    """The keys that a table of the scenario may have."""
    if place[0] == "friction" and len(place) > 1:
        return ["law", *SYSTEMS[tables["system"]].laws[tables["friction"]["law"]].parameters]
    model: Any = shape
    for part in place[:-1]:
        annotation = model.model_fields[part].annotation
        model = next((a for a in get_args(annotation) if hasattr(a, "model_fields")), annotation)
    return list(model.model_fields)


assert set(PRECISIONS) == set(get_args(_Run.model_fields["precision"].annotation))
