"""The event log: which turnings are rounding, and what their amplitudes are."""

import numpy as np
import pytest
from limits import assert_near

import tippetop
from tippetop.engine.loop import count_turnings
from tippetop.engine.status import Status
from tippetop.engine.tallies import Tallies, event_rows, new_tallies
from tippetop.mechanics.event import NOISE_FLOOR
from tippetop.runs import starting
from tippetop.runs.run import solve


def count(
    theta: list[float], sign: list[int], end: float, pieces: int = 1
) -> tuple[list[int], Tallies]:
    """Return the turnings that are confirmed when they come in several pieces, and the tallies of
    the run.
    """
    tallies, found, waiting = new_tallies(event_rows([], [], []), np.ones((0, 1))), [], -1
    for rows in np.array_split(np.arange(len(theta) + 1), pieces):
        ways, angles = np.array([*sign, 0])[rows], np.array([*theta, end])[rows]
        for row, confirms, waits in zip(
            rows, *count_turnings(tallies.lane, ways, angles), strict=True
        ):
            found += [waiting] * bool(confirms)
            waiting = int(row) if waits else waiting
    return found, tallies


@pytest.mark.parametrize("pieces", [1, 2, 4])
def test_turnings_that_count_are_those_that_a_zigzag_filter_keeps(
    pieces: int, rng: np.random.Generator
) -> None:
    """Swings of a few quarters of the floor, exact in doubles, so that some are the floor itself;
    their band is that of the tallies.
    """
    for _ in range(100):
        sign = np.where(np.arange(30) % 2, 1, -1) * rng.choice([-1, 1])
        theta = np.cumsum(-sign * rng.integers(1, 9, 30)) * (NOISE_FLOOR / 4)
        end = float(theta[-1] + sign[-1] * rng.integers(0, 9) * (NOISE_FLOOR / 4))
        found, tallies = count(theta.tolist(), sign.tolist(), end, pieces)
        assert found == zigzag([*theta.tolist(), end], int(sign[0]))
        tally = tallies.lane[0]
        assert int(tally["turnings"]) == len(found)
        if found:
            assert tally["theta_min"] == theta[found].min()
            assert tally["theta_max"] == theta[found].max()


def zigzag(path: list[float], way: int) -> list[int]:
    """The rows of the extremes from which a path comes back by the noise floor; the first is sought
    below for way 1.
    """
    kept, best = [], 0
    for row in range(1, len(path)):
        if way * (path[row] - path[best]) >= NOISE_FLOOR:
            kept.append(best)
            best, way = row, -way
        elif way * (path[row] - path[best]) < 0:
            best = row
    return kept


def test_amplitude_is_the_swing_since_the_turning_before() -> None:
    run = tippetop.run("inverting", until=2.0).solution
    turning = run.events.of("turning")
    swing = np.abs(np.diff(turning.theta, prepend=0.1))
    assert_near(turning.amplitude, swing, 1e-15)
    assert np.all(np.isnan(run.events.amplitude[run.events.kind != 0]))


@pytest.mark.parametrize("start", [{}, {"phi": 1.0}])
def test_a_run_released_at_rest_does_not_log_its_start(start: dict[str, float]) -> None:
    events = tippetop.run("inverting", start=start, until=0.5).solution.events
    assert events.time[0] > 1e-3
    assert np.all(np.diff(events.theta_dot_sign) != 0), "minima and maxima alternate"


AT_REST = {"initial.omega3": 0.0, "initial.theta": 0.0, "initial.phi_dot": 0.0, "friction.mu": 0.3}
KNOWN = (
    # a turning in the first step, which the integrator's own detection missed, finding the start
    # twice
    (31.882596139055472, 2.448384987785755, -22.071083809249515, 0.5),
    # the first turning in the same step as the start, which the lanes missed
    (65.94886167813415, 0.022550316141261836, -3.450667221634134, 0.25),
)


def test_starts_at_rest_count_the_same_turnings_in_lanes_and_alone(
    rng: np.random.Generator,
) -> None:
    """A start at rest is a zero of theta' and no turning."""
    low, high = np.array([0, 0.05, -30, 0.3]), np.array([170, 3.0, 30, 0.3])
    starts = np.array([*KNOWN, *rng.uniform(low, high, (8, 4))])
    varied = dict(zip(AT_REST, starts.T, strict=True))
    many = tippetop.ensemble("inverting", varied, until=0.4, threads=1).turnings.values
    for top, values in enumerate(starts.tolist()):
        sets = [f"{key}={value!r}" for key, value in zip(AT_REST, values, strict=True)]
        events = solve(starting.load("inverting", sets, until=0.4)).events
        assert many[top] == np.sum(events.significant & (events.kind == 0)), sets
    assert many.sum() > 50


def test_settling_noise_is_marked_and_the_moment_is_logged_once() -> None:
    events = tippetop.run("inverting", output_step=1.0, until=300).solution.events
    turning = events.of("turning")
    assert len(events.of("settled", significant=True).time) == 1
    assert turning.significant.sum() == 395
    assert (~turning.significant).sum() > 100
    assert turning.time[turning.significant].max() < 10 < turning.time[~turning.significant].min()


def test_a_top_that_will_leave_its_pole_has_not_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its sliding dies at 1.67 s and returns half a minute later, when the unstable mode has grown:
    then it inverts.
    """
    sets = ["friction.mu=0.03", "initial.theta=1e-6", "run.stop_when=settled"]
    problem = starting.load("inverting", sets, until=400.0)
    run = solve(problem, keep=False)
    assert run.status is Status.SETTLED
    assert run.report["theta_end"] > np.pi - 1e-6
    monkeypatch.setattr("tippetop.engine.settling.will_leave", lambda *_: False)
    assert solve(problem, keep=False).report["theta_end"] < 1e-5
