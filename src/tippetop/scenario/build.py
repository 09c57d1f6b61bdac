"""A scenario's tables become a checked Problem, or sentences that say all that is wrong
with them.
"""

import math
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..arguments import measured, path_of, plain
from ..errors import InputError, first_sentences, suggestion
from ..mechanics.contact.gliding.catalogue import AWAY_FROM_POLE
from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.friction import LAWS
from ..mechanics.quantity import worked_out
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS, find, load_entry_points
from ..mechanics.units import SECOND, Unit
from ..problem import (
    AUTO,
    TURN,
    Problem,
    choice,
    column_faults,
    column_names,
    kept_faults,
    shape_faults,
)
from ..problem.options import KEYFRAME_STEPS, NUMBERS, RunOptions
from .contact import contact_faults, contact_tables, on_stem, rules_of, system_with_contact
from .law_change import law_name
from .own_records import other_records, own_records
from .reading import override, read, times_until
from .schema import scenario_model
from .sentences import scenario_sentence


# [rad] where z = cos(theta) is integrated: its rounding changes theta by 2.2e-15/theta in 4 s,
NEAREST_POLE = 1e-3
# measured against the vector form from 1.9e-5 to 0.3 rad. As sqrt(t), that is the promise, 1e-10
# rad, after 1e4 s


# --- checking -----------------------------------------------------------------------------------


def problem(
    tables: dict[str, Any], known: System | None = None, origin: dict[str, Any] | None = None
) -> Problem:
    """The checked Problem of a scenario's tables.

    Raises InputError with every fault that was found.

    `known` is the record of the system, where it is not the registered one of that name; `origin`
    the exact state in which the run starts, where that is the end of another.
    """
    system = system_with_contact(known or system_of(tables), tables)
    name = law_name(tables)
    if name is not None and name not in system.laws:
        load_entry_points()
    tables = worked_out(tables, units_of(system, tables))
    shape = scenario_model(system)
    try:
        scenario: Any = shape.model_validate(tables)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        sentences = first_sentences(errors, lambda e: scenario_sentence(e, system, tables, shape))
        raise InputError(sentences) from None
    parameters = scenario.parameters.model_dump()
    initial = {
        k: v for k, v in scenario.initial.model_dump().items() if v is not None and v is not False
    }
    asked: dict[str, Any] = {
        key: tuple(v) if isinstance(v, list) else v for key, v in scenario.run.model_dump().items()
    }
    run = RunOptions(**asked)
    system = system.with_requested(run.columns or ())
    law = system.laws[scenario.friction.law] if system.frictional else LAWS["none"]
    form = choice(system).form if scenario.form == AUTO else system.forms[scenario.form]
    known_columns = column_names(system, form, run.orientation is not False, run.precision)
    values = scenario.friction.model_dump() if system.frictional else {}
    rules, kinds = rules_of(scenario, system), tuple(event.name for event in system.events)
    turns = any(name in TURN for name in (TURN if run.columns is None else run.columns))
    del asked["output_step"], asked["output_times"]
    asked |= {
        "events": kinds if run.events is None else run.events,
        "on_liftoff": run.on_liftoff or ("stop" if system.contact is None else "fly"),
        "keyframe_steps": run.keyframe_steps or KEYFRAME_STEPS,
        "columns": _columns(run.columns, known_columns, known),
        "orientation": turns if run.orientation is None else run.orientation,
        "sensitivities": run.sensitivities or (),
    }
    built = Problem(
        system=system,
        form=form,
        parameters=parameters,
        friction=law._make(values[name] for name in law.parameters),
        initial=on_stem(initial, parameters.get("R", 0.0), rules),
        times=run.rows(),
        contact=rules,
        origin=origin,
        **asked,
    )
    faults = [
        *system.checks(parameters),
        *built.clashes(),
        *contact_faults(built),
        *_pole_faults(built),
        *run.option_faults(kinds),
        *column_faults(run.columns or [], known_columns, run.orientation),
        *kept_faults(built),
    ] or built.start_faults()
    if faults:
        raise InputError(faults)
    vars(built)["checked"] = True
    return built


def checked(given: Problem) -> Problem:
    """A problem that was checked as it is; any other, such as dataclasses.replace makes, as its
    scenario would give it. Raises InputError.
    """
    if given.checked:
        return given
    if faults := shape_faults(given):
        raise InputError(faults)
    known = given.system if given.system.contact is None or any(own_records(given.system)) else None
    return problem(plain(resolved(given)), known, given.origin)


def _columns(
    asked: tuple[str, ...] | None, all_columns: tuple[str, ...], known: System | None
) -> tuple[str, ...] | None:
    """The columns that rows have, None for all; by name where the system is not the registered one,
    so that its store says which columns it has.
    """
    if asked is None and (known is None or known is find(known.name)):
        return None
    return tuple(name for name in all_columns if asked is None or name in asked)


def units_of(system: System, tables: dict[str, Any]) -> dict[str, dict[str, Unit]]:
    """What the numbers of a scenario measure, by table and key: where a text may stand for one."""
    law = system.laws.get(law_name(tables) or "")
    rules = {
        "parameters": system.parameters,
        "friction": law.parameters if law else {},
        "initial": system.initial,
        "stem": STEM,
        "contact": CONTACT,
    }
    units = {table: {name: rule.unit for name, rule in its.items()} for table, its in rules.items()}
    return units | {"run": NUMBERS}


def system_of(tables: dict[str, Any]) -> System:
    """The registered system that a scenario names. Raises InputError."""
    name = tables.get("system")
    system = find(name) if isinstance(name, str) else None
    if system is None:
        given = "is missing" if name is None else f"is {name!r}"
        near = suggestion(name, SYSTEMS) if isinstance(name, str) else ""
        raise InputError(f"`system` must be one of {', '.join(SYSTEMS)}, but {given}.{near}")
    return system


def load(
    source: str | Path, assignments: list[str] | None = None, until: float | None = None
) -> Problem:
    """The checked Problem of a TOML file or a preset, with `--set` assignments and another end: as
    `tippetop.load`, but of a run that does not start from another. Raises InputError.
    """
    tables = override(read(str(path_of("source", source))), assignments or [])
    return problem(tables if until is None else ending(tables, until))


def ending(tables: dict[str, Any], until: Any) -> dict[str, Any]:
    """The tables with another `run.until`, which may be a text with a unit; output times beyond it
    go.
    """
    until = measured("until", until, SECOND)
    tables = override(tables, [f"run.until={until!r}"])
    times = tables["run"].get("output_times")
    if isinstance(times, list):
        tables["run"]["output_times"] = times_until(times, until)
    return tables


def tables_of(attrs: dict[str, Any]) -> dict[str, Any]:
    """The tables that a store's root attributes hold: what `resolved` wrote."""
    names = ("system", "form", "parameters", "friction", "contact", "stem", "initial", "run")
    return {name: attrs[name] for name in names if name in attrs}


def stored(
    attrs: dict[str, Any], until: float | None = None, known: System | None = None
) -> Problem:
    """The Problem of a store's root attributes, or one with another end.

    Raises InputError; so it does where an event or a column is not the one that the run was made
    with.

    `known` is the record of its system where that has events and columns of the user's own."""
    tables = tables_of(attrs)
    try:
        result = problem(
            tables if until is None else ending(tables, until), known, origin=attrs.get("start")
        )
    except InputError:
        if own := own_names(attrs, known):
            raise InputError(_give(own, attrs["system"])) from None
        raise
    if faults := other_records(attrs, result, known):
        raise InputError(faults)
    return result


def own_names(attrs: dict[str, Any], known: System | None = None) -> list[str]:
    """The events and columns of a stored run that its system does not have: whoever made it gave
    them.
    """
    system = known or system_of(tables_of(attrs))
    if "contact" in attrs:  # takes none
        return []
    events = {event.name for event in system.events}
    form = system.forms.get(attrs["form"], next(iter(system.forms.values())))
    columns = {
        "time",
        *TURN,
        *column_names(system, form, orientation=True, precision=attrs["precision"]),
    }
    run = attrs["run"]
    return [n for n in run["events"] if n not in events] + [
        n for n in run.get("columns", ()) if n not in columns
    ]


def _give(own: list[str], system: str) -> str:
    names = ", ".join(f"`{name}`" for name in own)
    return (
        f"the run has {names}, which {system} has not: give the records that it was made with, "
        "as in Python "
        "tippetop.resume(path, events=[...], columns=[...]); tippetop.open takes them too."
    )


def resolved(problem: Problem) -> dict[str, Any]:
    """The scenario as it was understood, defaults filled in: plain data, also what the
    store keeps.
    """
    return {
        "system": problem.system.name,
        "form": problem.form.name,
        "parameters": dict(problem.parameters),
        **(
            {"friction": {"law": problem.law_name, **problem.friction._asdict()}}
            if problem.system.frictional
            else {}
        ),
        **contact_tables(problem),
        "initial": dict(problem.initial),
        "run": problem.table(),
    }


def _pole_faults(problem: Problem) -> list[str]:
    if AWAY_FROM_POLE not in problem.form.domains:
        return []
    name, theta = problem.form.name, problem.initial.get("theta", 0.0)
    if (
        "z_dot" in problem.variables.names
        and 0 < (near := min(theta, math.pi - theta)) < (1 - 1e-9) * NEAREST_POLE
    ):
        return [
            f"`initial.theta` must be at least {NEAREST_POLE:g} rad from the poles 0 and pi "
            "where form = "
            f'"{name}" is singular, but is {near:.3g} from one: form = "vector" can.'
        ]
    if theta not in (0.0, math.pi):
        return []
    return [
        f'`initial.theta` must not be 0 or pi where form = "{name}" is singular; form = '
        '"vector" can.'
    ]
