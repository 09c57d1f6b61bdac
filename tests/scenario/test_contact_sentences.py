"""What is wrong with a contact that may open, each in one sentence. [contact 6]"""

import copy
from typing import Any

import pytest
from touching import BODY, BOUNCE

from tippetop.errors import InputError
from tippetop.scenario import build


CYLINDER: dict[str, Any] = {
    "system": "gliding-cylinder",
    "parameters": {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 3e-06, "g": 9.82},
    "friction": {"law": "coulomb", "mu": 0.1},
    "initial": {"theta": 2.0},
    "run": {"until": 0.1},
}
STEM = {"r": 0.004, "h": 0.022}


def sentences(base: dict[str, Any], changes: dict[str, Any]) -> list[str]:
    """What is wrong with the tables, where a key table.name or a table has another
    value; None takes it away.
    """
    tables = copy.deepcopy(base)
    for key, value in changes.items():
        table, _, name = key.partition(".")
        if not name and value is None:
            tables.pop(table, None)
        elif not name:
            tables[table] = value
        else:
            tables.setdefault(table, {})[name] = value
    try:
        build.problem(tables)
    except InputError as error:
        return error.sentences
    return []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact.e_n": 1.2}, ["`contact.e_n`", "1.2"]),
        ({"contact.e_n": -0.1}, ["`contact.e_n`", "-0.1"]),
        ({"contact.e_n": "half"}, ["`contact.e_n`", "must be a number"]),
        ({"contact.restitution": "elastic"}, ["`contact.restitution`", "'newton'", "'elastic'"]),
        ({"contact.e_t": 0.5}, ["contact.e_t", "e_n"]),
        ({"contact": 3}, ["`contact` must be a table"]),
        ({"stem": 3}, ["`stem` must be a table"]),
        ({"stem": {"r": 0.004}}, ["`stem.h` must be given"]),
        ({"stem": {"r": 0.0, "h": 0.03}}, ["`stem.r`", "greater than 0"]),
        ({"stem": {"r": 0.03, "h": 0.03}}, ["`stem.r` must be smaller than parameters.R = 0.02"]),
        (
            {"stem": {"r": 0.004, "h": 0.01}},
            ["`stem.h` must exceed R - r = 0.016", "never touches"],
        ),
        ({"stem": {"r": 1e-300, "h": 0.03}}, ["`stem.r` must be greater than 1e-09 parameters.R"]),
        ({"stem": {"r": 0.004, "h": 1e300}}, ["`stem.h` must be less than 1e+06 parameters.R"]),
        (
            {"friction.eps": 0.01, "contact": None, "run.on_liftoff": "stop"},
            ["`initial.gap` requires a contact that may open"],
        ),
        ({"initial.gap": 1e300}, ["`initial.gap` must be at most 1e+06 times the body"]),
        (
            {"friction": {"law": "contensou", "mu": 0.3, "patch": 1e-300}},
            ["`friction.patch` must be from"],
        ),
        (
            {"friction": {"law": "contensou", "mu": 0.3, "patch": 1.9e-7}},
            ["1.9e-07. A smaller disc slides as a point"],
        ),
        (
            {"friction": {"law": "contensou", "mu": 0.3, "patch": 1.0}},
            ["`friction.patch` must be from"],
        ),
        ({"friction.mu": 1.46}, ["`friction.mu` must be less than 1.4595", "Painleve"]),
        (
            {"initial.nu_z": -1e4},
            ["`initial.nu_z` must be within 626.", "fall from 1e+06 times the body", "-10000."],
        ),
        ({"initial.gap": -3e-4}, ["`initial.gap` must be", "-0.0003"]),
        ({"run.on_liftoff": "continue"}, ['`run.on_liftoff` must be "fly" or "stop"']),
        ({"run.on_liftoff": "jump"}, ["`run.on_liftoff`", "'fly'", "'jump'"]),
        ({"run.events": ["landing"]}, ["`run.events`", "impact", "'landing'"]),
        ({"form": "euler"}, ["`form` must be", "'euler'"]),
        ({"system": "rolling-tippe-top", "friction": None}, ["`contact` must be of a tippe-top"]),
    ],
)
def test_bad_input_is_one_sentence(changes: dict[str, Any], words: list[str]) -> None:
    found = sentences(BOUNCE, changes)
    assert len(found) == 1, found
    assert [word for word in words if word not in found[0]] == [], found


def test_the_least_disc_may_be_written() -> None:
    for R in (0.02, 0.03, 0.1, 1.0):
        friction = {"law": "contensou", "mu": 1e-3, "patch": float(f"{R}e-5")}
        assert sentences(BOUNCE, {"parameters.R": R, "friction": friction}) == [], R


def test_the_bound_is_that_of_the_ball_that_has_the_least() -> None:
    assert sentences(BOUNCE, {"friction.mu": 1.4}) == []
    (sentence,) = sentences(BOUNCE, {"friction.mu": 1.4, "stem": {"r": 0.004, "h": 0.022}})
    assert "of this stem is not unique" in sentence


def test_a_stem_is_of_a_tippe_top() -> None:
    (sentence,) = sentences(CYLINDER, {"stem": STEM})
    assert sentence == "`stem` must be of a tippe-top, but the system is gliding-cylinder."


def test_a_regularised_law_is_as_it_was() -> None:
    tables = {
        "system": "tippe-top",
        "parameters": BODY,
        "friction": {"law": "coulomb", "mu": 0.3, "eps": 1e-3},
        "initial": {"theta": 0.1},
        "run": {"until": 1.0},
    }
    problem = build.problem(tables)
    assert problem.contact is None
    assert problem.on_liftoff == "stop"
    assert "eps" in build.resolved(problem)["friction"]


def test_a_coulomb_law_without_eps_is_followed_through_its_phases() -> None:
    problem = build.problem(BOUNCE)
    assert problem.on_liftoff == "fly"
    assert build.resolved(problem)["contact"] == {"restitution": "energetic", "e_n": 0.5}
    assert build.resolved(build.problem(build.resolved(problem))) == build.resolved(problem)
