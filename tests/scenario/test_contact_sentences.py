"""What is wrong with a contact that may open, each in one sentence."""

import copy
from typing import Any

import pytest
from touching import BOUNCE

from tippetop.errors import InputError
from tippetop.scenario import build


STRIBECK = {"law": "stribeck", "mu": 0.2, "v_s": 0.1, "eps": 0.01}


def sentences(changes: dict[str, Any]) -> list[str]:
    """Return the faults of the scenario where a key table.name or a table has another value; None
    takes it away.
    """
    tables = copy.deepcopy(BOUNCE)
    for key, value in changes.items():
        table, _, name = key.partition(".")
        place, name = (tables.setdefault(table, {}), name) if name else (tables, table)
        place[name] = value
        if value is None:
            del place[name]
    try:
        build.problem(tables)
    except InputError as error:
        return error.sentences
    return []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact.e_n": 1.2}, ["`contact.e_n`", "1.2"]),
        ({"contact.restitution": "elastic"}, ["`contact.restitution`", "'newton'", "'elastic'"]),
        ({"contact": 3}, ["`contact` must be a table"]),
        ({"stem": {"r": 0.03, "h": 0.03}}, ["`stem.r` must be smaller than parameters.R = 0.02"]),
        (
            {"stem": {"r": 0.004, "h": 0.01}},
            ["`stem.h` must exceed R - r = 0.016", "never touches"],
        ),
        (
            {"friction.eps": 0.01, "contact": None, "run.on_liftoff": "stop"},
            ["`initial.gap` requires a contact that may open"],
        ),
        (
            {"friction": {"law": "contensou", "mu": 0.3, "patch": 1.9e-7}},
            ["1.9e-07. A smaller disc slides as a point"],
        ),
        ({"friction.mu": 1.46}, ["`friction.mu` must be less than 1.4595", "Painleve"]),
        (
            {"friction": {**STRIBECK, "mu_static": 1.5}},
            ["`friction.mu_static` must be less than 1.4595", "Painleve"],
        ),
        (
            {"initial.nu_z": -1e4},
            ["`initial.nu_z` must be within 626.", "fall from 1e+06 times the body", "-10000."],
        ),
        ({"run.events": ["landing"]}, ["`run.events`", "impact", "'landing'"]),
        ({"system": "rolling-tippe-top", "friction": None}, ["`contact` must be of a tippe-top"]),
    ],
)
def test_bad_input_is_one_sentence(changes: dict[str, Any], words: list[str]) -> None:
    found = sentences(changes)
    assert len(found) == 1, found
    assert all(word in found[0] for word in words), found


def test_the_bound_is_that_of_the_ball_that_has_the_least() -> None:
    assert sentences({"friction.mu": 1.4}) == []
    (sentence,) = sentences({"friction.mu": 1.4, "stem": {"r": 0.004, "h": 0.022}})
    assert "of this stem is not unique" in sentence


def test_a_coulomb_law_without_eps_is_followed_through_its_phases() -> None:
    problem = build.problem(BOUNCE)
    assert problem.on_liftoff == "fly"
    assert build.resolved(problem)["contact"] == {"restitution": "energetic", "e_n": 0.5}
    assert build.resolved(build.problem(build.resolved(problem))) == build.resolved(problem)
