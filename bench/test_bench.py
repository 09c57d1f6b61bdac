"""The laws of the benchmarks: peers integrate the engine's equations, equal error is equal, pages
tell results.
"""

import ctypes
import json
import math
from pathlib import Path

import numpy as np
import pytest

from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.runs import starting

from . import report
from .case_precision import reference
from .cases import COMPARISONS
from .coulomb_by_steps import inversion
from .dop853 import Compiled
from .drawing import draw
from .equal import common, ratio, seconds
from .minimal import COMPILER, Minimal
from .ours import end_of, start_by_hand, tippe_top_by_hand, with_events
from .peers import Peer


compiler = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler")
STATES = np.random.default_rng(1).uniform(0.2, 0.9, (20, 12))


def made(name: str, until: float = 0.5) -> Minimal:
    """The minimal problem of a comparison, shortened."""
    comparison = COMPARISONS[name]
    return Minimal(
        starting.load(comparison.preset, None, until),
        np.array([until / 2, until]),
    )


def by_heyoka(minimal: Minimal, states: np.ndarray) -> np.ndarray:
    """What the engine integrates, evaluated by heyoka."""
    import heyoka as hy

    problem = minimal.problem
    equations = equations_of_motion(
        formulas_of(problem.system, problem.form.name, type(problem.friction)), problem.variables
    ).rates
    chosen = equations[: problem.variables.moving]
    function = hy.cfunc([rate for _, rate in chosen], [v for v, _ in chosen])
    pars = [float(leaf) for leaf in _leaves(minimal.body)]
    return np.array([function(state, pars=pars[: function.nparams]) for state in states])


def _leaves(record: tuple) -> list:
    return [
        leaf for part in record for leaf in (_leaves(part) if isinstance(part, tuple) else [part])
    ]


@compiler
@pytest.mark.parametrize("name", COMPARISONS)
def test_peers_integrate_the_equations_of_the_engine(name: str) -> None:
    minimal = made(name)
    n = len(minimal.names)
    exact = by_heyoka(minimal, STATES[:, :n])
    rhs = minimal.built.rhs
    rhs.argtypes = [ctypes.c_double, *[ctypes.c_void_p] * 3]
    for state, wanted in zip(STATES[:, :n], exact, strict=True):
        y, d = np.ascontiguousarray(state), np.empty(n)
        rhs(0.0, y.ctypes.data, d.ctypes.data, None)
        np.testing.assert_allclose(d, wanted, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(
            np.array(minimal.rates(list(y)), float), wanted, rtol=1e-12, atol=1e-13
        )


def test_heyoka_by_hand_has_the_equations_of_the_engine() -> None:
    """At states on the way, in SI units."""
    import heyoka as hy

    minimal = made("inversion")
    sys = tippe_top_by_hand(minimal)
    hand = hy.cfunc([rate for _, rate in sys], [v for v, _ in sys])
    problem = minimal.problem
    found = dict(zip([str(v) for v, _ in sys], hand(start_by_hand(minimal)), strict=True))
    rates = dict(zip(minimal.names, minimal.rates(minimal.start), strict=True))
    second = float(problem.scales.time)
    for mine, his in (
        ("ux", "ux"),
        ("uy", "uy"),
        ("uz", "uz"),
        ("Lx", "Lx"),
        ("Ly", "Ly"),
        ("Lz", "Lz"),
        ("rx_dot", "rx"),
    ):
        unit = float(problem.scales.of(getattr(problem.form.units, mine)))
        assert found[his] == pytest.approx(
            rates[mine] * unit / second, rel=1e-11, abs=1e-12 * unit / second
        )


@compiler
@pytest.mark.slow
def test_dop853_converges_to_the_engine() -> None:
    minimal = made("inversion")
    exact = reference(COMPARISONS["inversion"]._replace(wide="longdouble"), minimal.samples)
    solve = Compiled(minimal)
    errors = [
        np.abs(minimal.theta(solve(tolerance))[1:] - exact).max()
        for tolerance in (1e-8, 1e-11, 1e-14)
    ]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e-13


def test_events_on_is_timed_to_the_end_of_the_run() -> None:
    """A run of more steps than one call of the driver makes."""
    minimal = made("rolling", until=60.0)
    solver = with_events(minimal)(0.0)
    driver = solver.setup()
    solver.work(driver)
    assert driver.clock[0] == end_of(minimal.problem)


def ladder(factor: float, power: float, least: float) -> dict:
    """A contestant whose seconds are a power of its error."""
    errors = [10.0**-k for k in range(6, 17, 2) if 10.0**-k >= least]
    costs = [factor * error**-power for error in errors]
    points = [
        {"error": e, "seconds": s, "rounds": [s, 2 * s, s]}
        for e, s in zip(errors, costs, strict=True)
    ]
    return {"kind": "compiled", "points": points}


def test_equal_error_is_equal() -> None:
    """Power laws are straight lines; an error that is not reached costs infinitely much."""
    slow, fast = ladder(5.0, 0.1, 1e-12), ladder(1.0, 0.05, 1e-16)
    at = common(1e-13, slow, fast)
    assert at == 1e-12
    assert ratio(slow, fast, 3e-9) == pytest.approx(5 * 3e-9**-0.05)
    assert seconds(slow, 1e-13) == math.inf


def test_pages_say_what_was_measured() -> None:
    """Both pages are what `python -m bench.report` writes: nobody types a number."""
    results = report.read(report.RESULTS)
    assert set(results) >= set(COMPARISONS)
    sections = report.sections(results)
    for page in (report.PAGE, report.FRONT):
        text = page.read_text(encoding="utf-8")
        assert report.filled(text, sections) == text


def test_each_comparison_has_a_figure(tmp_path: Path) -> None:
    draw({"inversion": report.read(report.RESULTS)["inversion"]}, tmp_path)
    assert (tmp_path / "inversion.png").stat().st_size > 10_000


@pytest.mark.slow
def test_the_reference_is_that_of_an_independent_integration() -> None:
    """To what the parameters' own rounding to doubles makes of theta: the inversion amplifies it a
    thousandfold.
    """
    stored = json.loads(
        (Path(__file__).parents[1] / "tests" / "reference" / "case1_inverting.json").read_text()
    )
    theta = np.array([np.longdouble(text) for text in stored["theta"][1:]])
    found = reference(COMPARISONS["inversion"], np.array(stored["t"][1:], float))
    assert np.abs(found - theta).max() < 2e-14


def test_a_missing_peer_is_told() -> None:
    peer = Peer(
        "none", "compiled", lambda minimal: None, needs="no_such_package", package="no-such-package"
    )
    assert peer.missing == "no-such-package is not installed"
    results = report.read(report.RESULTS)
    for name in [name for name in results["inversion"]["contestants"] if "DOP853" in name]:
        results["inversion"]["contestants"][name] = {"kind": "compiled", "missing": peer.missing}
    sections = report.sections(results)
    assert "| DOP853, SciPy |  |  |  |  | could not run |" in sections["inversion"]


def test_a_step_that_is_too_long_turns_a_top_over_that_would_stick() -> None:
    """Cohen's top under Coulomb's law itself sticks at 0.0288 s; by fixed steps it inverts, the
    later the shorter.
    """
    long, longer = (inversion(step, 2.2) for step in (2e-3, 4e-3))
    assert 0.5 < longer < long < 2.2
