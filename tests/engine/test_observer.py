"""What is kept of the events of a top, from Taylor coefficients whose zeros are known: no integrator, no body."""

from math import factorial

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from tippetop.engine.status import Status
from tippetop.ensembles.observer import EVERY, PATIENCE, TINY, follow
from tippetop.ensembles.tallies import LEAST, MOST, EventRows, StopRules, Tallies, event_rows, new_tallies, reset
from tippetop.mechanics.events import Event, Kept


ORDER, LANES, STEPS = 12, 4, 40
KEPT = (Kept("first", "first", ""), Kept("last", "last", ""), Kept("count", "count", ""), Kept("up", "count", "", 1))
UNTIL = 2.0
NO_RULES = StopRules(lasting=-1, way=0, settled_for=1.0, most_steps=10**6)


def event(name: str, **options: object) -> Event:
    return Event(name, name, lambda s, b: None, kept=KEPT, **options)  # type: ignore[arg-type]


def rows_of(*sources: tuple[Event, int, float]) -> EventRows:
    """Events that are a variable (shift 0) or its rate (shift 1), plus an offset; event i reads variable i."""
    places = [(i, shift, 1.0, offset) for i, (_, shift, offset) in enumerate(sources)]
    n = len(sources)
    return event_rows([event for event, _, _ in sources], places, np.arange(n + 3), (n, n + 1, n + 2))


def slice_of(variables: list[list[Polynomial]], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Times (steps + 1, lanes) and coefficients (steps, rows, ORDER + 1, lanes) of each lane's variables; 3hat is
    upright. Steps differ from lane to lane."""
    inner = np.sort(rng.uniform(0.0, UNTIL, (STEPS - 1, LANES)), axis=0)
    times = np.concatenate([np.zeros((1, LANES)), inner, np.full((1, LANES), UNTIL)])
    rows = len(variables[0])
    tcs = np.zeros((STEPS, rows + 3, ORDER + 1, LANES))
    tcs[:, rows + 2, 0] = 1.0
    for lane, polynomials in enumerate(variables):
        for row, p in enumerate(polynomials):
            for k in range(ORDER + 1):
                tcs[:, row, k, lane] = (p.deriv(k) if k else p)(times[:-1, lane]) / factorial(k)
    return times, tcs


def followed(
    rows: EventRows, times: np.ndarray, tcs: np.ndarray, signs: np.ndarray, rules: StopRules = NO_RULES
) -> Tallies:
    """The tallies after these steps, of tops whose functions have these signs at the start, (events, lanes)."""
    tallies = new_tallies(rows, LANES)
    for lane in range(LANES):
        reset(tallies, rows, lane, signs[:, lane], np.zeros(len(signs), bool))
    follow(times, tcs, rows, rules, tallies, np.empty((2, (STEPS // EVERY + 1) * LANES), np.int64))
    return tallies


def random_roots(rng: np.random.Generator) -> list[np.ndarray]:
    """Roots of each lane, one at most in every tenth of the time; a lane may have none."""
    tenths = [np.sort(rng.choice(10, n, replace=False)) for n in (0, 1, 3, 5)]
    return [UNTIL * (tenth + rng.uniform(0.1, 0.9, len(tenth))) / 10 for tenth in tenths]


def with_roots(roots: np.ndarray) -> Polynomial:
    return Polynomial.fromroots(roots) if len(roots) else Polynomial([1.0])


def signs_of(functions: list[Polynomial]) -> np.ndarray:
    return np.sign([[function(0.0) for function in functions]])


@pytest.mark.parametrize("shift", [0, 1])
def test_what_is_kept_is_that_of_the_roots(shift: int, rng: np.random.Generator) -> None:
    """First, last, how many, how many rising; of a variable and of a rate alike."""
    rows = rows_of((event("passage"), shift, 0.0))
    for _ in range(10):
        roots = random_roots(rng)
        functions = [with_roots(r) for r in roots]
        variables = [[f.integ(k=3.0)] if shift else [f] for f in functions]
        kept = followed(rows, *slice_of(variables, rng), signs_of(functions)).kept
        for lane, known in enumerate(roots):
            first, last, count, rising = kept[:, lane]
            assert count == len(known)
            assert rising == (len(known) + 1) // 2  # the last sign is +, so the last passage rises
            if len(known):
                assert (first, last) == pytest.approx((known[0], known[-1]), abs=1e-11)
            else:
                assert np.isnan([first, last]).all()


def test_a_direction_lets_the_other_passages_through(rng: np.random.Generator) -> None:
    roots = [np.array([0.3, 0.7, 1.1])] * LANES
    functions = [with_roots(r) for r in roots]
    kept = followed(
        rows_of((event("falling", direction=-1), 0, 0.0)), *slice_of([[f] for f in functions], rng), signs_of(functions)
    ).kept
    np.testing.assert_allclose(kept[:3], np.array([[0.7], [0.7], [1]]) * np.ones(LANES), rtol=0, atol=1e-12)


def test_an_offset_moves_the_level(rng: np.random.Generator) -> None:
    """The variable is the time itself: it passes the level when it is there."""
    functions = [Polynomial([0.0, 1.0])] * LANES
    rows = rows_of((event("level"), 0, -1.25))
    kept = followed(rows, *slice_of([[f] for f in functions], rng), -np.ones((1, LANES))).kept
    np.testing.assert_allclose(kept[0], 1.25, rtol=0, atol=1e-14)


def test_the_first_ending_ends_the_top_and_what_comes_later_is_not_seen(rng: np.random.Generator) -> None:
    """Other lanes go on; the earlier of two endings counts, in whatever order the events are."""
    ends = [np.array([0.9]), np.array([1.3]), np.array([]), np.array([0.9])]
    others = [np.array([0.2, 0.85, 0.95])] * LANES
    other_ends = [np.array([1.3]), np.array([0.9]), np.array([]), np.array([])]
    lanes = [[-with_roots(e) if len(e) else with_roots(e), with_roots(o), -with_roots(x) if len(x) else with_roots(x)]
             for e, o, x in zip(ends, others, other_ends, strict=True)]  # fmt: skip
    rows = rows_of(
        (event("liftoff", ends="liftoff", direction=-1), 0, 0.0),
        (event("other"), 0, 0.0),
        (event("fallen", ends="fallen", direction=-1), 0, 0.0),
    )
    signs = np.sign([[functions[e](0.0) for functions in lanes] for e in range(3)])
    found = followed(rows, *slice_of(lanes, rng), signs)
    codes = [Status.LIFTOFF, Status.FALLEN, Status.RUNNING, Status.LIFTOFF]
    assert found.lane["status"].tolist() == [status.code for status in codes]
    np.testing.assert_allclose(found.lane["t"], [0.9, 0.9, UNTIL, 0.9], rtol=0, atol=1e-12)
    assert found.kept[len(KEPT) + 2].tolist() == [2, 2, 3, 2]
    assert found.lane["steps"][2] == STEPS
    assert np.all(found.lane["steps"][[0, 1, 3]] < STEPS)


def test_extremes_are_those_of_the_function_until_the_top_ends(rng: np.random.Generator) -> None:
    """Stationary where its slope has its roots; beyond the end it would be less."""
    slopes = [np.sort(rng.uniform(0.1, 1.9, 3)) for _ in range(LANES)]
    functions = [Polynomial.fromroots(s).integ() + 10.0 for s in slopes]
    stop = 1.0
    rows = rows_of((event("force", extremes="force"), 0, 0.0), (event("end", ends="liftoff"), 0, 0.0))
    signs = np.stack([np.ones(LANES), -np.ones(LANES)])
    for final, ending in ((UNTIL, Polynomial([-1.0])), (stop, Polynomial([-stop, 1.0]))):
        found = followed(rows, *slice_of([[f, ending] for f in functions], rng), signs).functions
        for lane, (f, s) in enumerate(zip(functions, slopes, strict=True)):
            values = f(np.concatenate([[0.0, final], s[s < final]]))
            assert found[LEAST, 0, lane] == pytest.approx(values.min(), abs=1e-12)
            assert found[MOST, 0, lane] == pytest.approx(values.max(), abs=1e-12)


def test_where_slices_end_changes_no_bit(rng: np.random.Generator) -> None:
    functions = [with_roots(r) for r in random_roots(rng)]
    rows = rows_of((event("passage", extremes="passage"), 0, 0.0))
    times, tcs = slice_of([[f] for f in functions], rng)
    whole = followed(rows, times, tcs, signs_of(functions))
    for cut in (1, 13, STEPS - 1):
        parts = followed(rows, times[: cut + 1], tcs[:cut], signs_of(functions))
        parts.lane["step"] = -1
        follow(times[cut:], tcs[cut:], rows, NO_RULES, parts, np.empty((2, 3 * LANES), np.int64))
        assert parts.kept.tobytes() == whole.kept.tobytes()
        assert parts.functions[LEAST : MOST + 1].tobytes() == whole.functions[LEAST : MOST + 1].tobytes()
        assert parts.lane["t"].tolist() == whole.lane["t"].tolist()


def test_steps_that_lead_nowhere_are_a_stall() -> None:
    """Sixty-four in a row; one that leads somewhere begins the count anew. So are too many steps of any length."""
    rows, signs = rows_of((event("passage"), 0, 0.0)), np.ones((1, LANES))
    steps = np.full((PATIENCE + 1, LANES), TINY / 2)
    steps[PATIENCE // 2, 1] = 0.1
    times = np.concatenate([np.zeros((1, LANES)), np.cumsum(steps, axis=0)])
    tcs = np.zeros((len(steps), 4, ORDER + 1, LANES))
    tcs[:, [0, 3], 0] = 1.0
    found = followed(rows, times, tcs, signs).lane
    assert found["status"].tolist() == [Status.STALLED.code, Status.RUNNING.code, *[Status.STALLED.code] * 2]
    assert found["steps"].tolist() == [PATIENCE, PATIENCE + 1, PATIENCE, PATIENCE]
    few = NO_RULES._replace(most_steps=5)
    assert followed(rows, times, tcs, signs, few).lane["steps"].tolist() == [5] * LANES
