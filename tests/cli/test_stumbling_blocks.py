"""What people stumbled over: each wrong word on the command line gets a sentence that says what to
write instead.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.cli import outcome
from tippetop.cli.application import app_of
from tippetop.cli.overview import COMMANDS
from tippetop.figures import catalogue, drawing
from tippetop.mechanics.systems import SYSTEMS
from tippetop.store import root


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> tuple[str, str]:
    assert outcome(arguments) == code
    return capsys.readouterr()


def help_of(capsys: pytest.CaptureFixture[str], command: str) -> str:
    assert outcome([*([command] if command else []), "--help"]) == 0
    return " ".join(capsys.readouterr().out.replace("│", " ").split())


@pytest.fixture(scope="module")
def stores(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stores")
    for name, preset in (
        ("gliding", "gliding-heavy-top"),
        ("cylinder", "rolling-cylinder"),
        ("tippe", "inverting"),
    ):
        assert (
            outcome(
                ["run", preset, "--until", "0.1", "--out", str(folder / f"{name}.zarr"), "--json"]
            )
            == 0
        )
    return folder


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["check", "inverting", "0.4"],
            "unexpected argument `0.4`. Numbers of a scenario are changed by --set",
        ),
        (
            ["sweep", "x.toml", "--out", "x", "--workers", "1.5"],
            "`--workers` must be a whole number, at least 1, but is 1.5.",
        ),
        (
            ["potential", "inverting", "--D", "1", "--lambda", "1", "--n", "2.5"],
            "`--n` must be a whole number, at least 1, but is 2.5.",
        ),
        (["run"], "SCENARIO must be given, with a value. See tippetop run --help."),
        (["run", "inverting", "--theta", "0.2"], "such as --set initial.theta=0.2."),
        (
            ["run", "inverting", "--figur", "x.png"],
            "Unknown option: --figur. Did you mean --figure?",
        ),
        (["plot", "a.zarr"], "--out must be given, with a value."),
        (
            ["plot", "a.zarr", "--out", "f.jpg"],
            "--out must end with .png, .svg or .pdf, but is `f.jpg`.",
        ),
        (
            ["run", "inverting", "--figure", "f.jpg"],
            "--figure must end with .png, .svg or .pdf, but is `f.jpg`.",
        ),
        (["run", "inverting", "--set"], "--set must be given, with a value."),
        (
            ["completion", "foo"],
            'Invalid value "foo" for SHELL. Choose from: "bash", "zsh", "fish".',
        ),
        (["run", "inverting", "--until", "1", "--until", "2"], "--until specified multiple times."),
        (["run", "inverting", "--out", ""], "`--out` must be a path, but is ''."),
        (["run", "inverting", "--columns", ","], "but has ''."),
        (["run", "inverting", "--until", "soon"], "`--until` must be a number, but is 'soon'."),
        (
            ["run", "inverting", "--until", "2 m"],
            '`--until` must be in s or what can be converted to it, but is "2 m".',
        ),
        (
            ["run", "inverting", "--certify", "--window=-1"],
            "--window must be greater than 0 and finite, but is -1.",
        ),
        (
            ["run", "inverting", "--certify", "--window", "nan"],
            "`--window` must be a number, but is 'nan'.",
        ),
        (["run", "inverting", "--window", "1"], "`--window` requires `--certify`."),
        (
            ["run", "inverting", "--until", "-1 s"],
            "`run.until` must be greater than 0.0, but is -1.0.",
        ),
        (["run", "inverting", "--until", "--json"], "`--until` must be a number"),
        (["run", "inverting", "--out", "--json"], "--out must be given, with a value."),
        (["rum", "inverting"], "unknown command `rum`. Did you mean `run`?"),
        (
            ["run", "invertin"],
            "`invertin` is neither a TOML file nor a preset. Did you mean `inverting`?",
        ),
        (
            ["potential", "rolling-cylinder", "--D", "1", "--lambda", "2"],
            "tippe tops only; this is a rolling cylinder.",
        ),
        (["sweep", "inverting", "--out", "s.zarr"], "this is a scenario, not a plan"),
        (
            ["surface", "inverting", "--out", "f.zarr", "--threads", "0"],
            "`--threads` must be a whole number, at least 1, but is 0",
        ),
        (
            ["surface", "inverting", "--D", "0:1e300:5", "--out", "f.zarr"],
            "`--D` and `--lambda` must leave V within",
        ),
        (
            ["run", "inverting", "--set", "initial.omega3=1e150"],
            "must stay finite together, but they overflow.",
        ),
        (
            ["surface", "inverting"],
            "nothing is to be done: give --out F.zarr, --figure F.png, or both.",
        ),
    ],
)
def test_wrong_words_get_the_right_ones(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out, err = printed(capsys, *arguments, code=2)
    assert sentence in err
    assert err.count("\n") == 1
    assert out == ""


def test_a_time_may_have_a_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = tmp_path / "a.zarr", tmp_path / "b.zarr"
    printed(capsys, "run", "inverting", "--until", "1/1200 min", "--out", str(a))
    assert root.attributes(a)["run"]["until"] == 0.05
    printed(
        capsys,
        "replay",
        str(a),
        "--from",
        "10 ms",
        "--until",
        "0.02",
        "--step",
        "1e3 us",
        "--out",
        str(b),
    )
    np.testing.assert_array_equal(tt.open(b).trajectory.time, 0.01 + np.arange(11) * 0.001)


def test_a_file_is_no_store(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.csv").write_text("a,b\n")
    assert (
        "x.csv` is a file, not a store"
        in printed(capsys, "info", str(tmp_path / "x.csv"), code=5)[1]
    )
    assert (
        "nowhere` does not exist" in printed(capsys, "info", str(tmp_path / "nowhere"), code=5)[1]
    )


def test_a_plan_is_no_scenario(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of PLAN.toml, whose `[[axis]]` and `chunk` were unknown keys."""
    sentence = (
        f"tippetop: `{file}` must be a scenario, but is the plan of a sweep: tippetop "
        "sweep runs it.\n"
    )
    assert printed(capsys, "run", str(file), code=2)[1] == sentence


def test_a_figure_says_for_which_systems_it_is(
    stores: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = ["--out", str(stores / "f.png")]
    err = printed(capsys, "plot", str(stores / "gliding.zarr"), "surface", *draw, code=2)[1]
    assert "tippe" in err
    assert err.endswith("only; this is a gliding heavy top.\n")
    err = printed(capsys, "plot", str(stores / "cylinder.zarr"), "sphere", *draw, code=2)[1]
    assert "`sphere` is drawn for tops only; this is a rolling cylinder." in err
    err = printed(capsys, "plot", str(stores / "tippe.zarr"), "spere", *draw, code=2)[1]
    assert "Did you mean `sphere`?" in err


def test_help_of_plot_lists_every_kind(capsys: pytest.CaptureFixture[str]) -> None:
    from tippetop.landscape import along_run
    from tippetop.sweeps.maps import NEEDED

    text = help_of(capsys, "plot")
    assert all(f"{name}: {figure.shows}" in text for name, figure in catalogue.FIGURES.items())
    assert set(drawing._drawings()) == set(catalogue.FIGURES)
    assert all(
        callable(getattr(along_run, name))
        for name, kind in catalogue.FIGURES.items()
        if kind.in_landscape
    )
    assert set(catalogue.SWEEP_KINDS) == set(NEEDED)
    assert all(f"{name}: {shows}" in text for name, shows in catalogue.SWEEP_KINDS.items())


def test_every_argument_and_option_has_help(capsys: pytest.CaptureFixture[str]) -> None:
    app = app_of(COMMANDS)
    for command in (
        "run",
        "resume",
        "info",
        "check",
        "surface",
        "potential",
        "sweep",
        "plot",
        "export",
        "systems",
    ):
        collection = app[command].assemble_argument_collection(parse_docstring=True)
        for argument in collection:
            assert argument.parameter.help, (command, argument.name)


def test_help_points_to_the_manual(capsys: pytest.CaptureFixture[str]) -> None:
    text = help_of(capsys, "")
    assert "tippetop presets" in text
    assert "docs/" in text


def test_systems_lists_what_its_help_promises(capsys: pytest.CaptureFixture[str]) -> None:
    text, found = (
        " ".join(printed(capsys, "systems")[0].split()),
        json.loads(printed(capsys, "systems", "--json")[0]),
    )
    for name, system in SYSTEMS.items():
        assert f"{name}: {system.title}" in text
        assert found[name]["events"] == [e.name for e in system.events]
        points = {law for law, rules in system.laws.items() if not rules.regions}
        assert set(found[name]["friction"]) - {"contensou"} == points
        assert ("contensou" in found[name]["friction"]) == (name == "tippe-top")
    assert "g [m s-2]" in text
    assert "omega3 [rad s-1]" in text
    assert "centre_at_rest [true or false]" in text
    assert "coulomb (mu, eps [m s-1])" in text
    assert "turning, liftoff, equator, inverted, settled" in text


def test_info_and_check_give_units(stores: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in (["info", str(stores / "tippe.zarr")], ["check", "inverting"]):
        text = " ".join(printed(capsys, *command)[0].split())
        assert "m = 0.02 kg, R = 0.02 m, alpha = 0.3, " in text
        assert "law = viscous, mu = 0.3 s m-1" in text
        assert "theta = 0.1 rad, omega3 = 155 rad s-1" in text
        assert "events = turning, liftoff" in text


def test_json_keys_are_names_and_units_are_values(capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(printed(capsys, "check", "inverting", "--json")[0])
    assert found["at_start"]["jellett"]["unit"] == "kg m3 s-1"
    assert found["at_start"]["jellett"]["value"] == pytest.approx(6.8944413e-06)
    assert found["thresholds"]["lambda_s"]["unit"] == "kg m3 s-1"
    by_eps = json.loads(printed(capsys, "check", "leine-glocker", "--json")[0])["inversion_by_eps"]
    assert by_eps["eps"] == {"value": [0.005, 0.01], "unit": "m s-1"}
    assert by_eps["first_equator"]["unit"] == "s"


def test_an_empty_value_removes_a_key_or_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    rolling = ["check", "inverting", "--set", "system=rolling-tippe-top"]
    assert "remove the table (--set friction=)" in printed(capsys, *rolling, code=2)[1]
    assert "friction" not in json.loads(
        printed(capsys, *rolling, "--set", "friction=", "--json")[0]
    )
    events = ["check", "inverting", "--set", "run.output=events"]
    for more in ([], ["--set", "run.output_step="]):
        found = json.loads(printed(capsys, *events, *more, "--json")[0])
        assert found["run"]["output"] == "events"
        assert "output_step" not in found["run"]
    err = printed(capsys, "check", "inverting", "--set", "initial.thta=", code=2)[1]
    assert "`initial.thta` is not: the keys are theta, omega3." in err


def test_negative_ranges_work_as_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    grid = ["--D", "-1e-4:1e-4:3", "--lambda", "-1e-6:1e-6:3"]
    printed(capsys, "surface", "inverting", *grid, "--out", str(tmp_path / "s.zarr"))
    assert (
        "F = " in printed(capsys, "potential", "inverting", "--D", "-1e-4", "--lambda", "-4e-6")[0]
    )


def test_momenta_of_a_landscape_are_texts_with_units(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["potential", "inverting", "--json"]
    in_si = printed(capsys, *words, "--D", "-2e-4", "--lambda", "4e-6")
    assert printed(capsys, *words, "--D", "-200 g m^2/s", "--lambda", "4e-6 N m^2 s") != in_si
    assert printed(capsys, *words, "--D", "-0.2 g m^2/s", "--lambda", "4e-6 N m^2 s") == in_si
    store = tmp_path / "F.zarr"
    axes = ["--D", "-0.1 g m^2/s:1e-4:3", "--lambda", "0:4 mg m^3/s:5"]
    printed(capsys, "surface", "inverting", *axes, "--out", str(store))
    surface = tt.open(store)
    assert np.array_equal(surface["D"], np.linspace(-1e-4, 1e-4, 3))
    assert np.array_equal(surface["lambda"], np.linspace(0, 4e-6, 5))
    assert outcome(["potential", "inverting", "--D", "1 kg", "--lambda", "0"]) == 2
    assert "`--D` must be in kg m2 s-1" in capsys.readouterr().err


def made_again(store: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """A finished store stays as it is, with exit 0; --overwrite makes it anew and leaves nothing
    else behind.
    """
    again = [*command, "--out", str(store)]
    assert "finished" not in printed(capsys, *again)[1]
    (store / "mark").touch()
    assert "finished" in printed(capsys, *again)[1]
    assert (store / "mark").exists()
    printed(capsys, *again, "--overwrite")
    assert not (store / "mark").exists()


def test_a_finished_surface_has_nothing_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store, command = tmp_path / "s.zarr", ["surface", "inverting", "--lambda", "0:1e-6:3", "--D"]
    made_again(store, [*command, "0:1e-4:3"], capsys)
    err = printed(capsys, *command, "0:1e-4:4", "--out", str(store), code=5)[1]
    assert "must have the same axes to be continued, but differs in D" in err
    (tmp_path / "mine").mkdir()
    err = printed(
        capsys, *command, "0:1e-4:3", "--out", str(tmp_path / "mine"), "--overwrite", code=5
    )[1]
    assert "must be a store of tippetop" in err
    assert {p.name for p in tmp_path.iterdir()} == {"s.zarr", "mine"}


def test_errors_are_those_of_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store = tmp_path / "V.zarr"
    printed(capsys, "potential", "inverting", "--D", "0", "--lambda", "4e-6", "--out", str(store))
    err = printed(capsys, "info", str(store), "--errors", code=2)[1]
    assert err == f"tippetop: `--errors` requires a run, but `{store}` is a potential.\n"


def test_a_finished_sweep_has_nothing_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'scenario = "inverting"\nset.run.until = 0.1\n[[axis]]\nof = "friction.mu"\nvalues = '
        "[0.1]\n"
    )
    made_again(tmp_path / "s.zarr", ["sweep", str(plan), "--workers", "1"], capsys)
    assert {p.name for p in tmp_path.iterdir()} == {"plan.toml", "s.zarr"}


def test_warnings_are_lines_of_ours_on_stderr() -> None:
    code = (
        "import sys, warnings; from tippetop import cli\n"
        "cli.outcome = lambda _: warnings.warn('two\\nlines', stacklevel=1) or 0\ncli.main([])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == ""
    assert found.stderr == "tippetop: warning: two lines\n"


@pytest.mark.parametrize(
    ("missing", "words", "extra"),
    [
        (
            "matplotlib",
            ["run", "inverting", "--until", "0.1", "--out", "{}/r.zarr", "--figure", "{}/f.png"],
            "figures",
        ),
        (
            "pyarrow",
            ["export", "{stores}/tippe.zarr", "--to", "parquet", "--out", "{}/r.pq"],
            "export",
        ),
        (
            "h5netcdf",
            ["export", "{stores}/tippe.zarr", "--to", "netcdf", "--out", "{}/r.nc"],
            "export",
        ),
    ],
)
def test_what_an_extra_brings_is_missed_before_anything_is_made(
    missing: str, words: list[str], extra: str, stores: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setitem(sys.modules, missing, None)
    _, said = printed(capsys, *(word.format(tmp_path, stores=stores) for word in words), code=2)
    assert (
        said == f"tippetop: this must find {missing}, but it is not installed: pip install "
        f"'tippetop[{extra}]'.\n"
    )
    assert list(tmp_path.iterdir()) == []
