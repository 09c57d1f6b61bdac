"""The loop in C has the bits of the loop in numba: random polynomials, NaN and infinities, runs, rows and lanes."""

import ctypes
import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tippetop.engine import driver, observer
from tippetop.engine.compiled import compiled
from tippetop.engine.loop import TABLES, Loop, filled, library, new_motion, structure
from tippetop.engine.loop import _Loop as LoopRecord
from tippetop.engine.slices import RULES, event_functions, new_room, signs_of, watch
from tippetop.engine.status import Status
from tippetop.engine.tallies import (
    StopRules,
    event_rows,
    new_log,
    new_samples,
    new_scratch,
    new_tallies,
    reset,
)
from tippetop.ensembles import lanes as in_lanes
from tippetop.ensembles import turns
from tippetop.mechanics.events import Event, Kept
from tippetop.mechanics.operand import leaves
from tippetop.mechanics.units import SECOND
from tippetop.problem import Problems
from tippetop.scenario import build
from tippetop_kernels import polynomials


ANY = st.floats(width=64, allow_nan=True, allow_infinity=True)
USUAL = st.floats(-2, 2)
NEAR = st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-17, -1e-17, 1e-300, 0.5, -0.5])
NUMBERS = st.one_of(USUAL, USUAL, USUAL, NEAR, ANY)


def same(a: Any, b: Any) -> None:
    """Equal bits, of records by field; every NaN is one."""
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype.names:
        for name in a.dtype.names:
            same(a[name], b[name])
    elif a.dtype.kind == "f":
        nan = np.isnan(a)
        np.testing.assert_array_equal(nan, np.isnan(b))
        assert a[~nan].tobytes() == b[~nan].tobytes(), (a, b)
    else:
        np.testing.assert_array_equal(a, b)


def test_structures_have_the_same_size() -> None:
    assert library().loop_structure_size() == ctypes.sizeof(structure(LoopRecord))


@settings(max_examples=300, deadline=None)
@given(st.integers(4, 47).flatmap(lambda n: arrays(float, n, elements=NUMBERS)), st.booleans(), st.floats(0.01, 1.0))
def test_zeros_and_extremes(p: np.ndarray, positive: bool, decay: float) -> None:
    """Coefficients that decay like those of a step, and any others."""
    p = p * decay ** np.arange(len(p))
    mine, theirs, tables = np.zeros(64), np.zeros(len(p)), filled(TABLES)
    for monotone in (False, True):
        count = library().loop_crossings(
            p.ctypes.data, len(p), positive, monotone, ctypes.byref(tables), mine.ctypes.data
        )
        expected, _ = polynomials.crossings(p, positive, theirs, np.empty_like(p), monotone)
        assert count == expected
        same(mine[:count], theirs[:count])
        for low, high in ((np.inf, -np.inf), (0.0, 0.1), (-1.0, 1.0)):
            found = np.zeros(4)
            library().loop_extremes(p.ctypes.data, len(p), low, high, monotone, ctypes.byref(tables), found.ctypes.data)
            same(found, polynomials.extremes(p, low, high, np.empty(9), monotone))


@settings(max_examples=100, deadline=None)
@given(
    st.sampled_from([1, 3, 8]).flatmap(
        lambda n: st.tuples(arrays(float, (21, n), elements=NUMBERS), arrays(float, (20, n), elements=NUMBERS))
    ),
    st.sampled_from([0, 1]),
)
def test_ranges(given_: tuple[np.ndarray, np.ndarray], shift: int) -> None:
    c, factors = given_
    lanes = c.shape[1]
    mine, theirs, sums = np.zeros((3, lanes)), np.zeros((3, lanes)), np.zeros((3, lanes))
    polynomials.ranges(c, shift, factors, *theirs, np.empty((3, lanes)))
    pointers = [a.ctypes.data for a in (c, factors, sums, *mine)]
    library().loop_ranges(lanes, len(factors), shift, *pointers)
    same(mine, theirs)


KEPT = (Kept("first", "first", ""), Kept("last", "last", ""), Kept("count", "count", ""), Kept("up", "count", "", 1))


def event(name: str, **options: Any) -> Event:
    return Event(name, name, lambda s, b: None, kept=KEPT, **options)


EVENTS = [
    event("rate", direction=1, lasting=True),
    event("force", direction=-1, ends="liftoff", extremes="force"),
    event("turning", sense=1),
    event("level", direction=-1),
    event("fallen", ends="fallen", direction=1),
]
SOURCES = [(0, 1, 1.0, 0.0), (1, 0, 1.0, 2.0), (2, 1, 1.0, 0.0), (0, 0, 1.0, -0.3), (3, 0, 1.0, 0.0)]


@settings(max_examples=150, deadline=None)
@given(st.data(), st.sampled_from([1, 3, 8]))
def test_steps_that_are_followed(data: st.DataObject, lanes: int) -> None:
    steps, size, variables = 5, 21, 7
    rows = event_rows(EVENTS, SOURCES, (4, 5, 6))
    tcs = data.draw(arrays(float, (steps, variables, size, lanes), elements=NUMBERS, fill=st.just(0.0)))
    tcs *= data.draw(st.floats(0.1, 1.0)) ** np.arange(size)[:, None]
    if data.draw(st.booleans()):
        random = np.random.default_rng(data.draw(st.integers(0, 1000)))
        tcs += random.normal(size=tcs.shape) * 0.7 ** np.arange(size)[:, None]
    lengths = data.draw(arrays(float, (steps, lanes), elements=st.one_of(st.floats(0, 1), ANY)))
    with np.errstate(all="ignore"):
        times = np.concatenate([np.zeros((1, lanes)), np.cumsum(lengths, axis=0)])
    rules = StopRules(data.draw(st.sampled_from([-1, 0])), 1, 0.5, data.draw(st.sampled_from([3, 100])), 8, 0)
    if data.draw(st.booleans()):
        rows.events["ends"] = 0
    signs = data.draw(arrays(float, (len(EVENTS), lanes), elements=st.sampled_from([-1.0, 1.0])))
    on_zero = data.draw(arrays(bool, (len(EVENTS), lanes)))
    seen = []
    for way in ("numba", "C"):
        tallies, log = new_tallies(rows, lanes), new_log(1000, 0)
        for lane in range(lanes):
            reset(tallies, rows, lane, signs[:, lane], on_zero[:, lane])
        if way == "numba":
            observer.follow(times, tcs, rows, rules, tallies, log, new_scratch(size, lanes))
        else:
            motion = driver.Motion(*[np.zeros(lanes)] * 11)._replace(tc=np.zeros(tcs.shape[1:]))
            Loop(motion, rows, tallies, log, new_samples(0, 0), rules).follow(times, tcs)
        seen.append((tallies.lane, tallies.functions, tallies.kept, *log[:6]))
    for mine, theirs in zip(*seen, strict=True):
        same(mine, theirs)


PRESETS = ["inverting", "rolling", "cohen", "gliding-cylinder"]


@pytest.mark.parametrize("spoil", [None, "state", "end", "stall"])
@pytest.mark.parametrize("kind", ["none", "times", "few", "steps"])
@pytest.mark.parametrize("preset", PRESETS)
def test_runs(preset: str, kind: str, spoil: str | None, rng: np.random.Generator) -> None:
    problem = build.load(preset, until=1.0)
    code = compiled(
        problem.system, problem.form.name, type(problem.friction), "double", problem.tolerance, 0, False, True
    )
    assert code.machine is not None
    end = float(problem.until) / float(problem.scales.of(SECOND))
    times = {
        "times": np.sort(rng.uniform(0, end, 3000)),
        "few": np.linspace(0, end, 20),
        "steps": np.zeros(3000),
        "none": np.zeros(0),
    }[kind]
    seen = []
    for way in ("numba", "C"):
        motion, room = new_motion(code.integrator, 1), new_room(code)
        watch(room.rows.events, code.rows.events, problem)
        room.tallies.functions[:] = 0.0
        reset(room.tallies, room.rows, 0, *signs_of(event_functions(problem.alone)[0]))
        start = problem.start()
        motion.state[: len(start), 0] = start
        motion.pars[:, 0] = [float(leaf) for leaf in leaves(problem.internal_body)][: len(motion.pars)]
        motion.end[0] = end
        rows = driver.no_rows(len(start), code.rounding)._replace(
            times=times.copy(), states=np.zeros((len(start), len(times))), steps=kind == "steps"
        )
        rules = RULES._replace(most_steps=77) if spoil == "stall" else RULES
        if way == "numba":
            go = driver.drive.on(code.machine.step, code.machine.dense, driver.Motion(*motion), *room, rows, rules)
        else:
            loop = Loop(motion, *room[:4], rules, code.machine.step, code.machine.dense)
            loop.fill(rows.times, rows.states, rows.filled, rows.steps, rows.rounding)
            go = loop.drive
        made = []
        for most in (20, 3, 0, 1 << 40):
            made.append(go(most))
            if spoil == "state":
                motion.pars[:] = np.nan
            if spoil == "end":
                motion.end[0] = np.inf
            if spoil == "end" and most == 0:
                break
        seen.append((*motion, *room.tallies, *room.log, *room.samples, rows.times, rows.states, rows.filled, made))
        if spoil == "state":
            assert Status.NON_FINITE.code in room.tallies.lane["status"]
    for mine, theirs in zip(*seen, strict=True):
        same(mine, theirs)


@pytest.mark.parametrize("lanes", [1, 3, 8])
@pytest.mark.parametrize("preset", ["inverting", "rolling", "heavy-top"])
def test_lanes(preset: str, lanes: int, rng: np.random.Generator) -> None:
    n = 3 * lanes + 1
    base = build.load(
        preset, ["form=vector", "run.stop_when=settled"] if preset == "inverting" else ["form=vector"], 0.5
    )
    spins = base.initial["omega3"] * rng.uniform(0.8, 1.2, n)
    tops = Problems.vary(base, {"initial.omega3": spins, "run.until": rng.uniform(0.1, 0.5, n)})
    functions = event_functions(tops)
    signs, on_zero = signs_of(functions)
    seen = []
    for way in ("numba", "C"):
        mine = in_lanes.Lanes(tops, lanes, every=2)
        assert mine.machine is not None
        made = turns.new_tops(tops.start, tops.pars[: len(mine.motion.pars)], tops.end, signs, on_zero, mine.rows)
        machine, watched = mine.machine, (mine.rows, mine.tallies, mine.log, mine.samples)
        if way == "numba":
            go = turns.drive_lanes.on(
                machine.step, machine.dense, mine.motion, *watched, mine.scratch,
                made, mine.queue, mine.fresh, mine.out, mine.rules,
            )  # fmt: skip
        else:
            loop = Loop(mine.motion, *watched, mine.rules, machine.step, machine.dense)
            loop.take(made, mine.queue, mine.fresh)
            go = loop.drive_lanes
        numbers, steps = iter(range(n)), []
        while True:
            if mine.queue.waiting[0] == 0:
                more = np.array([*itertools.islice(numbers, lanes)], int)
                mine.queue.tops[: len(more)] = more
                mine.queue.waiting[0] = len(more)
            if mine.queue.waiting[0] == 0 and not (mine.top >= 0).any():
                break
            steps.append(go(50))
            mine.samples.filled[0] = 0
        seen.append((*mine.motion, *mine.tallies, *mine.samples, *made, *mine.queue, steps))
    for one, other in zip(*seen, strict=True):
        same(one, other)
