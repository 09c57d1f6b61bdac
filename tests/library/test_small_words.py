"""What the library answers to people: what may stand for a top, short representations, pickles,
faults that name.
"""

import copy
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.store.export import export


TOP = tt.TippeTop(m=0.02, R=0.02, alpha=0.3, I1=131 / 350 * 8e-6, I3=3.2e-6, g=9.82)


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run("inverting", until=0.05)


def test_a_run_a_problem_and_a_preset_stand_for_their_body(run: tt.Run) -> None:
    for source in (run, run.problem, "inverting", "rolling"):
        assert tt.theory.thresholds(source) == tt.theory.thresholds(TOP), source
        assert tt.theory.regime(source, 4e-6) == tt.theory.regime(TOP, 4e-6)
    assert tt.theory.thresholds("heavy-top").keys() == {"spin_sleeping"}
    nutation = {"energy": 0.043, "theta": 1.0, "D": 3.3e-4, "lam": 2.2e-6}
    assert tt.theory.nutation(run, **nutation) == tt.theory.nutation(TOP, **nutation)


def test_what_is_no_top_is_refused_in_a_sentence() -> None:
    for source, sentence in (
        (
            "rolling-cylinder",
            "must be a TippeTop or a HeavyTop, but is that of the system rolling-cylinder",
        ),
        (3.0, "a Run, a Problem or the name of a preset, but is 3.0"),
        (
            tt.Cylinder(m=1.0, R=1.0, alpha=0.1, I=0.4, g=9.8),
            "must be a TippeTop or a HeavyTop, but is Cylinder",
        ),
        ("invertin", "neither a TOML file nor a preset"),
    ):
        with pytest.raises(tt.InputError, match=sentence):
            tt.theory.thresholds(source)
    with pytest.raises(
        tt.InputError, match=r"must be a record such as Coulomb\(\.\.\.\), but is 'coulomb'"
    ):
        tt.theory.linear_modes(TOP, "coulomb", omega3=3.0)


def test_nutation_says_why_there_is_no_period() -> None:
    with pytest.warns(UserWarning, match="not above the effective potential at any angle"):
        assert np.isnan(tt.theory.nutation(TOP, energy=-1.0, theta=1.0, D=3e-4, lam=4e-6).period)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert tt.theory.nutation(TOP, energy=0.043, theta=1.0, D=3.3e-4, lam=2.2e-6).period > 0


def test_stores_are_overwritten_in_the_words_of_the_call(run: tt.Run, tmp_path: Path) -> None:
    for call in (lambda: run.save(tmp_path), lambda: tt.run("inverting", until=0.01, out=tmp_path)):
        with pytest.raises(tt.StoreError, match="overwrite=True") as raised:
            call()
        assert "--" not in str(raised.value)
    finished = run.save(tmp_path / "run.zarr")
    with pytest.raises(tt.StoreError):
        tt.resume(finished)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: tt.run("inverting", untill=3),
            r"run\(\) has no argument `untill`. Did you mean `until`\?",
        ),
        (
            lambda: tt.TippeTop(m=1, R=1, alfa=0.3, I1=1, I3=1, g=9),
            "has no argument `alfa`. Did you mean `alpha`",
        ),
        (
            lambda: tt.friction.Coulomb(mu=0.3, epsilon=1e-3),
            "has no argument `epsilon`. Did you mean `eps`",
        ),
    ],
)
def test_a_mistyped_keyword_is_answered_with_the_nearest(call, sentence: str) -> None:
    with pytest.raises(TypeError, match=sentence):
        call()


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


def test_one_number_is_varied_once() -> None:
    """Of two names of it the last one won."""
    both = {"omega3": [150.0], "initial.omega3": [155.0]}
    with pytest.raises(
        tt.InputError, match=r"`initial\.omega3` must be given once, but is given as `omega3` and"
    ):
        tt.ensemble("inverting", both, until=0.05)


@pytest.mark.parametrize(
    "given", [{"columns": ["theta"]}, {"output": "events"}, {"output_step": 0.1}]
)
def test_an_ensemble_is_not_asked_for_rows(given: dict) -> None:
    with pytest.raises(
        tt.InputError, match=rf"`{next(iter(given))}` must not be given in an ensemble: it keeps no"
    ):
        tt.ensemble("inverting", {"omega3": [150.0]}, until=0.05, **given)


@pytest.mark.parametrize("odd", ["no", 1])
def test_only_true_overwrites(odd, tmp_path: Path) -> None:
    """Where "no" counted as yes, it deleted what was there."""
    run = tt.run("inverting", until=1e-3, out=tmp_path / "run.zarr")
    again = tt.run("inverting", until=1e-3)
    for write in (
        lambda: tt.run("inverting", until=1e-3, out=run.path, overwrite=odd),
        lambda: again.save(run.path, overwrite=odd),
        lambda: again.plot("theta", tmp_path / "theta.png", overwrite=odd),
        lambda: again.view().save(tmp_path / "run.html", overwrite=odd),
        lambda: export(run.path, "csv", tmp_path / "run.csv", overwrite=odd),
    ):
        with pytest.raises(tt.InputError, match=r"`overwrite` must be True or False, but is"):
            write()
    with pytest.raises(tt.InputError, match=r"`dark` must be True or False"):
        again.plot("theta", dark="x")
    assert run.trajectory.sizes["time"] == 2
