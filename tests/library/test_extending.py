"""A system, a law, an event and a column that are not in the package: in Python, and by entry
points in TOML.
"""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from unittest import mock

import laws
import numpy as np
import pytest
from examples import CANONICAL
from limits import assert_below, assert_near
from refusals import refusal

import tippetop as tt
from tippetop.columns import flagged
from tippetop.mechanics.systems import SYSTEMS


PACKAGE = Path(__file__).parents[1] / "plugin_package"
TOP = tt.TippeTop(**CANONICAL)
VISCOUS = tt.friction.Viscous(0.3)
START = {"theta": 0.1, "omega3": 155.0}
SCALED = {"m": 0.02, "R": 0.02, "alpha": 0.3, "k1": 131 / 350, "k3": 0.4, "g": 9.82}


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Import the package."""
    monkeypatch.syspath_prepend(str(PACKAGE / "src"))
    import quadratic_tops

    return quadratic_tops


def test_a_law_of_ones_own(own) -> None:
    """With drag = 0 it is viscous friction, to the last bit; with drag it takes more energy at the
    same mu.
    """
    with refusal("must be registered"):
        tt.run(TOP, own.Quadratic(0.3, 0.0), start=START, until=0.5)
    tt.extending.register(own.Quadratic)
    plain = tt.run(TOP, VISCOUS, start=START, until=0.5)
    same = tt.run(TOP, own.Quadratic(0.3, 0.0), start=START, until=0.5)
    more = tt.run(TOP, own.Quadratic(mu=0.3, drag=50.0), start=START, until=0.5)
    np.testing.assert_array_equal(same.trajectory.theta, plain.trajectory.theta)
    assert float(more.trajectory.work[-1]) != float(plain.trajectory.work[-1])
    assert more.summary.friction.to_dict() == {"law": "quadratic", "mu": 0.3, "drag": 50.0}
    assert_below(1e-13, more.drift)
    with refusal(r"`friction.drag` must be at least 0.0, but is -1"):
        tt.run(TOP, own.Quadratic(0.3, -1.0), start=START, until=0.5)


def test_laws_know_it(own, rng: np.random.Generator) -> None:
    """The law tests of the package hold for the system and the law, in every form."""
    tt.extending.register(own.Quadratic)
    tt.extending.register(own.SCALED_TIPPE_TOP)
    for _, form, friction, law in laws.asked({"scaled-tippe-top": own.SCALED_TIPPE_TOP}):
        laws.assert_holds(law, laws.case(own.SCALED_TIPPE_TOP, form, friction, rng))


def test_an_event_and_a_column_of_ones_own(own) -> None:
    run = tt.run(
        "inverting",
        events=[own.EIGHTH],
        columns=[own.SPIN_ENERGY],
        start={"theta": 0.8},
        until=1.0,
    )
    log = run.events.isel(event=flagged(run.events.kind, "eighth"))
    assert log.sizes["event"] > 0
    assert_near(log["theta"], np.pi / 4, 1e-14)
    rows = run.trajectory
    np.testing.assert_allclose(rows["spin_energy"], 3.2e-6 * rows["omega3"] ** 2 / 2, rtol=1e-13)
    assert rows["spin_energy"].attrs["units"] == "J"
    assert run.summary.event_counts.eighth == log.sizes["event"]


def test_a_stored_run_with_records_of_ones_own_goes_on(own, tmp_path: Path) -> None:
    """It is continued, certified and replayed with the records that it was made with; nothing of it
    is lost.
    """
    mine = {"events": [own.EIGHTH], "columns": [own.SPIN_ENERGY]}
    run = tt.run("inverting", **mine, start={"theta": 0.8}, until=0.1, out=tmp_path / "run.zarr")
    assert run.certify(0.05).theta < 1e-12
    assert "spin_energy" in run.replay(0.0, 0.05, 0.01)
    opened = tt.open(tmp_path / "run.zarr", **mine)
    assert opened.problem.system is run.problem.system
    with refusal(
        r"the run has `eighth`, `spin_energy`, which tippe-top has not: give the",
    ):
        tt.resume(tmp_path / "run.zarr", until=0.2)
    with refusal(r"the run has `spin_energy`, which tippe-top has not: give the"):
        tt.resume(tmp_path / "run.zarr", until=0.2, events=[own.EIGHTH])
    with refusal("must be given, but `eighth` is a name"):
        tt.resume(tmp_path / "run.zarr", until=0.2, events=["eighth"])
    longer = tt.resume(tmp_path / "run.zarr", until=0.2, **mine)
    whole = tt.run("inverting", **mine, start={"theta": 0.8}, until=0.2)
    assert longer.events.equals(whole.events)
    np.testing.assert_array_equal(longer.trajectory.spin_energy, whole.trajectory.spin_energy)
    assert (
        tt.run("inverting", start=tmp_path / "run.zarr", until=0.01).trajectory.sizes["time"] == 11
    )


def test_which_events_are_logged(own) -> None:
    """All by default, none of an empty list; user-defined ones next to those that are named."""

    def logged(events) -> tuple[str, ...]:
        return tt.run("inverting", until=0.05, events=events).problem.events

    assert {"turning", "equator", "inverted"} <= set(logged(None))
    assert logged([]) == ()
    assert logged("turning") == ("turning",)
    assert logged(["turning", own.EIGHTH]) == ("turning", "eighth")


def test_a_system_of_ones_own(own) -> None:
    """Passed as a record or by its name, it is the tippe top in other numbers."""
    run = tt.run(own.SCALED_TIPPE_TOP, VISCOUS, parameters=SCALED, start=START, until=2.0)
    assert_near(
        run.trajectory.theta,
        tt.run(TOP, VISCOUS, start=START, until=2.0).trajectory.theta,
        1e-10,
    )
    assert "spin_energy" in run.trajectory
    with refusal(r"`parameters.k3` must be at most 2\*k1"):
        tt.run(
            own.SCALED_TIPPE_TOP,
            VISCOUS,
            parameters={**SCALED, "k3": 1.0},
            start=START,
            until=2.0,
        )
    tt.extending.register(own.SCALED_TIPPE_TOP)
    tables = {
        "system": "scaled-tippe-top",
        "parameters": SCALED,
        "initial": START,
        "run": {"until": 0.5},
    }
    assert "k1" in tt.run(tables, VISCOUS).summary.parameters
    many = tt.ensemble(tables, {"k1": np.array([0.3, 0.35, 0.4]), "mu": np.full(3, 0.3)}, VISCOUS)
    assert list(many["status"].values) == [1, 1, 1]


@pytest.mark.parametrize(
    "around",
    [
        {"air": {"c1": 1e-8}},
        {"plane": {"tilt": 0.02}},
        {"plane": {"amplitude": 1e-5, "frequency": 20.0}, "contact": {"e_n": 0.0}},
        {"plane": {"omega": 2.0}},
    ],
)
def test_a_body_keeps_the_units_that_its_system_gives_in_surroundings(around: dict) -> None:
    """`body_units` may be no formula of units: this body divides."""
    base = tt.extending.SYSTEMS["tippe-top"]
    dividing = base.replace(
        name="dividing-top", body=lambda p, law: base.body({**p, "R": p["R"] ** 2 / p["R"]}, law)
    )
    with mock.patch.dict(SYSTEMS):
        tt.extending.register(dividing)
        rows, others = (
            tt.run("inverting", system=system.name, until=0.05, **around).trajectory
            for system in (base, dividing)
        )
    np.testing.assert_array_equal(rows.axis, others.axis)


def test_workers_of_a_sweep_know_packages_only(
    own, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is registered in this process alone runs in it; with workers, that is said before
    anything is tried.
    """
    monkeypatch.chdir(tmp_path)
    tt.extending.register(own.Quadratic)
    tt.extending.register(own.SCALED_TIPPE_TOP)
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    (tmp_path / "plan.toml").write_text(PLAN)
    for where in ({"workers": 2}, {"scheduler": "tcp://127.0.0.1:1"}):
        with refusal("`scaled-tippe-top` must come from an installed package"):
            tt.sweep("plan.toml", "sweep.zarr", **where)
    assert not (tmp_path / "sweep.zarr").exists()
    assert list(tt.sweep("plan.toml", "sweep.zarr")["status"].values) == [1] * 5
    (tmp_path / "law.toml").write_text(
        'scenario = "inverting"\n[set.friction]\nlaw = "quadratic"\nmu = 0.3\ndrag = 1.0\n'
        '[[axis]]\nof = "initial.omega3"\nlinspace = [90.0, 200.0]\nn = 2\n'
    )
    with refusal("the friction law `quadratic` must come from an installed package"):
        tt.sweep("law.toml", "law.zarr", workers=2)
    with refusal("`workers` must be a whole number"):
        tt.sweep("plan.toml", "sweep.zarr", workers=1.5)


SCENARIO = f"""
system = "scaled-tippe-top"
[parameters]
{chr(10).join(f"{name} = {value!r}" for name, value in SCALED.items())}
[friction]
law = "quadratic"
mu = 0.3
drag = 10.0
[initial]
theta = 0.1
omega3 = 155.0
[run]
until = 0.5
"""
PLAN = """
scenario = "scenario.toml"
[[axis]]
of = "friction.drag"
linspace = [0.0, 100.0]
n = 5
"""
COMMANDS = """
import sys
from tippetop.cli import outcome
for arguments in (
    ["check", "scenario.toml", "--json"],
    ["run", "scenario.toml", "--out", "run.zarr", "--json"],
    ["info", "run.zarr", "--json"],
    *(
        [
            ["plot", "run.zarr", "theta", "--out", "theta.png"],
            ["plot", "run.zarr", "states", "--out", "phase.png"],
            ["check", "plan.toml", "--json"],
            ["sweep", "plan.toml", "--out", "sweep.zarr", "--json"],
        ]
        if "sweep" in sys.argv
        else []
    ),
    ["systems", "--json"],
):
    code = outcome(arguments)
    assert code == 0, (arguments, code)
"""


def installed(folder: Path) -> Path:
    """The metadata that an installation of the package leaves: its entry points."""
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    info = folder / f"quadratic_tops-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    groups = project["entry-points"].items()
    lines = (
        f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in entries.items())
        for group, entries in groups
    )
    (info / "entry_points.txt").write_text("\n".join(lines))
    return folder


@pytest.mark.parametrize("more", [[], pytest.param(["sweep"], marks=pytest.mark.slow)])
def test_an_installed_package_is_known_by_name(more: list[str], tmp_path: Path) -> None:
    """check, run, info, plot, sweep and systems know what the entry points of an installed package
    name.

    A sweep of a law of one's own in this process has its own test; its lanes, which the check of a
    plan tries too, compile for ten seconds.
    """
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    (tmp_path / "plan.toml").write_text(PLAN)
    places = [str(PACKAGE / "src"), str(installed(tmp_path)), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", COMMANDS, *more],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(places)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert found[0]["friction"] == {"law": "quadratic", "mu": 0.3, "drag": 10.0}
    assert "spin_energy" in str(found[0]["at_start"])
    assert found[1]["status"] == "finished"
    assert "scaled-tippe-top" in found[-1]
    made = {"run.zarr"} | ({"theta.png", "phase.png", "sweep.zarr"} if more else set())
    assert made <= {path.name for path in tmp_path.iterdir()}
