"""The exported files of the benchmark."""

import hashlib
import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from limits import assert_near
from nightly import at_night
from scipy.spatial.transform import Rotation
from stores import files
from typed import refused, reported, typed

import tippetop as tt
from tippetop import benchmark
from tippetop.benchmark.case_files import scaled
from tippetop.benchmark.truth import VECTORS, sample_times, truth
from tippetop.exchange.simulators import text_of


CASES = ("stem-landing", "joint", "drill-to-rest", "rocking-cylinder", "bounce")
OUTLINED = ("rising-egg", "rolling-disc", "reversing-rattleback")
ALL = (*CASES, *OUTLINED)
ELLIPSOID = {"model.mjcf.xml", "model.sdf"}


@pytest.fixture(scope="module")
def exported(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("cases")
    benchmark.export(folder, ALL)
    return folder


def described_in(folder):
    """Return the description of an exported case."""
    return json.loads((folder / "case.json").read_text())


def rows_of(folder):
    """Return the reference of an exported case."""
    return pd.read_csv(folder / "reference.csv")


def test_checksums_are_of_the_files(exported):
    lines = (exported / "SHA256SUMS").read_text().splitlines()
    for line in lines:
        digest, name = line.split("  ")
        assert hashlib.sha256((exported / name).read_bytes()).hexdigest() == digest
    assert len(lines) == sum(path.is_file() for path in exported.rglob("*")) - 1


def test_export_of_one_case_keeps_the_others_in_the_lists_and_has_the_same_bytes(
    exported, tmp_path
):
    some = ["joint", "stem-landing"]
    benchmark.export(tmp_path, some)
    before = [(tmp_path / name).read_text() for name in ("README.md", "SHA256SUMS")]
    benchmark.export(tmp_path, ["joint"], overwrite=True)
    assert [(tmp_path / name).read_text() for name in ("README.md", "SHA256SUMS")] == before
    assert all(files(tmp_path / case) == files(exported / case) for case in some)


def test_description_fits_the_schema(exported):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((exported / "case.schema.json").read_text())
    for name in ALL:
        described = described_in(exported / name)
        jsonschema.validate(described, schema)
        assert set(described["files"]) | {"case.json"} == {
            path.name for path in (exported / name).iterdir()
        }


@pytest.mark.parametrize("name", CASES)
def test_numbers_of_body_law_and_start_are_those_of_the_scenario(exported, name):
    described = described_in(exported / name)
    problem, start = benchmark.case(name).problem, described["start"]
    body, given = problem.body(), described["body"]
    assert (given["mass"], given["gravity"]) == (body.m, body.g)
    assert given["moments_of_inertia"] == [body.I1, body.I1, body.I3]
    assert described["law"].get("contact", {}).get("e_n", 0.0) == (0.5 if name == "bounce" else 0.0)
    assert described["law"].get("friction", {}).get("mu") == getattr(problem.friction, "mu", None)
    row = rows_of(exported / name).iloc[0]
    for key, values in start.items():
        assert values == row[VECTORS[key]].tolist()
    axis = Rotation.from_quat(np.roll(start["quaternion"], -1)).apply([0.0, 0.0, 1.0])
    if name == "joint":
        assert_near(start["position"] + given["fixed_point"] * axis, 0, 1e-11)
        assert given["balls"] == {}
        return
    ball = given["balls"]["body"]
    gap = start["position"][2] + ball["offset"] * axis[2] - ball["radius"]
    expected = {"bounce": 0.05, "stem-landing": 0.014}.get(name, 0.0)
    assert gap == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "models"), [*zip(OUTLINED, (ELLIPSOID, set(), ELLIPSOID), strict=True)]
)
def test_an_outline_touches_the_plane_at_the_start(exported, name, models):
    """By the numbers of `case.json` alone; a format that lacks the outline is left out."""
    folder = exported / name
    assert {path.name for path in folder.glob("model.*")} == models
    described = described_in(folder)
    outline, start = described["body"]["outline"], described["start"]
    assert described["body"]["balls"] == {}
    turned = Rotation.from_quat(np.roll(start["quaternion"], -1))
    n = turned.inv().apply([0.0, 0.0, 1.0])
    if outline["kind"] == "ellipsoid":
        along = Rotation.from_euler("z", -outline["turn"]).apply(n)
        height = np.linalg.norm(along * outline["half_axes"]) - n @ outline["centre"]
    else:
        height = outline["ring"] * np.hypot(*n[:2]) + outline["tube"] - n[2] * outline["c"]
    assert start["position"][2] == pytest.approx(height, abs=1e-12)


def test_a_rattleback_that_rolls_keeps_its_energy_and_reverses_its_spin(exported):
    folder = exported / "reversing-rattleback"
    found = tt.compare(folder / "reference.csv", folder / "scenario.toml").to_dict()
    assert found["attitude"]["max"] < 1e-11
    assert found["energy_drift"] < 1e-11
    spin = rows_of(folder)["omega_z [rad/s]"]
    assert spin.iloc[0] < -1.9 < 1.9 < spin.iloc[-1]


def test_readme_names_every_outcome(exported):
    text = (exported / "README.md").read_text()
    described = [described_in(exported / name) for name in ALL]
    seen = {"rises as high"}.union(*(each["outcome"] for each in described))
    assert all(f"| `{outcome}` |" in text for outcome in seen)


MINE = """
system = "tippe-top"
parameters = { m = 0.03, R = 0.025, alpha = 0.25, I1 = 7e-6, I3 = 7.4e-6, g = 9.81 }
friction = { law = "coulomb", mu = 0.2 }
contact = { e_n = 0.3 }
initial = { theta = 0.3, omega3 = 80.0, nu_x = 0.0, nu_y = 0.0, gap = 0.01 }
run = { until = 0.2, output_step = 1e-3 }
"""


def test_a_scenario_of_the_user_is_a_case(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    mine, cases = tmp_path / "mine.toml", tmp_path / "cases"
    mine.write_text(MINE)
    assert typed(f"benchmark export {cases} joint --scenario {mine}") == 0
    described = described_in(cases / "mine")
    jsonschema.validate(described, json.loads((cases / "case.schema.json").read_text()))
    assert described["certified_error"] < 1e-10
    assert described["horizon"] == described["until"] == 0.2
    assert described["law"] == {
        "friction": {"law": "coulomb", "mu": 0.2},
        "contact": {"restitution": "energetic", "e_n": 0.3},
    }
    assert re.search(r"`joint`.*\n\| `mine` \| ", (cases / "README.md").read_text())
    result = tmp_path / "engine" / "best" / "mine"
    result.mkdir(parents=True)
    (result / "dt=1e-3.csv").write_bytes((cases / "mine" / "reference.csv").read_bytes())
    [row] = reported(f"benchmark score {result} --case {mine} --fail-above 1e-9")["results"]
    assert (row["case"], row["engine"], row["setting"]) == ("mine", "engine", "best")
    assert row["largest"]["position"] < 1e-12


def test_a_tilted_plane_is_exported_as_gravity_along_it_and_counts_in_the_energy(tmp_path):
    """A result that is late keeps its energy, however far it falls along the plane."""
    mine, cases = tmp_path / "mine.toml", tmp_path / "cases"
    mine.write_text(
        MINE.replace('"coulomb", mu = 0.2', '"none"').replace(", gap = 0.01", "")
        + "plane = { tilt = 0.3, azimuth = 0.5 }\n"
    )
    benchmark.export(cases, [mine])
    folder = cases / "mine"
    described = described_in(folder)["body"]
    along = 9.81 * np.sin(0.3) * np.array([np.cos(0.5), np.sin(0.5)])
    expected = [*along, -9.81 * np.cos(0.3)]
    assert [*described["slope"], -described["gravity"]] == pytest.approx(expected, rel=1e-12)
    texts = [(folder / f"model.{name}").read_text() for name in ("mjcf.xml", "urdf", "sdf")]
    for text in texts:
        words = re.search(r"gravity[ =>\"]+(-?[\d.e-]+ -?[\d.e-]+ -?[\d.e-]+)", text)[1]
        assert [*map(float, words.split())] == pytest.approx(expected, rel=1e-11)
    rows = rows_of(folder)
    late = rows.iloc[: len(rows) // 2 + 1].assign(**{"t [s]": rows["t [s]"][::2].to_numpy()})
    late.to_csv(tmp_path / "late.csv", index=False)
    [row] = benchmark.score(tmp_path / "late.csv", mine).to_dict()
    assert row["largest"]["position"] > 0.01
    assert row["largest"]["energy"] < 1e-11


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("bounce", ("", ""), "must not have the name of a case"),
        (
            "mine",
            ('"coulomb", mu = 0.2 }\ncontact', '"viscous", mu = 0.2 }\n#'),
            "a table [contact]",
        ),
        ("mine", ("until = 0.2", 'on_liftoff = "stop", until = 0.2'), "must reach `run.until`"),
        ("mine", ("mu = 0.2", "mu = -1.0"), "`friction.mu`"),
        ("mine", ("e_n", "e_n = 0.0 }\nair = { c1 = 1e-9 }\nplane = { omega"), "`air.c1` and `pl"),
    ],
)
def test_scenarios_that_are_no_cases(tmp_path, name, change, message):
    mine = tmp_path / f"{name}.toml"
    hops = MINE.replace("omega3 = 80.0", "theta_dot = 80.0").replace(", gap = 0.01", "")
    if "viscous" in change:  # exact Coulomb friction opens the contact by itself
        hops = hops.replace("contact =", "#")
    mine.write_text(hops.replace(*change))
    assert message in refused(f"benchmark export {tmp_path / 'cases'} --scenario {mine}")
    assert not (tmp_path / "cases").exists()


@pytest.mark.parametrize("name", ALL)
def test_parquet_and_csv_are_equal(exported, name):
    csv = rows_of(exported / name)
    parquet = pd.read_parquet(exported / name / "reference.parquet")
    pd.testing.assert_frame_equal(csv, parquet, check_dtype=False, check_exact=True)


@pytest.mark.parametrize("name", [*CASES, *map(at_night, OUTLINED)])
def test_last_bits_do_not_change_the_digits(exported, name):
    """No number lies near the threshold of its rounding; digits are those of the motion."""
    each = benchmark.case(name)
    motion, _ = truth(each.problem, sample_times(each.problem), "longdouble")
    rows = rows_of(exported / name)
    for header, (values, power) in scaled(motion).items():
        assert np.abs(values % 1 - each.certificate["rounding"][header]).min() > 5e-4
        assert np.abs(rows[header] * power - values).max() < 0.76


@pytest.mark.parametrize("name", ALL)
def test_scenario_is_the_case(exported, name):
    assert tt.load(exported / name / "scenario.toml").start() == pytest.approx(
        benchmark.case(name).problem.start(), nan_ok=True
    )


@pytest.mark.parametrize("name", CASES)
def test_models_have_the_body_and_the_start(exported, name):
    folder, body = exported / name, benchmark.case(name).problem.body()
    rows = rows_of(folder)
    sdf = ElementTree.parse(folder / "model.sdf").getroot().find(".//model[@name='top']")
    assert float(sdf.findtext("link/inertial/mass")) == pytest.approx(body.m, rel=1e-12)
    assert float(sdf.findtext("link/inertial/inertia/izz")) == pytest.approx(body.I3, rel=1e-11)
    pose = [float(word) for word in sdf.findtext("pose").split()]
    start = rows.loc[0, ["x [m]", "y [m]", "z [m]"]].astype(float)
    assert_near(pose[:3], start, 1e-12)
    there = Rotation.from_quat(rows.loc[0, ["q_x", "q_y", "q_z", "q_w"]].astype(float))
    assert (there.inv() * Rotation.from_euler("xyz", pose[3:])).magnitude() < 1e-11


def test_sdf_has_the_attitude_of_a_start_with_three_angles():
    angles = {"phi": -1.0, "theta": 2.0, "psi": 2.5}
    problem = tt.load("flying", [f"initial.{name}={value}" for name, value in angles.items()])
    root = ElementTree.fromstring(text_of(problem, "sdf"))
    pose = root.findtext(".//model[@name='top']/pose").split()
    turned = Rotation.from_euler("xyz", [float(angle) for angle in pose[3:]])
    expected = Rotation.from_euler("ZYZ", list(angles.values()))
    assert (turned.inv() * expected).magnitude() < 1e-11


def test_models_of_the_joint_have_no_contact(exported):
    texts = [(exported / "joint" / f"model.{to}").read_text() for to in ("urdf", "sdf", "mjcf.xml")]
    assert not any("bounce" in text or "<collision" in text for text in texts)
    assert "must hold the point 0 0 -1 of the" in texts[0]


def test_the_sign_of_the_quaternion_is_continuous(exported):
    q = rows_of(exported / "joint")[["q_w", "q_x", "q_y", "q_z"]].values
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.9).all()


def test_impacts_and_phases_are_exported(exported):
    impacts = pd.read_csv(exported / "stem-landing" / "impacts.csv")
    phases = pd.read_csv(exported / "stem-landing" / "phases.csv")
    assert impacts["ball"].tolist() == ["stem"]
    assert phases["phase"].tolist() == ["flight", "slip", "roll"]
    assert impacts["time [s]"][0] == phases["start [s]"][1]
    assert impacts["speed_after [m/s]"][0] == 0


@pytest.mark.parametrize("name", [name for name in ALL if name != "joint"])
def test_times_in_the_text_are_those_of_the_phases(exported, name):
    ends = pd.read_csv(exported / name / "phases.csv")["end [s]"]
    for time in re.findall(r"(0\.\d{4,}) s", benchmark.case(name).text):
        assert any(f"{end:.{len(time) - 2}f}" == time for end in ends), time


def test_command_line(tmp_path, capsys):
    assert typed("benchmark list") == 0
    assert "steady-precession" in capsys.readouterr().out
    assert typed(f"benchmark export {tmp_path} bounce bounce") == 0
    assert (tmp_path / "bounce" / "reference.csv").exists()
    assert typed(f"benchmark export {tmp_path} bounce") != 0
    assert typed(f"benchmark export {tmp_path} nothing") == 2
    assert typed("benchmark export /proc/cases bounce") == 5
    assert typed("benchmark list bounce") == 2
    assert typed("benchmark export") == 2
    assert typed("benchmark list --markdown") == 2
    assert typed("benchmark score . --scenario mine.toml") == 2
    assert typed(f"benchmark export {tmp_path} --fail-above 1") == 2
