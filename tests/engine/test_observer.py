"""What is kept of the events of a top, from Taylor coefficients whose zeros are known: no
integrator, no body.
"""

from math import factorial

import numpy as np
import pytest
from limits import assert_near
from numpy.polynomial import Polynomial
from polynomials import Given

from tippetop.engine.loop import Loop, new_motion
from tippetop.engine.status import Status
from tippetop.engine.tallies import (
    EventRows,
    Log,
    Rules,
    Tallies,
    event_rows,
    new_log,
    new_tallies,
)
from tippetop.mechanics.event import Event, Kept


ORDER, LANES, STEPS = 12, 4, 40
KEPT = (
    Kept("first", "first", ""),
    Kept("last", "last", ""),
    Kept("count", "count", ""),
    Kept("up", "count", "", 1),
)
UNTIL = 2.0
PATIENCE, TINY = 64, 1e-10  # as in loop.c
NO_RULES = Rules(settled_for=np.inf, most_steps=10**6, every=8, first=0)


def event(name: str, **options: object) -> Event:
    return Event(name, name, lambda s, b: None, kept=KEPT, **options)  # type: ignore[arg-type]


def rows_of(*sources: tuple[Event, int, float]) -> EventRows:
    """Events that are a variable (shift 0) or its rate (shift 1), plus an offset; event i reads
    variable i.
    """
    places = [(i, shift, 1.0, offset) for i, (_, shift, offset) in enumerate(sources)]
    n = len(sources)
    return event_rows([event for event, _, _ in sources], places, (n, n + 1, n + 2))


def coefficients(functions: list[Polynomial], times: np.ndarray) -> np.ndarray:
    """Return the Taylor coefficients (steps, rows, ORDER + 1) of functions; 3hat is upright."""
    tcs = np.zeros((len(times) - 1, len(functions) + 3, ORDER + 1))
    tcs[:, len(functions) + 2, 0] = 1.0
    for row, f in enumerate(functions):
        for k in range(ORDER + 1):
            tcs[:, row, k] = f.deriv(k)(times[:-1]) / factorial(k)
    return tcs


def slice_of(
    variables: list[list[Polynomial]], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Times (steps + 1, lanes) and coefficients (steps, rows, ORDER + 1, lanes) of each lane's
    variables. Steps differ from lane to lane.
    """
    inner = np.sort(rng.uniform(0.0, UNTIL, (STEPS - 1, LANES)), axis=0)
    times = np.concatenate([np.zeros((1, LANES)), inner, np.full((1, LANES), UNTIL)])
    lanes = [coefficients(p, times[:, lane]) for lane, p in enumerate(variables)]
    return times, np.stack(lanes, axis=-1)


def followed(
    rows: EventRows,
    times: np.ndarray,
    tcs: np.ndarray,
    signs: np.ndarray,
    rules: Rules = NO_RULES,
    log: Log | None = None,
) -> Tallies:
    """The tallies after these steps, of tops whose functions have these signs at the start,
    (events, lanes).
    """
    tallies = new_tallies(rows, signs)
    continued(tallies, rows, times, tcs, rules, log)
    return tallies


def continued(
    tallies: Tallies,
    rows: EventRows,
    times: np.ndarray,
    tcs: np.ndarray,
    rules: Rules = NO_RULES,
    log: Log | None = None,
) -> None:
    """Takes more steps in."""
    motion = new_motion(*tcs.shape[1:2], 0, *tcs.shape[2:])
    motion.end[:] = np.inf
    steps = zip(times, np.diff(times, axis=0), tcs, strict=False)
    loop = Loop(
        motion,
        rows,
        tallies,
        log or new_log(0, len(tcs[0])),
        new_log(0, 0),
        rules,
        Given(steps),
    )
    running = tallies.lane["status"] == Status.RUNNING.code
    for _ in tcs:  # the loop stops where a lane has ended
        if running.any():
            loop.drive(1)
        running = tallies.lane["status"] == Status.RUNNING.code


def with_roots(roots: np.ndarray) -> Polynomial:
    return Polynomial.fromroots(roots) if len(roots) else Polynomial([1.0])


def test_the_first_ending_ends_the_top_and_what_comes_later_is_not_seen(
    rng: np.random.Generator,
) -> None:
    """Other lanes go on; the earlier of two endings counts, in whatever order the events are."""
    ends = [(0.9, 1.3), (1.3, 0.9), (3.0, 3.0), (0.9, 3.0)]  # 3: beyond the end
    other = with_roots(np.array([0.2, 0.85, 0.95]))
    lanes = [[Polynomial([e, -1.0]), other, Polynomial([x, -1.0])] for e, x in ends]
    rows = rows_of(
        (event("liftoff", ends="liftoff", direction=-1), 0, 0.0),
        (event("other"), 0, 0.0),
        (event("fallen", ends="fallen", direction=-1), 0, 0.0),
    )
    signs = np.sign([[functions[e](0.0) for functions in lanes] for e in range(3)])
    found = followed(rows, *slice_of(lanes, rng), signs)
    codes = [Status.LIFTOFF, Status.FALLEN, Status.RUNNING, Status.LIFTOFF]
    assert found.lane["status"].tolist() == [status.code for status in codes]
    assert_near(found.lane["t"], [0.9, 0.9, UNTIL, 0.9], 1e-12)
    assert found.kept[len(KEPT) + 2].tolist() == [2, 2, 3, 2]
    assert found.lane["steps"][2] == STEPS
    assert np.all(found.lane["steps"][[0, 1, 3]] < STEPS)


def test_extremes_are_those_of_the_function_until_the_top_ends(rng: np.random.Generator) -> None:
    """Stationary where its slope has its roots; beyond the end it would be less."""
    slopes = [np.sort(rng.uniform(0.1, 1.9, 3)) for _ in range(LANES)]
    functions = [Polynomial.fromroots(s).integ() + 10.0 for s in slopes]
    stop = 1.0
    rows = rows_of(
        (event("force", extremes="force"), 0, 0.0), (event("end", ends="liftoff"), 0, 0.0)
    )
    signs = np.stack([np.ones(LANES), -np.ones(LANES)])
    for final, ending in ((UNTIL, Polynomial([-1.0])), (stop, Polynomial([-stop, 1.0]))):
        found = followed(rows, *slice_of([[f, ending] for f in functions], rng), signs).functions
        for lane, (f, s) in enumerate(zip(functions, slopes, strict=True)):
            values = f(np.concatenate([[0.0, final], s[s < final]]))
            expected = pytest.approx([values.min(), values.max()], abs=1e-12)
            places = found["times"][0, lane]
            assert found["extremes"][0, lane].tolist() == expected
            assert f(places).tolist() == expected
            assert np.all((places >= 0) & (places <= final + 1e-12))


def test_steps_that_lead_nowhere_are_a_stall() -> None:
    """Sixty-four in a row; one that leads somewhere begins the count anew.

    So are too many steps of any length.
    """
    rows, signs = rows_of((event("passage"), 0, 0.0)), np.ones((1, LANES))
    steps = np.full((PATIENCE + 1, LANES), TINY / 2)
    steps[PATIENCE // 2, 1] = 0.1
    times = np.concatenate([np.zeros((1, LANES)), np.cumsum(steps, axis=0)])
    tcs = np.zeros((len(steps), 4, ORDER + 1, LANES))
    tcs[:, [0, 3], 0] = 1.0
    found = followed(rows, times, tcs, signs).lane
    assert (found["status"] == Status.STALLED.code).tolist() == [True, False, True, True]
    assert found["steps"].tolist() == [PATIENCE, PATIENCE + 1, PATIENCE, PATIENCE]
    few = NO_RULES._replace(most_steps=5)
    assert followed(rows, times, tcs, signs, few).lane["steps"].tolist() == [5] * LANES


# --- the zeros themselves -----------------------------------------------------------------------

SIX = np.array([0.0, 0.4, 0.5, 1.1, 1.25, 2.0])
"""Steps of different lengths: extremes and zeros lie inside them and at their ends."""


def passages_of(
    sources: list[tuple[Event, int, float]],
    functions: list[Polynomial],
    times: np.ndarray = SIX,
    on_zero: bool = False,
) -> tuple[Tallies, Log]:
    """The tally and the log of one run; at the start its functions have the signs that they have
    there.
    """
    rows, log = rows_of(*sources), new_log(200, len(functions) + 3)
    at_start = [
        (f.deriv() if shift else f)(times[0]) + offset
        for f, (_, shift, offset) in zip(functions, sources, strict=True)
    ]
    tallies = new_tallies(rows, np.where(np.array(at_start) > 0, 1.0, -1.0)[:, None])
    tallies.functions["on_zero"] = on_zero
    tcs = coefficients(functions, times)[..., None]
    continued(tallies, rows, times[:, None], tcs, log=log)
    return tallies, log


@pytest.mark.parametrize("shift", [0, 1])
def test_every_zero_is_logged_once_with_its_sign_and_kept(
    shift: int, rng: np.random.Generator
) -> None:
    """One at most between two points of a grid, none on them; steps end where they like. The last
    one rises.
    """
    grid = np.linspace(0.0, UNTIL, 41)
    for _ in range(50):
        cells = np.sort(rng.choice(40, rng.integers(0, 7), replace=False))
        roots = grid[cells] + 0.05 * rng.uniform(0.1, 0.9, len(cells))
        f = with_roots(roots)
        times = np.concatenate([[0.0], np.sort(rng.uniform(0.0, UNTIL, 20)), [UNTIL]])
        tallies, log = passages_of(
            [(event("passage"), shift, 0.0)], [f.integ(k=3.0) if shift else f], times
        )
        n = log.filled[0]
        steepness = f.deriv()(roots)  # where roots are close, rounding of the function moves them
        assert_near((log.rows["time"][:n] - roots) * steepness, 0, 1e-12)
        assert log.rows["sign"][:n].tolist() == [(-1) ** k for k in range(len(roots) - 1, -1, -1)]
        first, last, *counts = tallies.kept[:, 0]
        assert counts == [len(roots), (len(roots) + 1) // 2]
        ends = log.rows["time"][[0, n - 1]] if n else [np.nan, np.nan]
        np.testing.assert_array_equal([first, last], ends)


@pytest.mark.parametrize("leaves_to", [1, -1])
@pytest.mark.parametrize("noise", [0.0, 1e-10, -1e-10])
def test_a_start_on_the_zero_is_no_passage(leaves_to: int, noise: float) -> None:
    """The next one is, whichever side the function leaves to, and whichever side rounding puts the
    start.
    """
    f = leaves_to * Polynomial.fromroots([noise, 0.45])
    tallies, log = passages_of([(event("passage"), 0, 0.0)], [f], on_zero=True)
    assert_near(log.rows["time"][: log.filled[0]], [0.45], 1e-14)
    assert log.rows["sign"][0] == leaves_to
    assert tallies.kept[2, 0] == 1


@pytest.mark.parametrize("least", [0.5, 1e-9, 0.0, -1e-14, -1e-9, -1e-6])
def test_a_force_that_grazes_zero_ends_the_run_beyond_rounding(least: float) -> None:
    """It comes down to a bottom at 0.77 in the midst of a step."""
    force = least + Polynomial([-0.77, 1.0]) ** 2
    liftoff = event("liftoff", ends="liftoff", direction=-1, extremes="force")
    tallies, log = passages_of([(liftoff, 0, 0.0)], [force])
    lane, functions = tallies.lane[0], tallies.functions
    if least < -1e-13:
        assert lane["status"] == Status.LIFTOFF.code
        assert lane["t"] == pytest.approx(0.77 - np.sqrt(-least), abs=1e-10)
    else:
        assert (lane["status"], log.filled[0]) == (Status.RUNNING.code, 0)
        assert functions["extremes"][0, 0, 0] == pytest.approx(least, abs=1e-13)
        assert functions["times"][0, 0, 0] == pytest.approx(0.77, abs=1e-7)


def test_a_force_that_is_zero_at_the_start_and_falls_ends_the_run_there() -> None:
    """A start on a zero is no event, but that of a function that must not fall below it."""
    force = Polynomial([1e-12, -1.0])
    tallies, _ = passages_of(
        [(event("liftoff", ends="liftoff", direction=-1, extremes="f"), 0, 0.0)], [force], SIX, True
    )
    assert tallies.lane[0]["status"] == Status.LIFTOFF.code
    assert tallies.lane[0]["t"] == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("noise", [-1e-13, 1e-13])
def test_roots_at_the_start_are_divided_out(k: int, noise: float, rng: np.random.Generator) -> None:
    """Rounding moves them, or makes more of them: the first zero is that of t^k (a - t) at a."""
    rows, zeros = rows_of((event("falls", direction=-1), 0, 0.0)), np.array([1e-9, 1e-6, 1e-3, 0.5])
    exact = [Polynomial([0.0] * k + [a, -1.0]) for a in zeros]
    times, tcs = slice_of([[p + Polynomial([noise] * k)] for p in exact], rng)
    tallies = new_tallies(rows, np.ones((len(rows.events), LANES)))
    tallies.functions["on_zero"] = -k
    continued(tallies, rows, times, tcs)
    np.testing.assert_allclose(tallies.kept[0], zeros, rtol=1e-9)
    np.testing.assert_array_equal(tallies.kept[2], 1)
