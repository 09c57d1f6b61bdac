"""Random plans of sweeps: one that is wrong is refused in sentences; the others have their tops."""

import contextlib
from typing import Any

import numpy as np
import pytest
from damage import changed
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tippetop.errors import InputError
from tippetop.sweeps.plan import Plan


SPACINGS = [{"linspace": [0.1, 1.0], "n": 3}, {"geomspace": [0.1, 1.0], "n": 2}, {"values": [0.3]}]
DRAWN = [{"between": [0.2, 0.9]}, {"between": [0.1, 1.0], "log": True}]
KEYS = ["initial.omega3", "friction.mu", "parameters.alpha", "run.until", "lambda", "gamma"]


@st.composite
def plans(draw: st.DrawFn) -> dict[str, Any]:
    """Tables of plans, two in three with some values changed."""
    keys = draw(st.lists(st.sampled_from(KEYS), min_size=1, max_size=3, unique=True))
    axes = [{"of": key, **draw(st.sampled_from(SPACINGS + DRAWN))} for key in keys]
    tables = {"scenario": "inverting", "chunk": draw(st.integers(1, 9)), "axis": axes}
    if any("between" in axis for axis in axes):
        tables["sample"] = {"method": "sobol", "n": draw(st.sampled_from([1, 4])), "seed": 1}
    return draw(st.just(tables) | changed(tables) | changed(tables))


@pytest.mark.filterwarnings("ignore")
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(plans())
def test_a_random_plan_is_refused_or_has_its_tops(tables: dict[str, Any]) -> None:
    plan, refused = None, []
    try:
        plan = Plan.from_tables(tables)
    except InputError as error:
        refused = error.sentences
    assert all(sentence.rstrip().endswith((".", "?")) for sentence in refused)
    if plan is None or plan.n > 1000:
        return
    tops = np.concatenate([plan.tops(chunk) for chunk in range(plan.chunks)])
    assert tops.tolist() == list(range(plan.n))
    columns = plan.columns(tops)
    with contextlib.suppress(InputError):  # this top cannot be
        problem = plan.problem(plan.n - 1)
        for key in {*columns} - {"run.until"}:
            table, _, name = key.partition(".")
            given = getattr(problem, table)
            assert columns[key][-1] == (
                given[name] if table != "friction" else given._asdict()[name]
            )
