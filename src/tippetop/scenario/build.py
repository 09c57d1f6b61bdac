"""A scenario's tables become a checked Problem, or sentences that say all that is wrong with them."""

import itertools
import math
from pathlib import Path
from typing import Any, get_args

import numpy as np
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
    KEYFRAME_STEPS,
    PRECISIONS,
    ROUNDING,
    TURN,
    UNTIL,
    Problem,
    choice,
    column_faults,
    column_names,
    kept_faults,
    shape_faults,
)
from ..sampling import EvenTimes, ListedTimes
from .contact import contact_faults, contact_tables, on_stem, rules_of, system_with_contact
from .own_records import other_records, own_records
from .reading import override, read, times_until
from .schema import RunTable, scenario_model
from .sentences import scenario_sentence


LEAST_TOLERANCE = 1e-5  # of the rounding unit: 2.2e-21 in double. Over 200 s of rolling in vector form, 1e-20 and
# 1e-21 change E no less than 0 does (1.4e-14, 1.7e-14; 1.5e-14), and compile in 46 s where 1e-18 takes 32 s
NEAREST_POLE = 1e-3  # [rad] where z = cos(theta) is integrated: its rounding changes theta by 2.2e-15/theta in 4 s,
# measured against the vector form from 1.9e-5 to 0.3 rad. As sqrt(t), that is the promise, 1e-10 rad, after 1e4 s
MOST_ROWS = 10**12  # more is a slip of the pen: 200 TB


# --- checking -------------------------------------------------------------------------------------------------------


def problem(tables: dict[str, Any], known: System | None = None, origin: dict[str, Any] | None = None) -> Problem:
    """The checked Problem of a scenario's tables. Raises InputError with every fault that was found.

    `known` is the record of the system, where it is not the registered one of that name; `origin` the exact state in
    which the run starts, where that is the end of another."""
    system = system_with_contact(known or system_of(tables), tables)
    law = tables["friction"].get("law") if isinstance(tables.get("friction"), dict) else None
    if isinstance(law, str) and law not in system.laws:
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
    initial = {k: v for k, v in scenario.initial.model_dump().items() if v is not None and v is not False}
    run = scenario.run
    system = system.with_requested(run.columns or ())
    events = tuple(run.events) if run.events is not None else tuple(e.name for e in system.events)
    law = system.laws[scenario.friction.law] if system.frictional else LAWS["none"]
    form = choice(system).form if scenario.form == AUTO else system.forms[scenario.form]
    known_columns = column_names(system, form, run.orientation is not False, run.precision)
    asked = TURN if run.columns is None else run.columns
    values = scenario.friction.model_dump() if system.frictional else {}
    rules = rules_of(scenario, system)
    built = Problem(
        system=system,
        form=form,
        parameters=parameters,
        friction=law._make(values[name] for name in law.parameters),
        initial=on_stem(initial, parameters.get("R", 0.0), rules),
        until=run.until,
        times=_times(run),
        events=events,
        on_liftoff=run.on_liftoff or ("stop" if system.contact is None else "fly"),
        precision=run.precision,
        tolerance=run.tolerance,
        output=run.output,
        keyframe_steps=run.keyframe_steps or KEYFRAME_STEPS,
        stop_when=run.stop_when,
        columns=_columns(run.columns, known_columns, known),
        orientation=run.orientation if run.orientation is not None else any(name in TURN for name in asked),
        sensitivities=tuple(run.sensitivities or ()),
        contact=rules,
        origin=origin,
    )
    faults = [
        *system.checks(parameters),
        *built.clashes(),
        *contact_faults(built),
        *_pole_faults(built),
        *_run_faults(system, run),
        *column_faults(run.columns or [], known_columns, run.orientation),
        *kept_faults(built),
    ] or built.start_faults()
    if faults:
        raise InputError(faults)
    vars(built)["checked"] = True
    return built


def checked(given: Problem) -> Problem:
    """A problem that was checked as it is; any other, such as dataclasses.replace makes, as its scenario would give it.
    Raises InputError."""
    if given.checked:
        return given
    if faults := shape_faults(given):
        raise InputError(faults)
    known = given.system if given.system.contact is None or any(own_records(given.system)) else None
    return problem(plain(resolved(given)), known, given.origin)


def _columns(asked: list[str] | None, all_columns: tuple[str, ...], known: System | None) -> tuple[str, ...] | None:
    """The columns that rows have, None for all; by name where the system is not the registered one, so that its store
    says which columns it has."""
    if asked is None and (known is None or known is find(known.name)):
        return None
    return tuple(name for name in all_columns if asked is None or name in asked)


def units_of(system: System, tables: dict[str, Any]) -> dict[str, dict[str, Unit]]:
    """What the numbers of a scenario measure, by table and key: where a text may stand for one."""
    friction = tables.get("friction")
    given = friction.get("law") if isinstance(friction, dict) else None
    law = system.laws.get(given) if isinstance(given, str) else None
    rules = {
        "parameters": system.parameters,
        "friction": law.parameters if law else {},
        "initial": system.initial,
        "stem": STEM,
        "contact": CONTACT,
        "run": {"until": UNTIL, "output_step": UNTIL},
    }
    return {table: {name: rule.unit for name, rule in its.items()} for table, its in rules.items()}


def system_of(tables: dict[str, Any]) -> System:
    """The registered system that a scenario names. Raises InputError."""
    name = tables.get("system")
    system = find(name) if isinstance(name, str) else None
    if system is None:
        given = "is missing" if name is None else f"is {name!r}"
        near = suggestion(name, SYSTEMS) if isinstance(name, str) else ""
        raise InputError([f"`system` must be one of {', '.join(SYSTEMS)}, but {given}.{near}"])
    return system


def load(source: str | Path, assignments: list[str] | None = None, until: float | None = None) -> Problem:
    """The checked Problem of a TOML file or a preset, with `--set` assignments and another end: as `tippetop.load`, but
    of a run that does not start from another. Raises InputError."""
    tables = override(read(str(path_of("source", source))), assignments or [])
    return problem(tables if until is None else ending(tables, until))


def ending(tables: dict[str, Any], until: Any) -> dict[str, Any]:
    """The tables with another `run.until`, which may be a text with a unit; output times beyond it go."""
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


def stored(attrs: dict[str, Any], until: float | None = None, known: System | None = None) -> Problem:
    """The Problem of a store's root attributes, or one with another end. Raises InputError; so it does where an event
    or a column is not the one that the run was made with.

    `known` is the record of its system where that has events and columns of the user's own."""
    tables = tables_of(attrs)
    try:
        result = problem(tables if until is None else ending(tables, until), known, origin=attrs.get("start"))
    except InputError:
        if own := own_names(attrs, known):
            raise InputError([_give(own, attrs["system"])]) from None
        raise
    if faults := other_records(attrs, result, known):
        raise InputError(faults)
    return result


def own_names(attrs: dict[str, Any], known: System | None = None) -> list[str]:
    """The events and columns of a stored run that its system does not have: whoever made it gave them."""
    system = known or system_of(tables_of(attrs))
    if "contact" in attrs:  # takes none
        return []
    events = {event.name for event in system.events}
    form = system.forms.get(attrs["form"], next(iter(system.forms.values())))
    columns = {"time", *TURN, *column_names(system, form, orientation=True, precision=attrs["precision"])}
    run = attrs["run"]
    return [n for n in run["events"] if n not in events] + [n for n in run.get("columns", ()) if n not in columns]


def _give(own: list[str], system: str) -> str:
    names = ", ".join(f"`{name}`" for name in own)
    return (
        f"the run has {names}, which {system} has not: give the records that it was made with, as in Python "
        "tippetop.resume(path, events=[...], columns=[...]); tippetop.open takes them too."
    )


def resolved(problem: Problem) -> dict[str, Any]:
    """The scenario as it was understood, defaults filled in: plain data, also what the store keeps."""
    return {
        "system": problem.system.name,
        "form": problem.form.name,
        "parameters": dict(problem.parameters),
        **({"friction": {"law": problem.law_name, **problem.friction._asdict()}} if problem.system.frictional else {}),
        **contact_tables(problem),
        "initial": dict(problem.initial),
        "run": {
            "until": problem.until,
            **_output(problem),
            "events": list(problem.events),
            "on_liftoff": problem.on_liftoff,
            "precision": problem.precision,
            "tolerance": problem.tolerance,
            "stop_when": problem.stop_when,
            "orientation": problem.orientation,
            **({} if problem.columns is None else {"columns": list(problem.columns)}),
            **({"sensitivities": list(problem.sensitivities)} if problem.sensitivities else {}),
        },
    }


def _output(problem: Problem) -> dict[str, Any]:
    """The keys of [run] that say when rows are wanted."""
    if problem.output == "keyframes":
        return {"output": problem.output, "keyframe_steps": problem.keyframe_steps}
    if problem.output != "times":
        return {"output": problem.output}
    if isinstance(problem.times, EvenTimes):
        return {"output_step": problem.times.step}
    return {"output_times": problem.times.times.tolist()}


def _pole_faults(problem: Problem) -> list[str]:
    if AWAY_FROM_POLE not in problem.form.domains:
        return []
    name, theta = problem.form.name, problem.initial.get("theta", 0.0)
    if "z_dot" in problem.variables.names and 0 < (near := min(theta, math.pi - theta)) < (1 - 1e-9) * NEAREST_POLE:
        return [
            f"`initial.theta` must be at least {NEAREST_POLE:g} rad from the poles 0 and pi where form = "
            f'"{name}" is singular, but is {near:.3g} from one: form = "vector" can.'
        ]
    if theta not in (0.0, math.pi):
        return []
    return [f'`initial.theta` must not be 0 or pi where form = "{name}" is singular; form = "vector" can.']


def _run_faults(system: System, run: RunTable) -> list[str]:
    faults = []
    known = [event.name for event in system.events]
    faults += [
        f"`run.events` must be of {', '.join(known)}, but has {e!r}.{suggestion(e, known)}"
        for e in run.events or []
        if e not in known
    ]
    if run.output_step is not None and run.output_times is not None:
        faults.append(
            "`run.output_step` must stand alone, but `run.output_times` is given too: remove one "
            "(--set run.output_step=)."
        )
    if run.output_step is not None and not run.until / run.output_step <= MOST_ROWS:
        faults.append(
            f"`run.output_step` must give at most {MOST_ROWS:.0e} rows, but {run.output_step:g} gives "
            f"{run.until / run.output_step:.3g}."
        )
    faults += tolerance_faults(run.precision, run.tolerance)
    if run.output != "times" and (run.output_step is not None or run.output_times is not None):
        given = "output_step" if run.output_step is not None else "output_times"
        faults.append(
            f'`run.output` must be "times" where `run.{given}` is given, but is "{run.output}": remove one '
            f"(--set run.{given}=)."
        )
    if run.output != "keyframes" and run.keyframe_steps is not None:
        faults.append(
            f'`run.output` must be "keyframes" where `run.keyframe_steps` is given, but is "{run.output}": remove one '
            "(--set run.keyframe_steps=)."
        )
    times = run.output_times or []
    if any(b <= a for a, b in itertools.pairwise(times)):
        faults.append("`run.output_times` must ascend strictly, but do not.")
    if times and times[-1] > run.until:
        faults.append(f"`run.output_times` must not exceed run.until = {run.until:g}, but reach {times[-1]:g}.")
    return faults


def tolerance_faults(precision: str, tolerance: float) -> list[str]:
    """A tolerance far below the rounding unit costs order after order, and nothing comes of it."""
    least = LEAST_TOLERANCE * ROUNDING[precision]
    if tolerance == 0 or tolerance >= least:
        return []
    return [
        f"`run.tolerance` must be 0 (the rounding unit) or at least {least:.1g} in {precision} precision, but is "
        f"{tolerance:g}: rounding hides what lies below, and each power of ten takes longer to compile."
    ]


def _times(run: RunTable) -> EvenTimes | ListedTimes:
    """Times of the rows [s]; a grid always ends with `until` itself."""
    if run.output_times is not None:
        return ListedTimes(np.array(run.output_times, dtype=float))
    step = run.output_step or run.until / 1000 or run.until  # a thousandth may underflow
    return EvenTimes(step, run.until)


assert set(PRECISIONS) == set(get_args(RunTable.model_fields["precision"].annotation))
