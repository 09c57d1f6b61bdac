"""A planted error is seen, by the drift of what a run must keep or by its witness; and none is seen
in a sound run.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest
from examples import CANONICAL
from touching import BOUNCE
from typed import typed

from tippetop.engine.status import Status
from tippetop.problem import Problem
from tippetop.runs import certificate, starting
from tippetop.runs.certificate import certificate_violations, contract_violations
from tippetop.runs.run import Solution, solve
from tippetop.scenario import build


def report(t_end: float = 8.0, **drift: float) -> dict[str, Any]:
    return {
        "t_end": t_end,
        "drift": {"jellett": 0.0, "energy_balance": 0.0, "axis_norm": 0.0, **drift},
    }


@pytest.mark.parametrize(
    ("name", "bound"),
    [
        ("jellett", 1e-13),
        ("axis_norm", 1e-13),
        ("energy_balance", 1e-12),
        ("routh", 1e-12),
        ("Lz", 1e-12),
    ],
)
def test_each_invariant_has_its_bound(name: str, bound: float) -> None:
    """The numbers of the contract; a drift that is no number is beyond any bound."""
    assert contract_violations(report(**{name: bound}), 2.2e-16) == []
    for drift in (1.01 * bound, np.inf, np.nan):
        (sentence,) = contract_violations(report(**{name: drift}), 2.2e-16)
        assert sentence.startswith(
            f"the drift of {name.replace('_', ' ')} must be at most {bound:.1e}, but is "
        )


def test_the_bound_grows_like_a_random_walk_after_ten_thousand_seconds() -> None:
    for t_end, growth in ((1e2, 1.0), (1e4, 1.0), (4e4, 2.0), (1e6, 10.0)):
        assert contract_violations(report(t_end, jellett=0.99e-13 * growth), 2.2e-16) == []
        assert len(contract_violations(report(t_end, jellett=1.01e-13 * growth), 2.2e-16)) == 1


def test_a_tolerance_of_ones_own_promises_nothing() -> None:
    assert contract_violations(report(jellett=1.0), 1e-9) == []
    assert len(contract_violations(report(jellett=1.0), 1e-18)) == 1


@pytest.fixture(scope="module")
def problem() -> Problem:
    return starting.load("inverting", until=0.5)


def spoil(monkeypatch: pytest.MonkeyPatch, spoiled: Any) -> None:
    """Runs in double, as the certificate gets them, are spoiled; the witness is not."""

    def run(problem: Problem, *_: Any) -> Solution:
        made = solve(problem)
        return spoiled(made) if problem.precision == "double" else made

    monkeypatch.setattr(certificate, "solve", run)


def test_a_planted_error_of_the_state_is_measured(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The axis of one row in the middle is tilted by a known angle: that angle is the error."""
    error, row = 3e-9, 1234

    def tilt(made: Solution) -> Solution:
        names = made.problem.variables.names
        x, z = names.index("ux"), names.index("uz")
        y = names.index("uy")
        theta = np.arctan2(np.hypot(made.rows[row, x], made.rows[row, y]), made.rows[row, z])
        made.rows[row, [x, y]] *= np.sin(theta + error) / np.sin(theta)
        made.rows[row, z] = np.cos(theta + error)
        return made

    spoil(monkeypatch, tilt)
    found = certificate.certificate(problem)
    assert found["theta"] == pytest.approx(error, rel=1e-3)
    (sentence,) = certificate_violations(found)
    assert sentence == "theta must be within 1e-10 of the wider run, but differs by 3.0e-09."


def test_a_planted_error_of_the_place_is_measured(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    def shift(made: Solution) -> Solution:
        x = made.problem.variables.names.index("x")
        made.rows[77, x] += 3e-9 / made.problem.weights()[x]
        return made

    spoil(monkeypatch, shift)
    found = certificate.certificate(problem)["columns"]
    assert found["x"] == pytest.approx(3e-9, rel=1e-3)
    assert found["y"] < 1e-12


def test_an_angle_that_jumps_is_compared_as_an_angle(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An azimuth that is turned by nearly a full turn differs by the rest."""

    def turn(made: Solution) -> Solution:
        x, y = (made.problem.variables.names.index(name) for name in ("ux", "uy"))
        u = (made.rows[9, x] + 1j * made.rows[9, y]) * np.exp(1j * (2 * np.pi - 4e-9))
        made.rows[9, [x, y]] = u.real, u.imag
        return made

    spoil(monkeypatch, turn)
    assert certificate.certificate(problem)["columns"]["phi"] == pytest.approx(4e-9, rel=1e-3)


def test_planted_errors_of_phases_and_impacts_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    def late(made: Solution) -> Solution:
        for table, name, error in (("impacts", "time", 2e-7), ("phases", "start", 3e-7)):
            last = [part for part in made.others[table] if len(part[name])][-1]
            last[name][-1] += error
        return made

    spoil(monkeypatch, late)
    found = certificate.certificate(build.problem(BOUNCE))
    assert found["impacts"]["time"] == pytest.approx(2e-7, rel=1e-3)
    assert found["phases"]["start"] == pytest.approx(3e-7, rel=1e-3)
    assert found["theta"] < 1e-12


def test_turnings_of_which_the_wider_run_has_more_are_not_paired(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Paired by number, the turnings after a missing one would differ by half a swing."""
    whole = certificate.certificate(problem)["turnings"]
    assert whole["time"] < 1e-12
    rows = whole["compared"]

    def lose(made: Solution) -> Solution:
        first = np.flatnonzero((made.events.kind == 0) & made.events.significant)[0]
        made.events.significant[first] = False
        return made

    spoil(monkeypatch, lose)
    found = certificate.certificate(problem)
    assert found["turnings"] == {"compared": 0, "counts": [rows - 1, rows]}


def test_another_end_is_seen(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    spoil(
        monkeypatch,
        lambda made: dataclasses.replace(
            made, progress=dataclasses.replace(made.progress, status=Status.LIFTOFF)
        ),
    )
    found = certificate.certificate(problem)
    assert found["same_end"] is False
    assert certificate_violations(found) == [
        "the run must end as the wider run does, but ends otherwise."
    ]


def test_the_widest_numbers_have_no_witness(problem: Problem) -> None:
    found = certificate.certificate(dataclasses.replace(problem, precision="quad"))
    assert found["against"] is None
    assert certificate_violations(found) == []


def test_only_the_window_is_compared(problem: Problem) -> None:
    assert certificate.certificate(problem, 0.125)["window"] == [0.0, 0.125]
    assert certificate.certificate(problem, 99.0)["window"] == [0.0, 0.5]


def test_a_form_that_is_singular_at_a_pole_breaks_the_promise_near_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A heavy top that swings through its lowest point: Euler's angles are singular there."""
    sets = "--set initial.omega3=0.0 --set initial.theta=3.0 --set initial.phi_dot=0.001"
    words = f"run heavy-top {sets} --until 5 --json"
    assert typed(f"{words} --set form=euler") == 4
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("tippetop: the accuracy contract is broken: the drift of energy")
    assert typed(words) == 0


@pytest.mark.parametrize(
    ("tables", "named"),
    [({}, 0), ({"friction": {"law": "contensou", "mu": 0.3, "patch": 1e-3}}, 1)],
)
def test_a_certificate_names_the_thresholds_of_contact_that_a_run_met(
    tables: dict, named: int
) -> None:
    """A disc that starts to slide slowly comes to rest; a point only rolls."""
    start = {"theta": 1.0, "nu_x": 0.01}
    friction = {"law": "coulomb", "mu": 0.9}
    problem = build.problem(
        {"system": "tippe-top", "parameters": CANONICAL, "friction": friction, "initial": start}
        | {"contact": {"e_n": 0.0}, "run": {"until": 0.02}}
        | tables
    )
    found = certificate.certificate(problem)["thresholds"]
    assert len(found) == named
    assert all("disc" in text for text in found)
