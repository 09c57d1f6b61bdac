"""A run starts where another has ended, exactly, and its store says from which."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from refusals import refusal
from stores import assert_same, interrupted, turning
from typed import typed

import tippetop as tt
from tippetop.errors import StoreError
from tippetop.runs import recording, starting
from tippetop.runs.integration import Integration
from tippetop.runs.sinks import Sink
from tippetop.runs.summary import lines
from tippetop.store import hexfloat


SCENARIO = (
    '[initial]\nfrom = "RUN.zarr"\n[friction]\nlaw = "viscous"\nmu = 0.1\n[run]\nuntil = 2.0\n'
)


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = tmp_path_factory.mktemp("ended") / "RUN.zarr"
    recording.record(starting.load("inverting", ["run.output_step=0.01"], 3.0), store)
    return store


@pytest.fixture
def before(ended: Path, tmp_path: Path) -> Path:
    """A copy of a run that has ended."""
    return shutil.copytree(ended, tmp_path / "RUN.zarr")


def end_of(store: Path) -> np.ndarray:
    """The last internal state of a run, made again."""
    problem = tt.open(store).problem
    integration = Integration(problem)
    integration.run(Sink())
    return integration.last[0]


@pytest.mark.parametrize("precision", ["double", "longdouble"])
def test_the_start_is_the_end_to_the_last_bit(precision: str, tmp_path: Path) -> None:
    store = tmp_path / "RUN.zarr"
    recording.record(starting.load("inverting", [f"run.precision={precision}"], 1.0), store)
    (tmp_path / "NEXT.toml").write_text(SCENARIO)
    problem = starting.load(tmp_path / "NEXT.toml", [f"run.precision={precision}"])
    assert hexfloat.encode(problem.start()) == hexfloat.encode(end_of(store))
    assert problem.friction.mu == 0.1
    assert problem.initial["theta"] == pytest.approx(
        float(tt.open(store).trajectory.theta[-1]), abs=1e-15
    )
    assert (
        starting.load(
            tmp_path / "NEXT.toml", [f"run.precision={precision}", "run.orientation=false"]
        )
        .start()
        .size
        < 20
    )


def test_the_store_holds_all_that_it_needs_and_says_where_it_is_from(
    before: Path, tmp_path: Path
) -> None:
    (tmp_path / "NEXT.toml").write_text(SCENARIO)
    out = tmp_path / "NEXT.zarr"
    assert typed(f"run {tmp_path}/NEXT.toml --out {out}") == 0
    said = tt.open(out).summary.start
    assert said["from"] == "RUN.zarr"
    assert len(said.digest) == 64
    assert said.t_end == 3.0
    assert dict(lines(tt.open(out).summary))["start"] == "where RUN.zarr ended, at its t = 3 s"
    first, last = (tt.open(store).trajectory for store in (out, before))
    for name in ("theta", "psi", "x", "axis", "jellett"):
        assert first[name].values[0].tobytes() == last[name].values[-1].tobytes(), name
    expected = end_of(before)
    shutil.rmtree(before)
    assert tt.open(out).problem.start().tobytes() == expected.tobytes()
    tt.resume(out, until=2.5)
    assert tt.open(out).replay(0.0, 0.5, 0.1).theta.values[0] == first.theta.values[0]


def test_in_python_it_is_a_path(before: Path, tmp_path: Path) -> None:
    run = tt.run("inverting", dict(mu=0.1), start=before, until=2.0)
    assert run.problem.start().tobytes() == end_of(before).tobytes()
    run.save(tmp_path / "a.zarr")
    tt.run("inverting", dict(mu=0.1), start=str(before), until=2.0, out=tmp_path / "b.zarr")
    assert_same(tmp_path / "a.zarr", tmp_path / "b.zarr")


STANDS = [f"initial.{name}={value}" for name, value in {"theta": 2.9, "omega3": -90.0}.items()]


@pytest.mark.parametrize(
    ("changes", "ball"),
    [([], 0), (["stem.r=0.005", "stem.h=0.025", *STANDS], 1)],
    ids=["sphere", "stem"],
)
def test_what_stands_on_a_plane_that_it_may_leave_is_taken_up(
    changes: list[str], ball: int, tmp_path: Path
) -> None:
    store = tmp_path / "RUN.zarr"
    recording.record(starting.load("inverting", ["run.on_liftoff=fly", *changes], 0.05), store)
    last = tt.open(store).trajectory.isel(time=-1)
    assert last.ball == ball
    assert abs(last.gap) < 1e-15  # to rounding, below the plane too
    (tmp_path / "NEXT.toml").write_text(SCENARIO)
    problem = starting.load(tmp_path / "NEXT.toml")  # which says nothing of the contact
    assert problem.contact == tt.open(store).problem.contact
    assert hexfloat.encode(problem.start()) == hexfloat.encode(end_of(store))
    assert problem.initial["gap"] >= 0
    assert problem.initial["gap"] == pytest.approx(
        float(last.z - 0.02 * (1 - 0.3 * np.cos(last.theta))), abs=1e-15
    )


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("initial.theta=0.3", "`initial.from` must be given alone, but `theta`"),
        ("initial.from=3", "`initial.from` must be a path"),
        ("parameters.m=0.03", "`parameters` must be that of"),
        ("form=euler", "`form` must be that of"),
        ("system=rolling-tippe-top", "`system` must be that of"),
        ("run.on_liftoff=fly", "`contact` must be that of"),
    ],
)
def test_what_does_not_fit_is_said(
    change: str, sentence: str, before: Path, tmp_path: Path
) -> None:
    tables = {"parameters.m=0.03": dict(tt.open(before).attributes["parameters"])}
    scenario = SCENARIO
    if change in tables:
        scenario += "[parameters]\n" + "".join(
            f"{name} = {value!r}\n" for name, value in tables[change].items()
        )
    (tmp_path / "NEXT.toml").write_text(scenario)
    with refusal(sentence):
        starting.load(tmp_path / "NEXT.toml", [change])


def test_a_run_that_has_not_ended_or_is_none_is_refused(before: Path, tmp_path: Path) -> None:
    (tmp_path / "NEXT.toml").write_text(SCENARIO)
    shutil.rmtree(before)
    for command in ("run", "check"):
        assert typed(f"{command} {tmp_path}/NEXT.toml") == 5
    interrupted(before, turning(100.0))
    with pytest.raises(StoreError, match="must have come to its end to start from"):
        starting.load(tmp_path / "NEXT.toml")


def test_many_tops_do_not_start_there(before: Path) -> None:
    with refusal("a single run"):
        tt.ensemble(
            tt.run("inverting", start=before, until=1.0).problem, {"friction.mu": [0.1, 0.2]}
        )
