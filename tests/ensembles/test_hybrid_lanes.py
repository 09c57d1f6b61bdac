"""Tops whose contact changes run in lanes as they would run alone, whatever runs beside them."""

import threading
import time
from functools import cache, partial

import numpy as np
import pytest
from limits import assert_below, assert_near
from nightly import at_night
from touching import BODY, BOUNCE, DRILLING, TOSSED

from tippetop.engine import hybrid, jump_programs, pools
from tippetop.engine.status import Status
from tippetop.ensembles import ensemble, hybrid_tops, lanes
from tippetop.ensembles.outcomes import Outcomes, _conclude
from tippetop.mechanics import lines
from tippetop.mechanics.contact import exits
from tippetop.problem import Problems
from tippetop.scenario import build, reading


VISCOUS, COULOMB = {"law": "viscous", "mu": 0.3}, {"law": "coulomb", "mu": 0.3}
ON_STEM = {
    "friction": VISCOUS,
    "stem": {"r": 0.0038, "h": 0.0195},
    "initial": {"theta": 2.65, "omega3": 160.0},
}
BLOW = {"initial": {"theta": 0.5, "omega3": 60.0, "nu_z": -0.3}}
TOPS = {
    "hops": ("flying", {}, 6.0),
    "bounces": (BOUNCE, {"friction": VISCOUS, "contact": {"e_n": 0.7}}, 0.5),
    "sticks": (BOUNCE, {"friction": COULOMB, "initial": TOSSED}, 0.3),
    "rests": (BOUNCE, {"friction": DRILLING, "initial": TOSSED}, 0.3),
    "stands": ("leine-glocker-stem", {}, 0.3),
    "begins with a blow": (BOUNCE, BLOW, 0.3),
    "begins on its stem": ("leine-glocker-stem", ON_STEM, 0.3),
    "stands on its head": (BOUNCE, {"parameters": BODY | {"alpha": -0.3}}, 0.3),
    "rocks": ("gliding-cylinder", {"contact": {"e_n": 0.3}}, 0.3),
}
"""Scenarios, changes to their tables, and the time of the end."""
DAILY = ("hops", "sticks", "rests")
RARE = ("begins with a blow", "stands on its head")
CASES = [case if case in DAILY else at_night(case) for case in TOPS]


def some(case: str, n: int = 12, **columns: np.ndarray) -> Problems:
    """Tops of a case with other spins or speeds, or other numbers."""
    scenario, changes, until = TOPS[case]
    tables = reading.read(scenario) if isinstance(scenario, str) else dict(scenario)
    base = build.problem(tables | changes | {"run": {"until": until, "output_step": until}})
    key = "omega3" if "omega3" in base.initial else "nu_x"
    numbers = float(base.initial[key]) * np.linspace(0.99, 1.01, n)
    return ensemble.vary(base, columns or {f"initial.{key}": numbers})


def alone(tops: Problems) -> Outcomes:
    outcomes = Outcomes(tops)
    for fault in hybrid_tops.checked_tops(tops)[1]:
        outcomes.refuse(*fault)
    valid = outcomes.status != Status.INVALID.code
    hybrid_tops.run_each(outcomes, np.flatnonzero(valid).tolist(), lambda: None)
    with np.errstate(all="ignore"):
        _conclude(outcomes)
    return outcomes


def same(a: Outcomes, b: Outcomes, which: np.ndarray | None = None) -> None:
    """Check that tops have the same bits: those of b are the tops `which` of a."""
    k = slice(None) if which is None else which
    np.testing.assert_array_equal(a.status[k], b.status)
    np.testing.assert_array_equal(a.final[:, k], b.final)
    for name, values in [*b.columns.items(), *b.drift.items()]:
        of_a = (a.columns | a.drift)[name]
        np.testing.assert_array_equal(of_a[k], values, name)


def few_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let pools have four lanes, room for few tops, and return to Python after each."""
    monkeypatch.setattr(lanes, "ROOM", 3)
    monkeypatch.setattr(lanes, "MOST_DRIVEN", 1)
    monkeypatch.setattr(pools.Pools, "lanes", 4)


def assert_column(found: np.ndarray, single: np.ndarray) -> None:
    """Check that numbers of lanes are those of single runs, by the size of the latter."""
    assert_near(found, single, 1e-8 * np.nanmax(np.abs(single), initial=1e-3))


def measured_as_alone(tops: Problems) -> Outcomes:
    """Return what tops in lanes are, and check that they end as each does alone."""
    measured, single = ensemble.measure(tops, threads=1), alone(tops)
    np.testing.assert_array_equal(measured.status, single.status)
    assert_near(measured.final, single.final, 1e-9)
    return measured


@pytest.mark.parametrize("case", [at_night(case) if case in RARE else case for case in TOPS])
def test_tops_in_lanes_are_what_they_are_alone(case: str) -> None:
    tops, few = some(case, 9), slice(None, None, 4)
    columns = {key: values[few] for key, values in tops.columns.items()}
    measured = ensemble.measure(tops, threads=1)
    single = alone(ensemble.vary(tops.base, columns))
    np.testing.assert_array_equal(measured.status[few], single.status)
    np.testing.assert_array_equal(measured.kind[few], single.kind)
    assert_near(measured.final[:, few], single.final, 1e-9)
    for name, drift in measured.drift.items():
        assert_near(drift[few], single.drift[name], 1e-12)
    for name, values in single.columns.items():
        if name not in ("turnings", "normal_force_min"):  # of rounding, where an axis rests
            assert_column(measured.columns[name][few], values)


def test_tops_may_differ_in_their_stems() -> None:
    lengths, radii = np.linspace(0.0195, 0.0198, 12), np.linspace(0.0036, 0.0038, 12)
    tops = some("begins on its stem", **{"stem.h": lengths, "stem.r": radii})
    measured = measured_as_alone(tops)
    assert len({*measured.columns["theta_end"]}) == 12


def test_tops_that_stand_on_their_stem_begin_there_whatever_their_inclination() -> None:
    """The gap of the sphere is not given: it follows theta. The energy of the start does too."""
    thetas = np.linspace(0.3, 3.0, 12)
    tops = some("begins on its stem", **{"initial.theta": thetas})
    tables = reading.read("leine-glocker-stem") | ON_STEM
    for top, theta in enumerate(thetas.tolist()):
        own = build.problem(tables | {"initial": ON_STEM["initial"] | {"theta": theta}})
        assert hybrid_tops.problem_of(tops, top).initial == own.initial
    measured = measured_as_alone(tops)
    assert_below(1e-12, measured.drift)


@pytest.mark.parametrize("case", CASES)
def test_the_bits_of_a_top_do_not_depend_on_the_others(monkeypatch, case: str) -> None:
    """Nor on their order, number and threads, on the lanes, on when Python looks, and on which
    programs are known.
    """
    tops = some(case)
    measured = ensemble.measure(tops, threads=1)
    order = np.array([7, 2, 11, 0, 5])
    columns = {key: values[order] for key, values in tops.columns.items()}
    same(measured, ensemble.measure(ensemble.vary(tops.base, columns), threads=2), order)
    few_lanes(monkeypatch)
    monkeypatch.setattr(jump_programs.JumpPrograms, "register", lambda *_: None)
    same(measured, ensemble.measure(tops, threads=1))


@pytest.mark.parametrize("case", CASES[:-1])
def test_no_top_is_left_to_run_alone(monkeypatch, case: str) -> None:
    left: list[int] = []
    monkeypatch.setattr(
        ensemble, "run_each", lambda measured, numbers, *_, **__: left.extend(numbers)
    )
    ensemble.measure(some(case), threads=1)
    assert not left


def test_only_the_first_tops_start_by_python(monkeypatch) -> None:
    """The others start by the program of their first jump."""
    starts = []
    start = pools.HybridPools._start
    monkeypatch.setattr(pools.HybridPools, "_start", lambda *a: starts.append(a) or start(*a))
    for _ in range(3):
        ensemble.measure(some("hops", 24), threads=1)
    assert 0 < len(starts) < 12


def test_a_top_that_fails_ends_alone(monkeypatch) -> None:
    """Here one without friction, one beyond Painleve's bound, and one whose impact has no
    solution.
    """
    mu = np.array([0.3, 0.0, 30.0, 0.31, 0.3])
    spins = np.array([100.0, 100.0, 100.0, 100.0, 101.0])
    struck = exits.struck

    def fails(x, world, ball):
        if getattr(world.body[0].friction, "mu", 0) == 0.31:
            raise ArithmeticError("no solution")
        return struck(x, world, ball)

    monkeypatch.setattr(exits, "struck", fails)
    tops = some("sticks", **{"friction.mu": mu, "initial.omega3": spins})
    measured = measured_as_alone(tops)
    statuses = [list(Status)[code].value for code in measured.status]
    assert statuses == ["finished", "finished", "invalid", "stalled", "finished"]
    assert [top for top, _ in measured.faults] == [2]


def test_only_what_has_no_line_is_left_to_python(monkeypatch) -> None:
    """Any other error of a jump that is recorded as a program is an error of this package."""
    struck = exits.struck
    raised: list[Exception] = [TypeError("no line"), AttributeError("a mistake")]

    def fails(x, world, ball):
        if isinstance(x.height, lines.Number):
            raise raised[0]
        return struck(x, world, ball)

    monkeypatch.setattr(exits, "struck", fails)
    monkeypatch.setattr(hybrid, "jump_of", cache(hybrid.Jump))
    ensemble.measure(some("sticks"), threads=1)
    del raised[0]
    monkeypatch.setattr(hybrid, "jump_of", cache(hybrid.Jump))
    with pytest.raises(AttributeError, match="a mistake"):
        ensemble.measure(some("sticks"), threads=1)


def test_a_stop_ends_the_pools_soon(monkeypatch) -> None:
    tops = some("hops", 64)
    ensemble.measure(tops, threads=1)  # compiles
    found: list[partial] = []
    monkeypatch.setattr(ensemble, "_run_all", lambda workers, *_: found.extend(workers))
    ensemble.measure(tops, threads=1)
    (worker,) = found
    measured, group, *_, stop = worker.args
    thread = threading.Thread(target=worker, args=(iter(range(64)),))
    thread.start()
    while thread.is_alive() and not group.possible:
        time.sleep(0.001)
    stop.set()
    thread.join(0.5)
    assert not thread.is_alive()
    assert (measured.status == 0).any()  # it has not followed all tops
