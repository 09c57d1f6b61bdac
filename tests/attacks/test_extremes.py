"""Extreme bodies, laws and spins move equally in double, in 80 bits and in another form.

The allowed difference is measured: the run is repeated from a start that is changed by 1e-10 of
itself, and a rounding error of each step may have grown as much as that change.
It is not seen what all forms and precisions share, nor motions near a pole in other forms.
"""

import contextlib
import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tops import scenarios, spread

from tippetop.errors import InputError
from tippetop.library.scenarios import problem_of
from tippetop.problem import Problem
from tippetop.runs.run import Solution, solve
from tippetop.scenario import build


pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]
NUDGE = 1e-10
GROWTH = 300 * 2.0**-52 / NUDGE  # a step has some hundred operations
PAIRS = [
    ("tippe-top", "viscous"),
    ("tippe-top", "coulomb"),
    ("rolling-tippe-top", ""),
    ("heavy-top", ""),
    ("gliding-heavy-top", "viscous"),
    ("gliding-cylinder", "viscous"),
    ("rolling-cylinder", ""),
]


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """Motions of at most some hundred steps."""
    name, law = draw(st.sampled_from(PAIRS))
    tables = draw(scenarios(name, law, scale=50.0, fastest=draw(spread(0.01, 5000.0))))
    body = tables["parameters"]
    swing = (body["g"] / body.get("R", body.get("l"))) ** 0.5
    fastest = max(1.0, swing, *map(abs, tables["initial"].values()))
    until = min(1.0, 300 / fastest) * draw(st.floats(0.1, 1.0))
    times = np.linspace(0, until, 9).tolist()
    tables["run"] = {"until": until, "output_times": times, "orientation": False}
    try:
        return build.problem(tables)
    except InputError:
        assume(False)
        raise


def nudged(problem: Problem, name: str) -> Solution:
    """Run a problem with one number of its start changed."""
    value = problem.initial[name]
    initial = problem.initial | {name: value * (1 + NUDGE) + (NUDGE if value == 0 else 0)}
    return solve(dataclasses.replace(problem, initial=initial))


def away_from_poles(run: Solution) -> bool:
    theta = np.mod(np.asarray(run.columns()["theta"].values, float), np.pi)
    band = (run.report.get("nutational_band") or {}).values()
    angles = [*theta, *(v % np.pi for v in band if isinstance(v, float))]
    return all(0.05 < angle < np.pi - 0.05 for angle in angles)


def compare(mine: Solution, wide: Solution, near: list[Solution]) -> None:
    """Compare two runs; errors may grow as the differences to the runs nearby."""
    if {run.status for run in near} != {mine.status}:  # the start decides, within rounding
        return
    assert mine.status is wide.status, (mine.reason, wide.reason)
    growth = GROWTH * max(1.0, mine.report["steps"]) ** 0.5
    drift = max(0.0, *(d for d in mine.report["drift"].values() if d is not None), 0.0)
    ends = [run.report["t_end"] for run in (mine, wide, *near)]
    allowed = 1e-13 * mine.problem.until + growth * np.ptp([ends[0], *ends[2:]])
    assert abs(ends[0] - ends[1]) <= allowed
    for name in ("theta", "energy"):
        columns: list[Any] = [run.columns()[name].values for run in (mine, wide, *near)]
        rows = min(map(len, columns))
        one, other, *rest = (np.asarray(column[:rows], float) for column in columns)
        spread = np.maximum.accumulate(np.max(np.abs(np.array(rest) - one), axis=0))
        size = 1.0 if name == "theta" else np.abs(one).max() or 1.0
        assert np.all(np.abs(one - other) <= size * (1e-12 + 100 * drift) + growth * spread)


@settings(max_examples=60, deadline=None, suppress_health_check=[*HealthCheck])
@given(problems(), st.data())
def test_a_motion_does_not_depend_on_form_and_precision(
    problem: Problem, data: st.DataObject
) -> None:
    wide = dataclasses.replace(problem, precision="longdouble")
    mine, reference = solve(problem), solve(wide)
    if not (mine.status.ordinary and reference.status.ordinary):
        assert mine.status is reference.status
        return
    near = [
        nudged(problem, name) for name in problem.initial if type(problem.initial[name]) is float
    ]
    compare(mine, reference, near)
    form = problem.system.forms[data.draw(st.sampled_from(sorted(problem.system.forms)))]
    other = dataclasses.replace(problem, form=form)
    if away_from_poles(mine) and away_from_poles(reference):
        with contextlib.suppress(InputError):  # a start that this form does not take
            compare(solve(problem_of(other)), reference, [*near, nudged(other, "theta")])
