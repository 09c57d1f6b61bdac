"""The public names: all there, documented, as the stub says; and the calls that the documentation
shows.
"""

import ast
import inspect
import pydoc
import re
import sys
from pathlib import Path
from typing import Any

import examples
import numpy as np
import pytest
from limits import assert_below, assert_near
from nightly import at_night
from stores import assert_same

import tippetop as tt
from tippetop.runs.recording import record
from tippetop.scenario import build


TOP = tt.TippeTop(**examples.CANONICAL)
HEAVY = tt.HeavyTop(**examples.HEAVY)
START = {"theta": 0.1, "omega3": 155.0}
D, LAM = np.linspace(1e-4, 6e-4, 4), np.linspace(1e-6, 6e-6, 3)
NUTATING = {"theta": 1.0, "phi_dot": 10.0, "omega3": 100.0}
FACES = [tt.derivatives, tt.errors, tt.extending, tt.friction, tt.landscapes, tt.theory]
PUBLIC = {name: getattr(place, name) for place in (*FACES, tt) for name in place.__all__}
FUNCTIONS = [name for name, public in PUBLIC.items() if inspect.isfunction(public)]


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run(TOP, tt.friction.Viscous(mu=0.3), start=START, until=8.0)


# --- names --------------------------------------------------------------------------------------


def test_the_stub_says_what_the_package_has() -> None:
    """Type checkers read the stub, Python the module: they name the same things in the
    same places.
    """
    stub = ast.parse((Path(tt.__file__).parent / "__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    typed = {alias.asname: node.module for node in imports for alias in node.names if alias.asname}
    functions = [node.name for node in stub.body if isinstance(node, ast.FunctionDef)]
    assert sorted([*typed, *functions, "__version__"]) == dir(tt) == sorted(tt.__all__)
    assert len(dir(tt)) == 32
    for name, module in typed.items():
        place = sys.modules[f"tippetop.{module}"] if module else tt
        assert getattr(tt, name) is (
            getattr(place, name) if module else sys.modules[f"tippetop.{name}"]
        )
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", tt.__version__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = tt.nothing  # type: ignore[attr-defined]


def test_a_public_name_is_in_one_place() -> None:
    """The three errors that `except` needs most are in two."""
    names = [name for face in FACES for name in face.__all__]
    assert len(names) == len(set(names))
    assert set(names) & set(dir(tt)) == {"InputError", "StoreError", "Interrupted"}


def test_signatures_are_readable() -> None:
    """They name types as a program does after `import`, without the modules of the package."""
    methods = [public for name, public in inspect.getmembers(tt.StoredRun) if name[0] != "_"]
    functions = [*filter(inspect.isfunction, [*PUBLIC.values(), *methods]), tt.Run, tt.Problem]
    for function in {*functions} - {tt.extending.root}:  # a module of formulas
        text = str(inspect.signature(function))
        assert not re.search(r"(tippetop|numpy|xarray|typing|pathlib|collections)\.", text), text


@pytest.mark.parametrize(
    ("face", "signature"),
    [
        (tt.friction, "Coulomb(mu, eps=None, *, mu_r=None, mu_d=None)"),
        (tt.extending, "Exit(event: str, to: tuple[str, ...], jump: Callable"),
    ],
)
def test_help_on_records_lists_their_fields_only(face: Any, signature: str) -> None:
    """Each record has its signature and its docstring: no methods, attributes or descriptors."""
    text = pydoc.plain(pydoc.render_doc(face))
    # Python 3.13 writes a long signature on several lines, which begin with a bar
    assert "".join(signature.split()) in re.sub(r"['|\s]", "", text)
    assert not re.search(r"\|  .*(defined here|inherited from .*):$", text, re.M)
    assert "__dataclass_fields__" not in text


@pytest.mark.parametrize("name", FUNCTIONS)
def test_help_says_what_goes_in_and_comes_out(name: str) -> None:
    function = PUBLIC[name]
    text = inspect.getdoc(function) or ""
    assert text.partition("\n")[0].endswith(".")
    parameters = inspect.signature(function).parameters
    sections = ["Returns", *(["Parameters"] if parameters else [])]
    for section in sections:
        assert re.search(rf"^{section}\n-+$", text, re.MULTILINE), (
            f"{name} has no section {section}"
        )
    described = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-+$|\Z)", text, re.MULTILINE | re.DOTALL)
    for parameter in parameters:
        assert described is not None
        assert re.search(rf"(?<!\w){parameter}(?!\w)", described[1]), (
            f"{name} does not describe {parameter}"
        )


# --- bodies and laws ----------------------------------------------------------------------------


def test_a_body_is_checked_when_it_is_made() -> None:
    """All that is wrong at once, in the sentences that TOML gets; numpy's numbers are numbers."""
    bad = {"m": -1.0, "R": 0.02, "alpha": 1.5, "I1": float("nan"), "I3": 3.2e-6, "g": 9.82}
    tables = {
        "system": "tippe-top",
        "parameters": bad,
        "friction": {"law": "viscous", "mu": 0.3},
        "run": {"until": 1.0},
    }
    with pytest.raises(tt.InputError) as from_toml:
        build.problem(tables)
    with pytest.raises(tt.InputError) as found:
        tt.TippeTop(**bad)
    assert found.value.sentences == from_toml.value.sentences
    assert len(found.value.sentences) == 3
    mixed = tt.TippeTop(
        m=np.float64(0.02), R=np.array(0.02), alpha=0.3, I1=np.float32(2.0), I3=np.int64(1), g=9.82
    )
    assert all(type(value) is float for value in mixed._asdict().values())
    assert repr(tt.friction.Viscous(mu=0.3)) == "Viscous(mu=0.3)"
    assert tt.friction.Viscous(0.3) == tt.friction.Viscous(np.float64(0.3))
    with pytest.raises(AttributeError):
        TOP.m = 1.0  # type: ignore[misc]


# --- run ----------------------------------------------------------------------------------------


def test_every_way_of_saying_it_gives_the_same_bits(run: tt.Run) -> None:
    same = {"until": 8.0, "output_step": 0.008}
    tables = {
        "system": "tippe-top",
        "parameters": TOP._asdict(),
        "friction": {"law": "viscous", "mu": 0.3},
        "initial": START,
        "run": {"until": 8.0},
    }
    for other in (
        tt.run("inverting", **same),
        tt.run(
            "inverting",
            friction={"mu": np.float64(0.3)},
            parameters=TOP,
            start={"theta": 0.1},
            **same,
        ),
        tt.run(tables),
        tt.run(tt.load("inverting", ["run.until=8", "run.output_step=0.008"])),
    ):
        np.testing.assert_array_equal(other.trajectory["theta"], run.trajectory["theta"])
    assert tt.run("inverting", friction={"mu": 0.2}, until=0.1).problem.friction.mu == 0.2
    assert tt.run("inverting", friction={"law": "none"}, until=0.1).summary.friction.law == "none"
    rolling = tt.run("inverting", system="rolling-tippe-top", until=0.1)
    assert rolling.summary.system == "rolling-tippe-top"
    times = np.linspace(0, 0.1, 3)
    some = tt.run(
        "inverting", start={"psi_dot": 150.0}, until=0.1, output_times=times, events=["turning"]
    )
    np.testing.assert_array_equal(some.trajectory["time"], times)
    assert "omega3" not in some.summary.initial


@pytest.mark.parametrize(
    ("run", "sentence"),
    [
        ({"orientation": False}, "<p>Not shown in motion: "),
        ({"output_step": 4e-6}, "<p>In motion: .view() makes the page of its 25001 rows.</p>"),
    ],
)
def test_a_notebook_names_why_a_run_does_not_turn(run: dict, sentence: str) -> None:
    shown = tt.run("inverting", until=0.1, **run)._repr_html_()
    assert sentence in shown
    assert "<iframe" not in shown


def test_a_run_shows_itself(run: tt.Run, tmp_path: Path) -> None:
    assert repr(run) == "<Run of tippe-top: finished at t = 8 s, 1337 steps>"
    assert "inversion" in str(run)
    assert "pi - 0.1 at 6.943" in str(run)
    assert run._repr_html_().startswith("<b>rolling and gliding tippe top")
    assert run.summary.inversion.inverted_at == pytest.approx(6.943, abs=1e-3)
    with pytest.raises(AttributeError, match="there is no `colour`"):
        _ = run.summary.colour
    assert_below(1e-13, run.drift)
    assert run.trajectory["theta"].attrs["units"] == "rad"
    assert run.events.sizes["event"] == sum(
        n for k, n in run.summary.event_counts.items() if "signif" not in k
    )
    assert set(run.datasets()) == {"trajectory", "events"}
    run.plot("theta", tmp_path / "theta.png")
    found = tt.run("inverting", until=0.2)
    assert found.certify().theta < 1e-12
    assert found.summary.certificate.against == "longdouble"


@pytest.mark.parametrize("preset", ["inverting", "gliding-cylinder", "flying"])
def test_a_saved_run_is_the_recorded_one_file_by_file(preset: str, tmp_path: Path) -> None:
    recorded, saved = tmp_path / "recorded.zarr", tmp_path / "saved.zarr"
    record(tt.load(preset, until=1.0), recorded)
    run = tt.run(preset, until=1.0)
    run.save(saved)
    assert_same(saved, recorded)
    run.save(saved, overwrite=True)
    stored = tt.open(saved)
    assert isinstance(stored, tt.StoredRun)
    for name, table in run.datasets().items():
        assert stored.datasets()[name].identical(table), name
    assert stored.summary.to_dict() == run.summary.to_dict()
    assert repr(stored) == repr(run).replace("<Run of", "<StoredRun of")


# --- many tops ----------------------------------------------------------------------------------


# --- theory and landscape -----------------------------------------------------------------------


def test_a_reconstruction_whose_pieces_disagree_is_no_silent_result() -> None:
    # eight rows per nutation
    run = tt.run("inverting", start=NUTATING, output_step=4e-3, until=0.3)
    with pytest.warns(UserWarning, match="its error may reach"):
        found = tt.theory.reconstruct(run)
    assert found.attrs["mismatch"] > 1e-6
    given = np.isfinite(found["theta"].values)
    assert given[: given.sum()].all(), "it ends where its pieces do not meet"
    assert given.sum() < 0.5 * given.size


@pytest.mark.parametrize(
    ("start", "mu", "until", "step"),
    [
        at_night(examples.LATE, 0.3, 2.0, 1.2e-3),
        *(at_night({}, *case) for case in ((0.3, 6.5, 2e-4), (0.15, 8.6, 1e-3))),
    ],
)
def test_a_reconstruction_ends_before_its_error_grows(
    start: dict, mu: float, until: float, step: float
) -> None:
    """Where the axis has risen, errors grow a thousandfold in a swing, while every piece agrees
    with its equation.
    """
    run = tt.run("inverting", friction={"mu": mu}, start=start, until=until, output_step=step)
    with pytest.warns(UserWarning, match="the reconstruction ends at .* error may reach"):
        theta = tt.theory.reconstruct(run)["theta"].values
    given = np.isfinite(theta)
    assert np.abs(theta - run.trajectory.theta.values)[given].max() < 1e-6
    assert run.trajectory.time.values[given].max() > until - 0.7


def test_theta_comes_back_from_the_main_equation(tmp_path: Path) -> None:
    run = tt.run("inverting", start=NUTATING, until=0.15, output_step=5e-5)
    run.save(tmp_path / "run.zarr")
    for source in (run, tt.open(tmp_path / "run.zarr")):
        found = tt.theory.reconstruct(source)
        known = np.isfinite(found["theta"].values)
        assert known.mean() > 0.8
        assert_near(found["theta"][known], run.trajectory["theta"][known], 1e-7)
        assert found.attrs["mismatch"] < 1e-8


# --- arguments that are wrong -------------------------------------------------------------------


def test_a_stored_run_is_found_from_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A relative path means the folder in which it was given."""
    monkeypatch.chdir(tmp_path)
    made = tt.run("inverting", until=0.1, out="run.zarr")
    stored = tt.open("run.zarr")
    monkeypatch.chdir("/")
    assert made.path == stored.path == tmp_path / "run.zarr"
    assert stored.trajectory.sizes == made.trajectory.sizes
    assert stored.events.sizes == made.events.sizes


def test_every_folder_with_modules_is_a_package() -> None:
    """The import contracts look at packages only: a folder without __init__.py would
    escape them.
    """
    root = Path(tt.__file__).parent
    bare = {
        path.parent for path in root.rglob("*.py") if not (path.parent / "__init__.py").exists()
    }
    assert not bare


def test_what_is_set_in_the_rows_leaves_the_run_as_it_is() -> None:
    """Degrees that were written into the rows were drawn on an axis of radians."""
    run = tt.run("inverting", until=0.01)
    theta = run.trajectory.theta.values.copy()
    rows = run.trajectory
    rows["theta"] = np.degrees(rows.theta)
    rows["theta"].attrs["units"] = "deg"
    np.testing.assert_array_equal(run.trajectory.theta, theta)
    assert run.trajectory.theta.attrs["units"] == "rad"
    assert "theta" in run.trajectory


def test_a_number_beyond_the_doubles_is_not_called_stiffness() -> None:
    run = tt.run("inverting", friction={"mu": 1e100}, until=0.1)
    assert run.summary.status == "non-finite"
    assert "a number of the scenario is too large" in str(run.summary)
