"""The summary of a run in words: each sentence says the numbers that it is given, and none that it
is not.
"""

from typing import Any

import pytest

import tippetop
from tippetop.runs.summary import lines


NEVER = {"first_equator": None, "last_equator": None, "inverted_at": None}


def info(**changes: Any) -> dict[str, Any]:
    """What a run of a tippe top amounts to, with numbers that are easy to read."""
    return {
        "system": "tippe-top",
        "reason": "finished at t = 8 s.",
        "steps": 1337,
        "inversion": NEVER,
        "theta_end": 0.25,
        "event_counts": {"turning": 0, "turning_significant": 0},
        "nutational_band": {"theta_min": None, "theta_max": None},
        "drift": {"jellett": 2e-15, "energy_balance": 3.5e-14},
        **changes,
    }


def text(name: str, **changes: Any) -> str:
    return dict(lines(info(**changes)))[name]


def test_names_come_in_one_order_and_only_where_they_apply() -> None:
    assert [name for name, _ in lines(info())] == ["status", "inversion", "turning angles", "drift"]
    force = {"min": 0.1, "max": 0.3, "t_min": 0.0, "t_max": 1.0, "weight": 0.2}
    more = info(
        normal_force=force,
        motion="loops",
        event_counts={"turning": 0, "turning_significant": 0, "liftoff": 1},
        certificate={"against": None, "reason": "no wider precision than quad"},
    )
    assert [name for name, _ in lines(more)] == [
        *("status", "inversion", "turning angles", "other events", "normal force", "drift"),
        *("motion", "certificate"),
    ]


@pytest.mark.parametrize(
    ("inversion", "sentence"),
    [
        ({}, "none; theta ends at 0.25 rad"),
        (
            {"first_equator": 5.5, "last_equator": 5.5},
            "theta = pi/2 at 5.500000 s, not beyond pi - 0.1; theta ends at 0.25",
        ),
        (
            {"first_equator": 5.5, "last_equator": 5.5, "inverted_at": 6.75},
            "theta = pi/2 at 5.500000 s, pi - 0.1 at 6.750000 s",
        ),
        (
            {"first_equator": 5.5, "last_equator": 6.0, "inverted_at": 6.75},
            "theta = pi/2 at 5.500000 s (last at 6.000000 s), pi - 0.1 at 6.750000 s",
        ),
    ],
)
def test_an_inversion_is_told_as_far_as_it_came(inversion: dict[str, float], sentence: str) -> None:
    assert text("inversion", inversion=NEVER | inversion) == sentence


def test_what_cannot_invert_ends_at_an_angle() -> None:
    """A system that friction does not turn over, and one that is not known here; unless it did pass
    the equator.
    """
    for system in ("rolling-cylinder", "of-another-package"):
        found = dict(lines(info(system=system)))
        assert found["theta"] == "ends at 0.25 rad"
        assert "inversion" not in found
        passed = dict(lines(info(system=system, inversion=NEVER | {"first_equator": 1.0})))
        assert ("inversion" in passed) == (
            system == "of-another-package"
        )  # a cylinder has none, whatever it passes


def test_a_force_is_said_in_newtons_and_in_weights() -> None:
    """What is zero within rounding is zero, without a sign."""
    force = {"min": 0.05, "max": 0.3, "weight": 0.2}
    assert text("normal force", normal_force=force) == "0.05 to 0.3 N, that is 0.2500 to 1.5000 m g"
    force["min"] = -1e-14
    assert text("normal force", normal_force=force) == "0 to 0.3 N, that is 0.0000 to 1.5000 m g"
    force["min"] = -0.1
    assert text("normal force", normal_force=force).startswith("-0.1 to 0.3 N, that is -0.5000 to")


def test_drift_names_every_invariant() -> None:
    assert text("drift") == "jellett 2.0e-15, energy balance 3.5e-14 (relative, worst of the run)"


def test_a_certificate_is_said_with_its_window() -> None:
    found: dict[str, Any] = {"against": "longdouble", "window": [0.0, 2.5], "theta": 3e-14}
    expected = "against longdouble over 2.5 s: theta differs by at most 3.0e-14 rad"
    assert text("certificate", certificate=found) == expected
    found["turnings"] = {"counts": [12, 12], "time": 4e-15}
    assert text("certificate", certificate=found) == f"{expected}, 12 turning times by 4.0e-15 s"
    found["impacts"] = {"counts": [7, 8]}
    further = "12 turning times by 4.0e-15 s, 7 impacts, but 8 in longdouble"
    assert text("certificate", certificate=found) == f"{expected}, {further}"
    assert (
        text("certificate", certificate={"against": None, "reason": "no wider one"})
        == "no wider one"
    )


@pytest.mark.parametrize("parts", [{}, {"mu_r": 1e-6}, {"mu_d": 1e-6}])
def test_the_headline_shows_the_parts_that_act(parts):
    friction = {"law": "contensou", "mu": 0.3, "patch": 5e-4, **parts}
    run = tippetop.run("leine-glocker-drilling", friction=friction, until=1e-3)
    for name in ("mu_r", "mu_d"):
        assert (name in str(run).splitlines()[0]) == (name in parts)
