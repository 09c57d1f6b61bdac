"""heyoka's own event detection finds the events that the observer finds, at the same times: none
missing, none twice.

Its event functions are scaled by 2^-24, so that they do not control the step: the steps are the
same, and what is compared are two ways of finding zeros. A zero is known to the rounding of its
function over the slope there, whoever finds it; so times agree to 2e-15 of the run and that
rounding. Not compared: zeros whose function is known no better than 1e-7 of a step (it touches
zero, as at a cusp on the equator, or is noise, as at a pole), and pairs of zeros that are closer
than 1e-5 of a step, which both may take for none.
"""

import dataclasses
from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np
import pytest
from test_wide import Nothing

from tippetop.engine.driver import Driver
from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.engine.integrator import compiled_from
from tippetop.engine.opt_level import opt_level
from tippetop.engine.status import Status
from tippetop.engine.tallies import signs_of
from tippetop.engine.taylor import driver_of
from tippetop.mechanics.event import ON_ZERO_FOR, Event
from tippetop.mechanics.operand import leaves
from tippetop.mechanics.variables import Variables
from tippetop.problem import Problem
from tippetop.runs import starting


EVENT_SCALE = 2.0**-24
ROUNDING = 4e-15  # of a function over a step, in units of the sum of its terms: some twenty terms
KNOWN = 1e-7  # of a step: a zero that is known no better is not compared
APART = 1e-5  # of a step

FORMS = (
    ("inverting", "vector", 1.0),
    ("inverting", "euler", 0.4),
    ("rolling", "contact", 1.0),
    ("gliding-heavy-top", "vector", 1.0),
    ("heavy-top", "vector", 1.0),
    ("gliding-cylinder", "angle", 6.0),
    ("rolling-cylinder", "angle", 6.0),
)


class Found(NamedTuple):
    """Zeros of one event function, and how well each is known; internal times."""

    times: np.ndarray
    signs: np.ndarray
    known: np.ndarray  # in time
    steps: np.ndarray  # length of the step of each


@cache
def oracle(
    system: Any, form: str, law: Any, tolerance: float, orientation: bool
) -> tuple[Any, list]:
    """heyoka's integrator of the same equations, which writes down (event, time, sign)."""
    formulas = formulas_of(system, form, law)
    made = compiled_from(formulas, "double", tolerance, 0, orientation)
    q, _, body, _ = equations_of_motion(formulas, Variables(system.forms[form], orientation))
    scalars = system.forms[form].scalars(q, body)
    seen: list[tuple[int, float, int]] = []

    def note(e: int) -> Any:
        return lambda _, time, sign: seen.append((e, time, sign))

    hooks = [
        hy.nt_event(EVENT_SCALE * event.formula(scalars, body), note(e))
        for e, event in enumerate(system.events)
    ]
    start = np.zeros(len(made.integrator.state))
    return hy.taylor_adaptive(
        made.integrator.sys,
        start,
        tol=tolerance,
        high_accuracy=True,
        nt_events=hooks,
        opt_level=opt_level(),
    ), seen


def compare(made: Problem) -> int:
    """Compares the zeros that both find; how many there were to compare."""
    driver = driver_of(made)
    theirs, seen = oracle(
        made.system, made.form.name, type(made.friction), made.tolerance, made.orientation
    )
    theirs.time, theirs.state[:] = 0.0, driver.state
    theirs.pars[:] = [float(leaf) for leaf in leaves(made.internal_body)][: len(theirs.pars)]
    theirs.reset_cooldowns()
    seen.clear()
    outcome, *_, output, _ = theirs.propagate_until(driver.end, c_output=True)
    piece = driver.advance(Nothing(), 1 << 40)
    if outcome != hy.taylor_outcome.time_limit:
        assert piece.status is not Status.FINISHED
        return 0
    assert piece.status is Status.FINISHED
    np.testing.assert_allclose(  # with events LLVM rounds otherwise, at its third level
        driver.state,
        theirs.state,
        rtol=1e-12,
        atol=1e-12,
        err_msg="their events must not control the step",
    )
    compared, passages, at_rest = 0, piece.passages, signs_of(driver.at_start)[1]
    for e, event in enumerate(made.system.events):
        mine, since = passages.events == e, ON_ZERO_FOR if at_rest[e] else -1.0
        other = [
            (t, sign)
            for number, t, sign in seen
            if number == e and event.direction * sign >= 0 and t > since
        ]
        times, signs = (np.array([pair[i] for pair in other], float) for i in (0, 1))
        order = np.argsort(times)
        a = found(driver, made.system.events, output, e, passages.times[mine], passages.signs[mine])
        b = found(driver, made.system.events, output, e, times[order], signs[order])
        compared += matched(a, b, driver.end, f"{event.name} of {made.tables}")
    return compared


def found(
    driver: Driver,
    events: Sequence[Event],
    output: Any,
    e: int,
    times: np.ndarray,
    signs: np.ndarray,
) -> Found:
    """How well zeros are known: by the polynomial of the event function in the step of each."""
    record = driver.all_events.events[e]
    step = np.clip(np.searchsorted(output.times, times, side="right") - 1, 0, len(output.times) - 2)
    h = np.diff(output.times)[step]
    known = np.empty(len(times))
    for i, (at, length) in enumerate(zip(step, h, strict=True)):
        p = np.polynomial.Polynomial(
            output.tcs[at, record["row"]] * length ** np.arange(output.tcs.shape[2])
        )
        p = p.deriv() / length if record["shift"] else p + record["offset"]
        slope = abs(p.deriv()((times[i] - output.times[at]) / length))
        size = np.abs(p.coef).sum() + abs(record["offset"])
        if events[e].lasting:  # sliding: the square of a difference of numbers of order one
            size += np.sqrt(size * record["scale"])
        known[i] = ROUNDING * size / slope * length if slope > 0 else np.inf
    return Found(times, signs, known, h)


def matched(a: Found, b: Found, end: float, what: str) -> int:
    """Asserts that each clear zero of either is one of the other, with its sign."""
    for mine, other in ((a, b), (b, a)):
        gaps = np.diff(mine.times, prepend=-np.inf, append=np.inf)
        clear = (mine.known < KNOWN * mine.steps) & (
            np.minimum(gaps[1:], gaps[:-1]) > APART * mine.steps
        )
        for time, sign, known in zip(
            mine.times[clear], mine.signs[clear], mine.known[clear], strict=True
        ):
            near = np.abs(other.times - time) <= 2e-15 * end + known
            assert near.sum() == 1, (what, time, known, a.times, b.times)
            assert other.signs[near][0] == sign, (what, time)
    return int(clear.sum())


def start(preset: str, form: str, until: float, rng: np.random.Generator) -> Problem:
    """A preset that starts elsewhere, half of them at rest; no event ends it."""
    base = starting.load(preset, [f"form={form}", "run.on_liftoff=continue"], until)
    initial = {
        key: value + float(rng.uniform(-0.5, 0.5)) * max(abs(value), 0.4)
        for key, value in base.initial.items()
        if isinstance(value, float)
    }
    if "theta_dot" in base.system.initial and rng.random() < 0.5:
        initial["theta_dot"] = float(rng.uniform(-2.0, 2.0))
    return dataclasses.replace(base, initial={**base.initial, **initial})


@pytest.mark.parametrize(("preset", "form", "until"), FORMS)
def test_events_are_those_of_heyokas_detection(
    preset: str, form: str, until: float, rng: np.random.Generator
) -> None:
    """A few random starts for every system and form."""
    assert sum(compare(start(preset, form, until, rng)) for _ in range(8)) > 20


def test_every_kind_of_event_is_among_what_is_compared() -> None:
    """Long enough for each to happen."""
    happened = set()
    for preset, sets, until in (
        ("inverting", [], 8.0),
        ("inverting", ["initial.omega3=170.0"], 6.0),
        ("inverting", ["initial.omega3=0.0", "initial.theta_dot=3.0"], 0.5),
        ("gliding-heavy-top", ["initial.omega3=5.0", "initial.theta_dot=0.1"], 2.0),
    ):
        made = starting.load(
            preset,
            ["form=vector", "initial.theta_dot=0.2", "run.on_liftoff=continue", *sets],
            until,
        )
        assert compare(made) > 0
        driver = driver_of(made)
        names = [event.name for event in made.system.events]
        happened |= {names[e] for e in driver.advance(Nothing(), 1 << 40).passages.events}
    assert {"turning", "liftoff", "equator", "inverted", "settled"} <= happened
