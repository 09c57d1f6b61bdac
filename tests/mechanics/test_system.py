"""Systems as data: phases, exits, and what makes a system contradict itself."""

import dataclasses
from typing import Any, NamedTuple

import pytest

from tippetop.errors import InputError
from tippetop.mechanics.contact.opening import opened
from tippetop.mechanics.form import Next
from tippetop.mechanics.friction import Contensou, SetValued, Viscous
from tippetop.mechanics.system import Event, Exit, Form, Phase, System
from tippetop.mechanics.systems import SYSTEMS, tippe_top
from tippetop.mechanics.systems.consistency import (
    check_answers,
    inconsistencies,
    unmet_requirements,
)
from tippetop.mechanics.units import METRE, METRE_PER_SECOND


class Height(NamedTuple):
    """Height and its rate of a ball that bounces."""

    y: Any
    y_dot: Any


class Still(NamedTuple):
    """A ball at rest."""

    y: Any


FALL = Form(
    "height",
    Height(METRE, METRE_PER_SECOND),
    lambda q, b: Height(q.y_dot, -b.g),
    lambda q, b: q,
    lambda e, s, z, b: Height(*e),
    lambda q, carried, b: q,
)
REST = Form(
    "height",
    Still(METRE),
    lambda q, b: Still(0),
    lambda q, b: q,
    lambda e, s, z, b: Still(0),
    lambda q, c, b: q,
)
LANDING = Event("landing", "y = 0", lambda q, b: q.y, -1)


def land(x: Height, world: Any) -> Next:
    """Half the speed remains; a slow ball stays."""
    if x.y_dot > -0.1:
        return Next("rest", Height(0.0, 0.0))
    return Next("flight", Height(0.0, -x.y_dot / 2), zeros={"landing": 1})


FLIGHT = Phase({"height": FALL}, (), (LANDING,), (Exit("landing", ("flight", "rest"), land),))
ON_PLANE = Phase(
    {"height": REST}, enter=lambda x, b: Still(x.y), leave=lambda q, b: Height(q.y, 0.0)
)
PHASES = {"flight": FLIGHT, "rest": ON_PLANE}
BALL = dataclasses.replace(
    SYSTEMS["tippe-top"], name="ball", phases=PHASES, integrals=(), undefined_at_poles=()
)


OPENED = [
    opened(SYSTEMS[name], law, balls).replace(contact=None)
    for name, balls in (("tippe-top", 2), ("gliding-heavy-top", 1), ("gliding-cylinder", 1))
    for law in (Viscous, SetValued, Contensou)
    if law is not Contensou or balls == 2
]


@pytest.mark.parametrize("system", [*SYSTEMS.values(), BALL, *OPENED], ids=lambda one: one.name)
def test_systems_are_consistent(system: System) -> None:
    assert inconsistencies(system) == []


@pytest.mark.parametrize("system", SYSTEMS.values(), ids=lambda system: system.name)
def test_systems_of_the_package_have_what_a_run_needs(system: System) -> None:
    assert unmet_requirements(system) == []


def test_a_phase_must_keep_the_common_state() -> None:
    check_answers(BALL)
    lossy = dataclasses.replace(FLIGHT, leave=lambda q, b: Height(q.y, 2 * q.y_dot))
    with pytest.raises(
        InputError, match="phase `flight` of `ball` must keep the common state, but gives"
    ):
        check_answers(dataclasses.replace(BALL, phases={"flight": lossy, "rest": ON_PLANE}))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"exits": FLIGHT.exits * 2}, "each name once, but has twice exit by `landing`"),
        ({"events": (LANDING, LANDING)}, "each name once, but has twice event `landing`"),
        (
            {"quantities": tippe_top.QUANTITIES[:1] * 2},
            "each name once, but has twice quantity `jellett`",
        ),
    ],
)
def test_contradictions_are_named(changes: dict[str, Any], sentence: str) -> None:
    broken = dataclasses.replace(
        BALL, phases={**BALL.phases, "flight": dataclasses.replace(FLIGHT, **changes)}
    )
    (fault,) = inconsistencies(broken)
    assert sentence in fault


@pytest.mark.parametrize(
    ("first", "second", "sentence"),
    [
        (
            {"sense": 1},
            {"sense": -1},
            "`sense` (turns of theta) must be that of one event, but is given in `a` and",
        ),
        (
            {"lasting": True, "direction": 1},
            {"lasting": True, "direction": -1},
            "`lasting` (what a motion settles into) must be that of one event, but is given in "
            "`a` and `b`.",
        ),
        (
            {"extremes": "f"},
            {"extremes": "g"},
            "`extremes` (the quantity whose least and greatest values",
        ),
        (
            {"lasting": True, "direction": 0},
            {},
            "`direction` of the event `a` must be -1 or 1, for it is `lasting`",
        ),
    ],
)
def test_a_run_follows_one_event_of_a_kind(first: dict, second: dict, sentence: str) -> None:
    """A second one was registered without a word, and never looked at."""
    events = [
        dataclasses.replace(LANDING, name=name, **fields)
        for name, fields in (("a", first), ("b", second))
    ]
    rest = dataclasses.replace(FLIGHT, events=tuple(events), exits=())
    (fault,) = inconsistencies(dataclasses.replace(BALL, phases={**BALL.phases, "flight": rest}))
    assert fault.startswith(sentence)
