"""The keys of a scenario, and the columns and events of a run, as tables made from the records.

Systems, laws and options go in; `Section`s come out, for `tippetop help` and the manual.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel

from ..mechanics.contact.opening import ABOVE, opened
from ..mechanics.contact.surroundings import RULES
from ..mechanics.friction import LAWS, PARTS, FrictionLaw
from ..mechanics.system import System
from ..mechanics.systems import (
    SYSTEMS,
    load_entry_points,
    opening_systems,
    surroundable_systems,
    systems_of_laws,
)
from ..problem.row_columns import every_source
from .schema import ContactTable, RunTable, StemTable, number_table, table_models


class Section(NamedTuple):
    """A table of a topic: its title, the text before it, and the words at its head."""

    title: str
    text: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


KEYS = ("key", "unit", "must be", "meaning")
KINDS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
}


def allowed(schema: Mapping[str, Any]) -> str:
    """Return the values that a JSON schema allows in words, such as "a number greater than 0".

    `must` is not of JSON schema: `schema._number` adds it to numbers.
    """
    if "must" in schema:
        return schema["must"]
    if "anyOf" in schema:
        return " or ".join(allowed(part) for part in schema["anyOf"] if part.get("type") != "null")
    if "enum" in schema:
        return f"one of {', '.join(schema['enum'])}"
    if "const" in schema:
        return f'"{schema["const"]}"'
    if schema.get("type") == "array":
        return f"a list, each {allowed(schema['items'])}"
    bound = f" at least {schema['minimum']:g}" if "minimum" in schema else ""
    return f"{KINDS.get(schema.get('type', ''), 'a table')}{bound}"


def keys_section(title: str, table: type[BaseModel], text: str = "") -> Section:
    """Return the section on the keys of a table."""
    return Section(title, text, KEYS, keys_of(table))


def keys_of(table: type[BaseModel]) -> list[tuple[str, str, str, str]]:
    """Return the keys of a table of a scenario or of a plan, as rows under KEYS.

    Parameters
    ----------
    table
        The model of the table, whose fields are described.

    Returns
    -------
    list of (key, unit, must be, meaning)
    """
    rows = []
    schema = table.model_json_schema()
    for name, field in schema["properties"].items():
        must = allowed(field)
        default = field.get("default")
        if default is not None:
            plain = f"{default:g}" if isinstance(default, float) else str(default).lower()
            must += f"; by default {plain}"
        elif field.get("optional"):
            must += "; may be left out"
        elif name in schema.get("required", ()):
            must += "; must be given"
        rows.append((name, field.get("unit", ""), must, field.get("description", "")))
    return rows


# --- topics -------------------------------------------------------------------------------------


def scenario() -> list[Section]:
    """Return sections on the keys of a scenario: an overview, then each table."""
    tables = {name: table_models(system) for name, system in SYSTEMS.items()}
    gliding = [s.name for s in SYSTEMS.values() if s.frictional]
    rows = [
        ("system", f"one of {', '.join(SYSTEMS)}"),
        (
            "form",
            "variables of the equations; by default auto: the cheapest form that is regular "
            "everywhere and keeps every column exact",
        ),
        ("[parameters]", "the body; its keys are those of its system"),
        ("[friction]", f"law, and its numbers; of {', '.join(gliding)}"),
        ("[initial]", 'the start; `from = "RUN.zarr"` instead: the end of another run'),
        ("[contact]", f"a contact that may open; of {', '.join(opening_systems())}"),
        ("[stem]", "the ball at the end of a stem; of tippe-top"),
        ("[air]", f"a torque that brakes the rotation; of {', '.join(surroundable_systems())}"),
        ("[plane]", "a plane that is tilted, vibrates or turns; of the same"),
        ("[run]", "end and accuracy of the run, and the rows and columns that are kept"),
    ]
    head = (
        'A TOML file. Numbers are SI, or texts with a unit or arithmetic: "20 g", "5.7 deg", '
        '"2/5*m*R^2".'
    )
    sections = [Section("A scenario", head, ("key or table", "meaning"), rows)]
    for table, text in (("parameters", ""), ("initial", "Numbers are 0 where they are left out.")):
        first: dict[Any, Section] = {}
        for name, system in SYSTEMS.items():
            words = [text] if text else []
            words += [
                f"`{a.name}` excludes {', '.join(a.others)}."
                for a in system.alternatives
                if table == "initial"
            ]
            section = keys_section(f"[{table}] of {name}", tables[name][table], " ".join(words))
            first.setdefault(tuple(key for key, *_ in section.rows), section)
        sections += first.values()
    air = "The torque about the centre of mass is -(c1 + c2 |omega|) omega."
    plane = (
        "A plane that is tilted or vibrates, or that turns: give the numbers of what it does. "
        "Axes, velocities and spins are those seen from the plane."
    )
    above = number_table(ABOVE, required=False)
    return [
        *sections,
        keys_section("[initial] of a contact that may open", above, "In addition to the others."),
        keys_section("[contact]", ContactTable),
        keys_section("[stem]", StemTable),
        keys_section("[air]", number_table(RULES["air"]), air),
        keys_section("[plane]", number_table(RULES["plane"]), plane),
        keys_section("[run]", RunTable),
    ]


def friction() -> list[Section]:
    """Return a section for each friction law: its numbers, and the systems that take it.

    A law whose optional numbers may be left out (`law.without`, such as Coulomb without eps) has a
    second section for that case. `PARTS`, rolling resistance and drilling, can be added to a law
    if one of its systems has a rounded contact.
    """
    load_entry_points()
    laws = systems_of_laws()
    for name, (law, _) in list(laws.items()):
        if law.without is not None:
            optional = ", ".join(key for key, rule in law.parameters.items() if rule.optional)
            laws[f"{name} (without {optional})"] = (law.without, list(opening_systems()))
    opening = opening_systems().items()
    rolling = {name for name, system in opening if system.opening and system.opening.rounded}
    return [
        keys_section(
            name,
            number_table({**law.parameters} | (PARTS if rolling & {*of} else {})),
            f"{_meaning(law)} For {', '.join(of) or 'no system'}.",
        )
        for name, (law, of) in laws.items()
    ]


def _meaning(law: type[FrictionLaw]) -> str:
    """Return the docstring of a law without its numbers."""
    return " ".join((law.__doc__ or "").partition("\n\nParameters\n")[0].split())


def systems_table() -> list[Section]:
    """Return one table of all systems: name, title, forms, integrals, source."""
    load_entry_points()
    rows = [
        (s.name, s.title, ", ".join(s.forms), ", ".join(s.integrals) or "none", s.source)
        for s in SYSTEMS.values()
    ]
    return [Section("Systems", "", ("system", "title", "forms", "integrals", "source"), rows)]


def _with_contact() -> list[System]:
    """Return the systems whose contact may open, with their phases, without and with a stem."""
    return [
        opened(system, LAWS["none"], balls)
        for system in opening_systems().values()
        for balls in ((1, 2) if system.opening and system.opening.sphere else (1,))
    ]


def events() -> list[Section]:
    """Return one section on the kinds of events, with the systems that have each."""
    rows: dict[str, list[Any]] = {}
    for system in (*SYSTEMS.values(), *_with_contact()):
        for event in system.events:
            rows.setdefault(event.name, [event, {}])[1][system.name] = None
    return [
        Section(
            "Events",
            "Zeros of a function of the state, found to rounding; `[run] events` names those "
            "that are logged.",
            ("event", "meaning", "ends a run as", "kept of every run", "systems"),
            [
                (
                    name,
                    event.long_name,
                    event.ends or "",
                    ", ".join(kept.name for kept in event.kept),
                    ", ".join(systems),
                )
                for name, (event, systems) in rows.items()
            ],
        )
    ]


COLUMNS = ("column", "unit", "meaning")


def columns() -> list[Section]:
    """Return a section on the columns of a run for each system, and one on contacts that open."""
    sections = [
        Section(f"Columns of {name}", "", COLUMNS, _column_rows(system))
        for name, system in SYSTEMS.items()
    ]
    known = {row for name in opening_systems() for row in _column_rows(SYSTEMS[name])}
    rows = dict.fromkeys(row for system in _with_contact() for row in _column_rows(system))
    new = [row for row in rows if row not in known]
    text = "In addition to the others, or instead."
    return [*sections, Section("Columns of a contact that may open", text, COLUMNS, new)]


def _column_rows(system: System) -> list[tuple[str, str, str]]:
    """Return a row (column, unit, meaning) for each column of a system, under COLUMNS.

    They are those of runs with orientation in the vector form, which has every column, then those
    that only `run.columns` adds. `columns` finds the new ones of a contact by comparing whole rows,
    so a column must have the same unit and meaning in all of them.
    """
    form = "vector" if system.vectors else next(iter(system.forms))
    rows = []
    for name, source in every_source(system, form).items():
        dims = f", (time, {source.dims[0]})" if source.dims else ""
        flags = f": {', '.join(source.flags)}" if source.flags else ""
        rows.append((name, source.unit.symbol, f"{source.long_name}{dims}{flags}"))
    rows += [
        (q.name, q.unit.symbol, f"{q.long_name}; only where `run.columns` names it")
        for q in system.on_request
    ]
    return rows


TOPICS = {
    "scenario": scenario,
    "friction": friction,
    "systems": systems_table,
    "events": events,
    "columns": columns,
}
"""The topics of `tippetop help`, by name."""
