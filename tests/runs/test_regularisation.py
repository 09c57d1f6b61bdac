"""With a regularised Coulomb law eps decides when a top inverts."""

from typing import Any

import pytest

from tippetop.runs import forecast, regularisation
from tippetop.scenario.build import load


def found(*sets: str, until: float) -> dict[str, Any]:
    problem = load("leine-glocker", list(sets), until=until)
    return regularisation.regularisation(problem, {"seconds": 0.0})


def times(*sets: str, until: float) -> list[float | None]:
    return found(*sets, until=until)["inversion_by_eps"]["first_equator"]["value"]


def test_published_times_of_the_leine_glocker_top() -> None:
    """90 degrees at 1.05 s for eps = 1e-2 m/s."""
    half, whole = times(until=3.0)
    assert whole == pytest.approx(1.05, abs=0.005)
    assert whole < half < 2 * whole, "a smaller eps inverts later, and not in proportion"


def test_eps_may_decide_whether_a_top_inverts_in_time() -> None:
    """Between 1.05 s and 1.25 s, where eps = 0.005 m/s has not inverted yet."""
    assert times(until=1.1)[0] is None
    assert "half of it decides whether" in found(until=1.1)["regularisation"]


@pytest.mark.slow
def test_published_times_for_smaller_eps() -> None:
    """2.71 s for eps = 1e-3 m/s."""
    assert times("friction.eps=0.001", until=6.0)[1] == pytest.approx(2.71, abs=0.01)


def test_an_unknown_time_is_reported_as_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    """A top whose eps is so small that its steps are short: no time is given, and no `never`."""
    monkeypatch.setattr(regularisation, "MOST_STEPS", 1)  # to a slice
    report = forecast.assessment(load("leine-glocker", ["friction.eps=1e-6"], until=3.0))
    assert "was not found out" in report["regularisation"]
    assert "inversion_by_eps" not in report


def test_no_run_continues_after_its_inversion(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first theta = pi/2 of a run of 300 s is that of one of 3 s."""
    short = times(until=3.0)
    monkeypatch.setattr(regularisation, "MOST_STEPS", 1)
    assert times(until=300.0) == short
