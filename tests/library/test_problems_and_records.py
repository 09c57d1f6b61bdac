"""What a record holds cannot be changed, and a Problem that was replaced is checked as one that is
loaded.
"""

import copy
import dataclasses
import pickle
from collections.abc import Callable

import numpy as np
import pytest

import tippetop as tt
from tippetop.library.scenarios import problem_of


@pytest.mark.parametrize(
    "mapping",
    [
        lambda: tt.extending.SYSTEMS["tippe-top"].parameters,
        lambda: tt.extending.SYSTEMS["tippe-top"].laws,
        lambda: tt.extending.LAWS["viscous"].parameters,
        lambda: tt.load("inverting").parameters,
        lambda: tt.load("inverting").initial,
    ],
)
def test_what_a_record_holds_cannot_be_changed(mapping: Callable) -> None:
    """A number that was written into a run was reported, and stored, as the one of its rows."""
    held = mapping()
    before = dict(held)
    with pytest.raises((TypeError, AttributeError)):
        held["m"] = 3
    assert dict(mapping()) == before


def test_a_problem_is_copied_with_what_it_holds() -> None:
    """By pickle, deepcopy, replace; the times of its rows, too, stay as they are."""
    problem = tt.load("inverting", ["run.output_times=[0.1, 0.2]"], until=0.3)
    for same in (
        copy.deepcopy(problem),
        pickle.loads(pickle.dumps(problem)),
        dataclasses.replace(problem),
    ):
        assert (same.parameters, same.initial) == (problem.parameters, problem.initial)
        with pytest.raises(TypeError, match="cannot be changed"):
            same.initial["theta"] = 9.0
        with pytest.raises(ValueError, match="read-only"):
            same.times.times[0] = 9.0  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "problem",
    [
        lambda: tt.load("inverting"),
        lambda: tt.load("inverting", ["run.columns=['theta']", "run.output='events'"]),
        lambda: tt.load("flying"),
        lambda: tt.load("rolling", ["run.precision='longdouble'", "run.output_times=[0.1, 0.2]"]),
    ],
)
def test_a_problem_that_was_replaced_by_the_same_is_the_same(problem: Callable) -> None:
    """What is checked again is what it was, down to its system; and one that was checked is not
    checked twice.
    """
    before = problem()
    again = problem_of(dataclasses.replace(before))
    assert again is not before
    assert problem_of(again) is again
    names = [f.name for f in dataclasses.fields(before) if f.name != "times"]
    assert [getattr(again, name) for name in names] == [getattr(before, name) for name in names]
    np.testing.assert_array_equal(again.times[:], before.times[:])
