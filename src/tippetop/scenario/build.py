"""A scenario's tables become a checked Problem, or sentences on all that is wrong with them.

Tables of TOML go in; `problem` returns a `Problem` or raises InputError. `library` and `runs` call
it; `stored` does the same with the attributes of a store.
"""

import math
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from ..arguments import PlainData, measured, not_among, plain
from ..errors import InputError
from ..mechanics.contact.gliding import AWAY_FROM_POLE
from ..mechanics.contact.restitution import ContactLaw
from ..mechanics.contact.surroundings import dotted_numbers
from ..mechanics.friction import LAWS, FrictionLaw
from ..mechanics.number import omission_faults, with_defaults
from ..mechanics.quantity import worked_out
from ..mechanics.system import Form, System
from ..mechanics.systems import SYSTEMS, find, load_entry_points
from ..mechanics.units import SECOND, Unit
from ..problem import (
    KEYFRAME_STEPS,
    TURN,
    Problem,
    column_faults,
    column_names,
    numbers_of,
)
from ..problem.options import UNITS, RunOptions
from ..sampling import EvenTimes, ListedTimes
from .contact import contact_faults, on_stem, rules_of, system_with_contact
from .identity import changed_records, missing_records, user_records
from .reading import law_name, override
from .schema import scenario_model
from .sentences import scenario_sentence


# [rad] where z = cos(theta) is integrated: its rounding changes theta by 2.2e-15/theta in 4 s,
# measured against the vector form from 1.9e-5 to 0.3 rad. As sqrt(t), that is the promise, 1e-10
# rad, after 1e4 s
NEAREST_POLE = 1e-3

# keys of a scenario, as the fields of `schema.scenario_model`: a change of one is a change of both
TABLES = (
    "system",
    "form",
    "parameters",
    "friction",
    "contact",
    "stem",
    "air",
    "plane",
    "initial",
    "run",
)


def problem(
    tables: PlainData, known: System | None = None, origin: PlainData | None = None
) -> Problem:
    """Return the checked Problem of a scenario's tables.

    Parameters
    ----------
    tables
        The scenario.
    known
        The record of the system, if it is not the registered one of that name.
    origin
        The exact state in which the run starts, if that is the end of another.

    Raises
    ------
    InputError
        With every fault that was found.
    """
    system = system_with_contact(known or system_of(tables), tables)
    name = law_name(tables)
    if name and name not in system.laws:
        load_entry_points()
    body: Any = tables.get("parameters")
    if isinstance(body, Mapping):
        tables = {**tables, "parameters": with_defaults(body, system.parameters)}
    tables = worked_out(tables, units_of(system, tables))
    try:
        model = scenario_model(system, system.laws.get(name))
        scenario: Any = model.model_validate(tables)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        raise InputError(errors, lambda e: scenario_sentence(e, system, tables)) from None
    given: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in scenario.run}
    run = RunOptions(**given)
    system = system.with_requested(run.columns or ())
    law = system.laws[scenario.friction.law] if system.frictional else LAWS["none"]
    form = system.forms.get(scenario.form) or next(iter(system.forms.values()))
    known_columns = column_names(system, form, run.orientation is not False, run.precision)
    columns = run.columns
    # with records of the user, columns are named, also in the store: the system alone has others
    if columns is not None or known not in (None, find(system.name)):
        columns = tuple(n for n in known_columns if run.columns is None or n in run.columns)
    rules = rules_of(scenario, system)
    kinds = tuple(event.name for event in system.events)
    parameters = dict(scenario.parameters)
    initial = {k: v for k, v in scenario.initial if v is not None}
    turns = run.columns is None or any(name in TURN for name in run.columns)
    del given["output_step"], given["output_times"]
    given |= {
        "events": kinds if run.events is None else run.events,
        "on_liftoff": run.on_liftoff or ("stop" if system.contact is None else "fly"),
        "keyframe_steps": run.keyframe_steps or KEYFRAME_STEPS,
        "columns": columns,
        "orientation": turns if run.orientation is None else run.orientation,
    }
    built = Problem(
        system=system,
        form=form,
        parameters=parameters,
        friction=law._make(getattr(scenario.friction, key) for key in law.parameters),
        initial=on_stem(initial, parameters, rules),
        times=run.rows(),
        contact=rules,
        surroundings=dotted_numbers(scenario.model_dump()),
        origin=origin,
        **given,
    )
    faults = [
        *(omission_faults(body, parameters, system.parameters) or system.checks(parameters)),
        *built.clashes(),
        *contact_faults(built),
        *_pole_faults(built),
        *run.option_faults(kinds),
        *(
            [f'`run.stop_when` must be "until" for {system.name}, in which nothing slides.']
            if run.stop_when == "settled" and not any(event.lasting for event in system.events)
            else []
        ),
        *column_faults(run.columns or (), known_columns, run.orientation),
    ] or [sentence for _, sentence in built.alone.checked[1]]
    if faults:
        raise InputError(faults)
    vars(built)["checked"] = True
    return built


KINDS: dict[str, Any] = {
    "system": System,
    "form": Form,
    "parameters": Mapping,
    "friction": FrictionLaw,
    "initial": Mapping,
    "times": EvenTimes | ListedTimes,
    "events": tuple | list,
    "columns": tuple | list | None,
    "contact": ContactLaw | None,
}
"""The types of fields that are read before a problem is checked."""


def checked(given: Problem) -> Problem:
    """Return a problem that was checked, or check one that dataclasses.replace made.

    Raises InputError.
    """
    if given.checked:
        return given
    faults = [
        f"`{name}` of a Problem must be a "
        f"{kind.__name__ if isinstance(kind, type) else kind}, but is {getattr(given, name)!r:.60}."
        for name, kind in KINDS.items()
        if not isinstance(getattr(given, name), kind)
    ]
    if faults:
        raise InputError(faults)
    # `system_with_contact` opens the contact of the registered system again
    opened = given.system.contact is not None and not any(user_records(given.system))
    return problem(plain(resolved(given)), None if opened else given.system, given.origin)


def units_of(system: System, tables: PlainData) -> dict[str, dict[str, Unit]]:
    """Return the units of the numbers of a scenario, by table and key."""
    law = system.laws.get(law_name(tables))
    numbers = numbers_of(system, law.given(tables["friction"]).parameters if law else {})
    units = {table: {name: n.unit for name, n in its.items()} for table, its in numbers.items()}
    return units | {"run": UNITS}


def system_of(tables: PlainData) -> System:
    """Return the registered system that a scenario names. Raises InputError."""
    name = tables.get("system")
    system = find(name) if isinstance(name, str) else None
    if name is None and "axis" in tables:
        raise InputError("this must be a scenario, but is the plan of a sweep: a sweep runs it.")
    if system is None:
        raise InputError(not_among("system", name, SYSTEMS))
    return system


def ending(tables: PlainData, until: Any) -> PlainData:
    """Return the tables with another `run.until`, a number or a text; None keeps it.

    Raises InputError.
    """
    if until is None:
        return tables
    return override(tables, [f"run.until={measured('until', until, SECOND)!r}"])


def tables_of(attrs: PlainData) -> PlainData:
    """Return the scenario in a store's root attributes, as `resolved` made it: tables by name."""
    return {name: attrs[name] for name in TABLES if name in attrs}


def stored(attrs: PlainData, until: float | None = None, known: System | None = None) -> Problem:
    """Return the Problem of a store's root attributes, or one with another end.

    Parameters
    ----------
    attrs
        The root attributes.
    until
        Another end [s].
    known
        The record of its system, if that has user-defined events and columns.

    Raises
    ------
    InputError
        Also if an event or a column is not the one that the run was made with.
    """
    tables = tables_of(attrs)
    if names := missing_records(attrs, known or system_of(tables)):
        raise InputError(
            f"the run has {', '.join(f'`{name}`' for name in names)}, which {attrs['system']} has "
            "not: give the records that it was made with, as in Python "
            "tippetop.resume(path, events=[...], columns=[...]); tippetop.open takes them too."
        )
    result = problem(ending(tables, until), known, origin=attrs.get("start"))
    if faults := changed_records(attrs, result, known):
        raise InputError(faults)
    return result


def resolved(problem: Problem) -> PlainData:
    """Return the scenario with all defaults as plain data, which a store keeps too.

    `stored` makes an equal problem of it. The law comes first in `friction`, where
    `runs.attributes.headline_of` takes it.
    """
    tables: PlainData = {name: dict(table) for name, table in problem.tables.items()}
    tables["run"] = problem.table()
    if problem.system.frictional:
        tables["friction"] = {"law": problem.law.key, **tables["friction"]}
    else:
        del tables["friction"]
    if problem.contact is not None:
        tables["contact"] = {"restitution": problem.contact.restitution, **tables["contact"]}
    return {"system": problem.system.name, "form": problem.form.name, **tables}


def _pole_faults(problem: Problem) -> list[str]:
    """Return a sentence about a start too near a pole where the form is singular."""
    theta = problem.initial.get("theta", 0.0)
    near = min(theta, math.pi - theta)
    form = f'where form = "{problem.form.name}" is singular'
    if AWAY_FROM_POLE not in problem.form.domains:
        return []
    if near == 0:
        return [f'`initial.theta` must not be 0 or pi {form}; form = "vector" can.']
    # 1e-9: a start at NEAREST_POLE itself is allowed, also if it is rounded
    if "z_dot" not in problem.variables.names or not 0 < near < (1 - 1e-9) * NEAREST_POLE:
        return []
    return [
        f"`initial.theta` must be at least {NEAREST_POLE:g} rad from the poles 0 and pi {form}, "
        f'but is {near:.3g} from one: form = "vector" can.'
    ]
