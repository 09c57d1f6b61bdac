"""The adapters of contact engines, and the friction derived for MuJoCo's contact."""

import importlib
import math
from pathlib import Path

import pytest

from tippetop import benchmark

from .simulators import mujoco as adapter
from .simulators.__main__ import run
from .simulators.case import read
from .simulators.soft_contact import (
    SoftContact,
    effective,
    equator,
    passage,
    simulated,
)


mujoco = pytest.importorskip("mujoco")
# Newton and Genesis compile for minutes
MODULES = {"mujoco": "mujoco", "pybullet": "pybullet", "drake": "pydrake", "dart": "dartpy"}


@pytest.mark.parametrize("name", MODULES)
@pytest.mark.parametrize(
    ("case", "until", "attitude", "position"),
    [
        ("steady-precession", 0.05, 2e-3, 5e-5),
        ("rocking-cylinder", 0.1, 0.2, 2e-3),
        ("stem-landing", 0.06, 0.05, 1e-3),
    ],
)
def test_engines_have_the_body_and_the_start(
    tmp_path: Path, name: str, case: str, until: float, attitude: float, position: float
) -> None:
    """Until the next impact, rolling, lift-off and landing are those of the case."""
    pytest.importorskip(MODULES[name])
    engine = importlib.import_module(f"bench.simulators.{name}")
    benchmark.export(tmp_path, [case])
    path = tmp_path / f"{name}/best/{case}/dt=0.0005.csv"
    begun = read(tmp_path / case)._replace(until=until)
    run(engine, begun, engine.SETTINGS["best"], 5e-4, path, limit=600)
    [scored] = benchmark.score(path).to_dict()
    assert scored["largest"]["attitude"] < attitude
    assert scored["largest"]["position"] < position


def test_flight_in_mujoco_scores_well(tmp_path: Path) -> None:
    benchmark.export(tmp_path, ["torque-free"])
    path = tmp_path / "mujoco/best/torque-free/dt=0.0005.csv"
    run(adapter, read(tmp_path / "torque-free"), adapter.SETTINGS["best"], 5e-4, path, limit=60)
    [scored] = benchmark.score(path).to_dict()
    assert scored["outcome_is_right"]
    assert scored["largest"]["attitude"] < 1e-9
    assert scored["largest"]["position"] < 1e-9


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
@pytest.mark.parametrize(("timeconst", "impratio"), [(0.02, 1.0), (0.004, 10.0)])
def test_a_pushed_body_creeps_as_derived(cone: str, timeconst: float, impratio: float) -> None:
    """A ball with a large moment of inertia is pushed with a tenth of its weight."""
    mass, contact = 0.1, SoftContact(timeconst, impratio, cone)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option cone="{cone}" impratio="{impratio}" timestep="0.001"/>
        <default><geom solref="{timeconst} 1" friction="1 0 0"/></default><worldbody>
        <geom size="1 1 1" type="plane"/><body pos="0 0 0.02"><freejoint/>
        <inertial pos="0 0 0" mass="{mass}" diaginertia="1e4 1e4 1e4"/>
        <geom type="sphere" size="0.02"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 2000)
    assert -data.contact[0].dist == pytest.approx(contact.depth, rel=1e-4)
    data.qfrc_applied[0] = mass * 9.81 / 10
    mujoco.mj_step(model, data, 1000)
    assert 0.1 / data.qvel[0] == pytest.approx(contact.viscous(), rel=0.01)


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_the_derived_creep_turns_the_tutorial_s_top_over_when_mujoco_does(cone: str) -> None:
    derived = equator(effective(SoftContact(cone=cone)))
    assert derived == pytest.approx(passage(*simulated(cone)[:2]), rel=0.1)


def test_slip_that_turns_is_braked_by_the_inertance() -> None:
    """The work of F = -(B v + dv/dt)/R on v = exp(i Omega t) is that of mu N v for the same F."""
    contact, turning = SoftContact(), 150.0
    force = (contact.damping + 1j * turning) * contact.inertance
    viscous = abs(force) ** 2 / (force.real * 9.81)
    assert contact.viscous(turning) == pytest.approx(viscous, rel=1e-12)
    assert math.isclose(contact.viscous(), force.real / 9.81)
