"""Other motions beside the exact one: differences, drifts, when they leave, orders of
convergence.
"""

from pathlib import Path

import numpy as np
import pytest
from examples import CANONICAL, turned
from measured import written
from refusals import refusal
from typed import reported

import tippetop as tt
from tippetop.exchange.comparison import differences
from tippetop.exchange.simulators import start_of, text_of


SCENARIO = {
    "system": "tippe-top",
    "parameters": {**CANONICAL, "I1": 2.994e-6},
    "friction": {"law": "viscous", "mu": 0.3},
    "initial": {
        "theta": 0.1,
        "omega3": 155.0,
        "theta_dot": 0.5,
        "phi_dot": 1.0,
        "nu_x": 0.02,
        "psi": 0.4,
    },
    "run": {"until": 0.5},
}


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run(SCENARIO, output_step=0.005)


def columns(run: tt.Run, turn: float = 0.0) -> dict[str, np.ndarray]:
    """The run's own columns as another program's, turned about the vertical by `turn` rad per
    second.
    """
    rows = run.trajectory
    q = turned(rows.orientation.values, turn * rows.time.values)
    return {
        "t [s]": rows.time.values,
        **dict(zip(("q_w", "q_x", "q_y", "q_z"), q.T, strict=True)),
        "x [mm]": 1e3 * rows.x.values,
        "y [mm]": 1e3 * rows.y.values,
    }


@pytest.mark.parametrize("to", ["csv", "parquet"])
def test_an_exported_run_is_its_own_scenario(run: tt.Run, tmp_path: Path, to: str) -> None:
    pytest.importorskip("pyarrow")
    scenario = {**SCENARIO, "run": {"until": 0.5, "columns": ["theta"]}}
    found = tt.compare(run.export(tmp_path / f"run.{to}"), scenario).to_dict()
    assert found["rows"] == len(run.trajectory.time)
    assert all(found[name]["max"] < 2e-15 for name in ("theta", "axis", "attitude", "place"))
    assert found["omega3"]["max"] < 1e-11


def exact(run: tt.Run) -> dict[str, np.ndarray]:
    """The run as a perfect simulator writes it: with the velocity of the centre of mass."""
    rows, body = run.trajectory, run.problem.body()
    u, L, phi = rows.axis.values, rows.L.values, rows.phi.values
    w = L / body.I1 + ((1 / body.I3 - 1 / body.I1) * (L * u).sum(axis=1))[:, None] * u
    e, t = (np.stack([np.cos(a), np.sin(a), 0 * a], axis=1) for a in (phi, phi + np.pi / 2))
    slip = rows.nu_x.values[:, None] * e + rows.nu_y.values[:, None] * t
    velocity = slip - np.cross(w, body.c * u - [0, 0, body.R])
    values = columns(run) | {"z [m]": body.R - body.c * u[:, 2]}
    values |= {f"v{c} [m/s]": velocity[:, i] for i, c in enumerate("xyz")}
    return values | {f"omega_{c} [rad/s]": w[:, i] for i, c in enumerate("xyz")}


def test_energy_is_compared_with_the_exact_loss(run: tt.Run, tmp_path: Path) -> None:
    """Friction takes energy from a perfect simulator too."""
    found = tt.compare(written(tmp_path / "exact.csv", exact(run)), SCENARIO)
    numbers = found.to_dict()
    assert numbers["energy_drift"] > 1e-4
    assert numbers["energy_error"] < 1e-13
    assert numbers["jellett_error"] < 1e-13
    assert "error of energy" in str(found)


def test_differences_are_in_the_order_of_the_file() -> None:
    """So reports of two processes are equal, whatever their order of sets."""
    names = [f"camera_{k}" for k in range(20)]
    rows = {name: np.zeros(3) for name in ("time", *reversed(names))}
    assert list(differences({name: np.ones(3) for name in names}, rows)) == names


def test_several_files_are_a_table_with_the_best_first(run: tt.Run, tmp_path: Path) -> None:
    files = [written(tmp_path / f"{h:g}.csv", columns(run, h)) for h in (0.3, 0.1, 0.19)]
    head, *rows = str(tt.compare(files, SCENARIO)).splitlines()
    assert head.split()[:3] == ["file", "largest", "error"]
    assert [Path(row.split()[0]).stem for row in rows] == ["0.1", "0.19", "0.3"]
    assert ["never" in row for row in rows] == [True, True, False]


def test_a_known_error_is_measured_and_its_order_found(run: tt.Run, tmp_path: Path) -> None:
    files = [written(tmp_path / f"dt={h:g}.csv", columns(run, 4.1e3 * h**2)) for h in (1e-2, 5e-3)]
    result = tt.compare(files, SCENARIO)
    found = result.to_dict()
    first, second = found["files"]
    assert first["attitude"]["max"] == pytest.approx(4.1e3 * 1e-4 * 0.5)
    assert first["attitude"]["leaves"] == {
        "0.001": 0.005,
        "0.01": 0.025,
        "0.1": pytest.approx(0.245),
    }
    assert first["theta"]["max"] < 1e-14  # a turn about the vertical
    assert (first["step"], second["step"]) == (1e-2, 5e-3)
    assert found["orders"][0]["attitude"] == pytest.approx(2.0, abs=0.01)
    assert "order of convergence from step 0.01 to 0.005 s: attitude 2.00" in str(result)
    assert result.plot(tmp_path / "figure.png") is not None


def test_energy_and_jellett_of_the_others_own_motion(tmp_path: Path) -> None:
    """Of a flawed motion: an angular velocity that grows.

    The start of the export is that of the run.
    """
    problem = tt.load("inverting")
    start = start_of(problem)
    t = np.linspace(0, 0.1, 11)
    grown = start.omega * (1 + t[:, None])
    values = {"t [s]": t} | {
        f"q_{c}": np.full(11, v) for c, v in zip("wxyz", start.quaternion, strict=True)
    }
    values |= {
        f"{c} [m]": np.full(11, v) for c, v in zip("xyz", start.place - [0, 0, 1e-5], strict=True)
    }
    values |= {f"v{c} [m/s]": np.full(11, v) for c, v in zip("xyz", start.velocity, strict=True)}
    values |= {f"omega_body_{c} [rad/s]": grown[:, i] for i, c in enumerate("xyz")}
    found = tt.compare(written(tmp_path / "grown.csv", values), problem).to_dict()
    assert found["jellett_drift"] == pytest.approx(0.1, rel=1e-12)
    energy = float(tt.run(problem).trajectory.energy[0]) - 0.02 * 9.82 * 1e-5
    spin = 3.2e-6 * 155.0**2 / 2
    assert found["energy_drift"] == pytest.approx(spin * 0.21 / energy, rel=1e-9)
    assert found["contact"]["penetration"] == pytest.approx(1e-5)


def test_the_exported_start_is_that_of_the_run(run: tt.Run) -> None:
    """Velocities are the derivatives of the places and the orientation that the run has."""
    start, rows = (
        start_of(run.problem),
        tt.run(SCENARIO, output_times=[1e-7, 2e-7], until=0.01).trajectory,
    )
    place = np.stack([rows.x, rows.y], axis=1)
    np.testing.assert_allclose((4 * place[0] - place[1]) / 2e-7, start.velocity[:2], rtol=1e-6)
    q = np.stack([start.quaternion, *rows.orientation.values])
    rate = (4 * q[1] - q[2] - 3 * q[0]) / 2e-7
    w, v = q[0][0], q[0][1:]
    body = 2 * (w * rate[1:] - rate[0] * v - np.cross(v, rate[1:]))
    np.testing.assert_allclose(body, start.omega, rtol=1e-5, atol=1e-5 * 155)


@pytest.mark.parametrize(
    ("slip", "velocity"),
    [("nu_x = -0.02", -0.2715794 * 0.02), ("centre_at_rest = true", 0.0)],
)
def test_an_upright_top_that_slips_is_exported_with_its_velocity(
    slip: str, velocity: float, tmp_path: Path
) -> None:
    """The centre of the ball is at rest: the centre of mass moves by alpha R theta_dot."""
    text = tt.presets()["mujoco-tutorial"].replace("nu_x = -0.02\nnu_y = 0.0", slip)
    (tmp_path / "upright.toml").write_text(text)
    start = start_of(tt.load(tmp_path / "upright.toml"))
    np.testing.assert_allclose(start.velocity, [velocity, 0, 0], atol=1e-15)


@pytest.mark.parametrize("to", ["mjcf", "urdf", "sdf"])
@pytest.mark.parametrize(
    "preset", ["inverting", "gliding-heavy-top", "heavy-top", "rolling", "leine-glocker-stem"]
)
def test_exports_are_xml_and_say_what_they_cannot(preset: str, to: str) -> None:
    from xml.etree import ElementTree

    problem = tt.load(preset)
    text = text_of(problem, to)
    root = ElementTree.fromstring(text)
    heavy = root.find(".//mass")
    mass = root.find(".//inertial").get("mass") or heavy.get("value") or heavy.text
    assert float(mass) == problem.parameters["m"]
    assert "Differences from tippetop" in text
    balls = root.findall(".//body/geom") or root.findall(".//collision")
    balls = [ball for ball in balls if ball.get("name") != "floor"]
    assert len(balls) == (0 if preset == "heavy-top" else 1 + ("stem" in preset))


def test_the_command_prints_json_and_draws(run: tt.Run, tmp_path: Path) -> None:
    store, figure = run.save(tmp_path / "run.zarr"), tmp_path / "figure.svg"
    other = written(tmp_path / "own.csv", columns(run))
    found = reported(f"compare {other} {store} --figure {figure}")
    assert found["attitude"]["rms"] < 1e-15
    assert figure.read_text(encoding="utf-8").count("<path") > 10


def test_a_cylinder_whose_contact_never_opens_is_no_body_for_a_simulator() -> None:
    with refusal("must be a top, or a cylinder whose contact may open"):
        text_of(tt.load("gliding-cylinder"), "mjcf")


HEADS = {
    "theta [rad]": ("theta",),
    "phi [rad]": ("phi",),
    "psi [rad]": ("psi",),
    "theta_dot [rad/s]": ("theta_dot",),
    "phi_dot [rad/s]": ("phi_dot",),
    "omega3 [rad/s]": ("omega3", "omega"),
    **{f"axis_{c}": ("axis",) for c in "xyz"},
    **{f"{c} [m]": ("place",) for c in "xyz"},
    **{f"v{c} [m/s]": ("velocity",) for c in "xyz"},
    **{f"omega_{c} [rad/s]": ("omega",) for c in "xyz"},
}
REFERENCES = [
    "inverting",
    "heavy-top",
    "rolling",
    "gliding-heavy-top",
    "gliding-cylinder",
    "flying",
    "spinning-egg",
    "rolling-coin",
]
HEIGHTS = {
    "spinning-egg": lambda theta: np.hypot(0.03 * np.cos(theta), 0.02 * np.sin(theta)),
    "rolling-coin": lambda theta: 0.011 * np.sin(theta) + 0.001,
}


@pytest.mark.parametrize("preset", REFERENCES)
def test_every_column_that_is_read_is_compared(preset: str, tmp_path: Path) -> None:
    """Rates by differences of the places and attitudes of a run agree with the reference to their
    error; a column that is shifted changes the error of its own quantity, by the shift.
    """
    h, t = 1e-5, np.linspace(0.05, 0.09, 5)
    times = np.ravel(t[:, None] + [-h, 0, h])
    run = tt.run(preset, until=0.1, output_times=times)
    rows, body, n = run.trajectory, run.problem.body(), len(t)
    height = HEIGHTS.get(preset, lambda theta: body.R - body.c * np.cos(theta))
    z = (rows["z"] if "z" in rows else height(rows.theta)).values
    flat = [rows[c].values if c in rows else 0 * z for c in "xy"]
    axis = rows.axis.values if "axis" in rows else None
    if preset == "heavy-top":
        flat = [-body.c * axis[:, 0], -body.c * axis[:, 1]]
    place = np.stack([*flat, z], axis=1).reshape(n, 3, 3)
    middle = {name: rows[name].values.reshape(n, 3, -1)[:, 1] for name in rows if len(rows[name])}
    columns = {"t [s]": t}
    for head, (name, *_) in HEADS.items():
        if name in middle and head.partition(" ")[0] in (name, *(f"axis_{c}" for c in "xyz")):
            columns[head] = middle[name][:, "xyz".find(head[-1]) if name == "axis" else 0]
    velocity = (place[:, 2] - place[:, 0]) / (2 * h)
    for i, c in enumerate("xyz"):
        columns[f"{c} [m]"], columns[f"v{c} [m/s]"] = place[:, 1, i], velocity[:, i]
    if axis is not None:  # omega = u x u' + omega3 u
        u = axis.reshape(n, 3, 3)
        omega = np.cross(u[:, 1], (u[:, 2] - u[:, 0]) / (2 * h)) + middle["omega3"] * u[:, 1]
        columns |= {f"omega_{c} [rad/s]": omega[:, i] for i, c in enumerate("xyz")}
    right = tt.compare(written(tmp_path / "a.csv", columns), preset).to_dict()
    kinds = {kind for head in columns if head != "t [s]" for kind in HEADS[head]}
    for kind in kinds & right.keys():
        assert right[kind]["max"] < (1e-4 if kind in ("velocity", "omega") else 1e-10), kind
    for head in list(columns)[1:]:
        if head.startswith("axis"):
            continue  # a shifted axis has another length
        shifted = columns | {head: columns[head] + 0.25}
        found = tt.compare(written(tmp_path / "b.csv", shifted), preset)
        kind = HEADS[head][0]
        assert found.to_dict()[kind]["max"] == pytest.approx(0.25, abs=1e-3), head
        assert f"error of {kind}" in str(found) or found.motions[0].main == kind


def test_a_column_without_a_reference_is_refused_by_its_name(tmp_path: Path) -> None:
    t = np.array([0.0, 0.1])
    for preset, head in (("inverting", "marker_x [m]"), ("gliding-cylinder", "phi [rad]")):
        path = written(tmp_path / "a.csv", {"t [s]": t, "theta [rad]": t + 0.1, head: t})
        name = head.partition(" ")[0]
        with refusal(f"comparable with the reference, but `{name}`"):
            tt.compare(path, preset)
