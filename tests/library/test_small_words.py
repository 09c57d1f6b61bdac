"""What the library answers to people: what may stand for a top, short representations, pickles,
faults that name.
"""

import copy
import pickle
from pathlib import Path

import pytest
from examples import CANONICAL

import tippetop as tt


TOP = tt.TippeTop(**CANONICAL)


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run("inverting", until=0.05)


def test_a_run_a_problem_and_a_preset_stand_for_their_body(run: tt.Run) -> None:
    for source in (run, run.problem, "inverting", "rolling"):
        assert tt.theory.thresholds(source) == tt.theory.thresholds(TOP), source
        assert tt.theory.regime(source, 4e-6) == tt.theory.regime(TOP, 4e-6)
    assert tt.theory.thresholds("heavy-top").keys() == {"spin_sleeping"}


def test_stores_are_overwritten_in_the_words_of_the_call(run: tt.Run, tmp_path: Path) -> None:
    for call in (lambda: run.save(tmp_path), lambda: tt.run("inverting", until=0.01, out=tmp_path)):
        with pytest.raises(tt.StoreError, match="overwrite=True") as raised:
            call()
        assert "--" not in str(raised.value)
    finished = run.save(tmp_path / "run.zarr")
    with pytest.raises(tt.StoreError):
        tt.resume(finished)


def test_runs_problems_and_systems_are_pickled_by_name(run: tt.Run) -> None:
    for precision in ("double", "longdouble"):
        made = tt.run("inverting", until=0.02, precision=precision)
        again = pickle.loads(pickle.dumps(made))
        assert again.problem.system is made.problem.system
        assert again.problem.form is made.problem.form
        assert again.trajectory.identical(made.trajectory)
        assert again.summary.to_dict() == made.summary.to_dict()
    assert copy.deepcopy(run.problem).system is run.problem.system
    own = tt.run(
        "inverting", until=0.02, events=tt.extending.Event("mine", "mine", lambda s, b: s.z - 0.5)
    )
    for thing in (own, own.problem, own.problem.system):
        with pytest.raises(
            pickle.PicklingError, match="cannot be pickled: its formulas are functions"
        ):
            pickle.dumps(thing)
        assert copy.copy(thing.problem if thing is own else thing) is not None
