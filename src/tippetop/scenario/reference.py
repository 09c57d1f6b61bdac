"""What a scenario may hold and what a run says, as tables made from the records: for `tippetop
help` and the manual.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel

from ..mechanics.contact.opening import ABOVE, opened
from ..mechanics.contact.restitution import CONTACT, STEM
from ..mechanics.event import Event
from ..mechanics.friction import LAWS, PARTS, FrictionLaw
from ..mechanics.number import Number
from ..mechanics.system import System
from ..mechanics.systems import SYSTEMS, load_entry_points, opening_systems, systems_of_laws
from ..mechanics.units import Unit
from ..problem import ORIENTATION, PSI
from ..problem.options import UNITS, UNTIL
from .schema import ContactTable, RunTable


class Section(NamedTuple):
    """A table of a topic, with its title, what comes before it, and the words at its head."""

    title: str
    text: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


KEYS = ("key", "unit", "what it must be", "what it is")
KINDS = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
}
BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
}
FLAGS = "true, or left out"


# --- numbers, and keys of other types -----------------------------------------------------------


def _number(name: str, rule: Number, *, optional: bool) -> tuple[str, ...]:
    must = rule.must().removeprefix("must be ")
    if rule.default is not None:
        must += f"; {rule.default:g} where it is left out"
    elif optional:
        must += "; 0 where it is left out"
    return name, rule.unit.symbol, must, rule.long_name


def _numbers(rules: Mapping[str, Number], *, optional: bool = False) -> list[tuple[str, ...]]:
    return [_number(name, rule, optional=optional) for name, rule in rules.items()]


def allowed(schema: Mapping[str, Any]) -> str:
    """Return in words what a value must be, such as "a number greater than 0", of its
    JSON schema.
    """
    if "anyOf" in schema:
        return " or ".join(allowed(part) for part in schema["anyOf"] if part.get("type") != "null")
    if "enum" in schema:
        return f"one of {', '.join(schema['enum'])}"
    if schema.get("type") == "array":
        return f"a list, each {allowed(schema['items'])}"
    bounds = ", ".join(
        f"{words} {schema[bound]:g}" for bound, words in BOUNDS.items() if bound in schema
    )
    return f"{KINDS.get(schema.get('type', ''), 'a table')} {bounds}".strip()


def keys_of(
    table: type[BaseModel], rules: Mapping[str, Number], units: Mapping[str, Unit] | None = None
) -> list[tuple[str, ...]]:
    """The keys of a table of a scenario or of a plan.

    Parameters
    ----------
    table
        The model of the table, whose fields are described.
    rules
        The numbers among them that have a record, by key.
    units
        Units of the others.

    Returns
    -------
    list of (key, unit, what it must be, what it is)
    """
    rows: list[tuple[str, ...]] = []
    schema = table.model_json_schema()
    for name, field in schema["properties"].items():
        if name in rules:
            rule = rules[name]
            must = rule.must().removeprefix("must be ")
            text, unit = field.get("description", rule.long_name), rule.unit.symbol
        else:
            must, text = allowed(field), field.get("description", "")
            unit = (units or {})[name].symbol if name in (units or {}) else ""
        if name in schema.get("required", ()):
            must += "; must be given"
        elif field.get("default") is not None:
            must += f"; {_plain(field['default'])} where it is left out"
        rows.append((name, unit, must, text))
    return rows


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


# --- topics -------------------------------------------------------------------------------------


def scenario() -> list[Section]:
    """The keys of a scenario."""
    gliding = [s for s in SYSTEMS.values() if s.frictional]
    return [
        Section(
            "A scenario",
            'A TOML file. Numbers are SI, or texts with a unit or arithmetic: "20 g", "5.7 '
            'deg", "2/5*m*R^2".',
            ("key or table", "what it is"),
            [
                ("system", f"one of {', '.join(SYSTEMS)}"),
                (
                    "form",
                    "how the state is written; auto where it is left out: the cheapest that is "
                    "regular there",
                ),
                ("[parameters]", "the body; its keys are those of its system"),
                ("[friction]", f"law, and its numbers; of {', '.join(s.name for s in gliding)}"),
                ("[initial]", 'the start; `from = "RUN.zarr"` instead: the end of another run'),
                ("[contact]", f"a contact that may open; of {', '.join(opening_systems())}"),
                ("[stem]", "the ball at the end of a stem; of tippe-top"),
                ("[run]", "how long, how accurately, and what is kept"),
            ],
        ),
        *(
            Section(f"[parameters] of {system.name}", "", KEYS, _numbers(system.parameters))
            for system in _first_of_each(lambda s: tuple(s.parameters))
        ),
        *(
            Section(
                f"[initial] of {system.name}",
                _alternatives(system),
                KEYS,
                _numbers(system.initial, optional=True) + _flags(system),
            )
            for system in _first_of_each(lambda s: tuple(s.initial))
        ),
        Section(
            "[initial] of a contact that may open",
            "Beside the others.",
            KEYS,
            _numbers(ABOVE, optional=True),
        ),
        Section("[contact]", "", KEYS, keys_of(ContactTable, CONTACT)),
        Section("[stem]", "", KEYS, _numbers(STEM)),
        Section("[run]", "", KEYS, keys_of(RunTable, {"until": UNTIL}, UNITS)),
    ]


def _first_of_each(kind: Any) -> list[System]:
    """The systems, without those that say the same as one before."""
    first: dict[Any, System] = {}
    for system in SYSTEMS.values():
        first.setdefault(kind(system), system)
    return list(first.values())


def _alternatives(system: System) -> str:
    return " ".join(
        f"`{a.name}` stands alone: without {', '.join(a.others)}." for a in system.alternatives
    )


def _flags(system: System) -> list[tuple[str, ...]]:
    meaning = "the centre of mass does not move sideways"
    return [(a.name, "", FLAGS, meaning) for a in system.alternatives if a.flag]


def friction() -> list[Section]:
    """The friction laws and their numbers."""
    load_entry_points()
    laws = systems_of_laws()
    for name, (law, _) in list(laws.items()):
        if law.without is not None:
            optional = ", ".join(key for key, rule in law.parameters.items() if rule.optional)
            laws[f"{name} (without {optional})"] = (law.without, list(opening_systems()))
    opening = opening_systems().items()
    rolling = {name for name, system in opening if system.opening and system.opening.sphere}
    return [
        Section(
            name,
            f"{_meaning(law)} Of {', '.join(of) or 'no system'}.",
            KEYS,
            _numbers({**law.parameters} | (PARTS if rolling & {*of} else {})),
        )
        for name, (law, of) in laws.items()
    ]


def _meaning(law: type[FrictionLaw]) -> str:
    """Return the docstring of a law without its numbers."""
    return " ".join((law.__doc__ or "").partition("\n\nParameters\n")[0].split())


def systems() -> list[Section]:
    """The systems: forms, integrals, source."""
    rows = [
        (s.name, s.title, ", ".join(s.forms), ", ".join(s.integrals) or "none", s.source)
        for s in SYSTEMS.values()
    ]
    return [Section("Systems", "", ("system", "what", "forms", "integrals", "source"), rows)]


def _with_contact() -> list[System]:
    return [
        opened(system, LAWS["none"], balls)
        for system in opening_systems().values()
        for balls in ((1, 2) if system.opening and system.opening.sphere else (1,))
    ]


def events() -> list[Section]:
    """The kinds of events."""
    rows: dict[str, list[Any]] = {}
    for system in (*SYSTEMS.values(), *_with_contact()):
        for event in system.events:
            rows.setdefault(event.name, [event, []])[1].append(system.name)
    return [
        Section(
            "Events",
            "Zeros of a function of the state, found to rounding; `[run] events` names those "
            "that are logged.",
            ("event", "what it is", "ends a run as", "kept of every run", "systems"),
            [
                (
                    name,
                    event.long_name,
                    event.ends or "",
                    _kept(event),
                    ", ".join(dict.fromkeys(where)),
                )
                for name, (event, where) in rows.items()
            ],
        )
    ]


def _kept(event: Event) -> str:
    return ", ".join(kept.name for kept in event.kept)


def columns() -> list[Section]:
    """The columns of a run, by system."""
    sections = [
        Section(f"Columns of {system.name}", "", ("column", "unit", "what it is"), _columns(system))
        for system in SYSTEMS.values()
    ]
    new = {row for system in opening_systems().values() for row in _columns(system)}
    rows = [row for system in _with_contact() for row in _columns(system) if row not in new]
    text = "Beside the others, or instead."
    return [
        *sections,
        Section(
            "Columns of a contact that may open",
            text,
            ("column", "unit", "what it is"),
            list(dict.fromkeys(rows)),
        ),
    ]


def _columns(system: System) -> list[tuple[str, ...]]:
    names = system.long_names
    angles = [(n, unit.symbol, names.get(n, "")) for n, unit in system.angles._asdict().items()]
    vectors = [
        (
            n,
            getattr(system.forms["vector"].units, variables[0]).symbol,
            f"{names.get(n, '')}, (time, xyz)",
        )
        for n, variables in system.vectors.items()
    ]
    turn = [("orientation", "1", f"{ORIENTATION}, (time, wxyz)")]
    if system.undefined_at_poles:
        turn.insert(0, ("psi", "rad", PSI))
    quantities = [
        (q.name, q.unit.symbol, f"{q.long_name}{': ' if q.meanings else ''}{', '.join(q.meanings)}")
        for q in system.quantities
        if q.is_column
    ]
    asked = [
        (q.name, q.unit.symbol, f"{q.long_name}; only where `run.columns` names it")
        for q in system.on_request
    ]
    return [*angles, *vectors, *turn, *quantities, *asked]


TOPICS = {
    "scenario": scenario,
    "friction": friction,
    "systems": systems,
    "events": events,
    "columns": columns,
}
"""What can be asked for, by name."""
