"""How far other engines' tippe tops are from the exact one: `python -m bench.contact_simulators`.

Each scenario is exported, stepped by the engine with several steps, written as a table, and
compared. MuJoCo (tippetop[peers]) takes the MJCF and is asked what its own manual advises: elliptic
cones, a contact as stiff as the step allows (solref = 2 steps), impratio 10; by two integrators.
`--engine pybullet` (`pip install pybullet` beside) takes the URDF: cone friction, no damping, no
limit of speed, as many iterations as it needs. Both are fair questions for a contact engine, and
ones that it was not made for.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import tippetop as tt
from tippetop.exchange.simulators import start_of, text_of
from tippetop.library.exchanging import Comparison


STEPS = (1e-3, 5e-4, 2.5e-4)
ENGINES = {"mujoco": ("mjcf", ("implicit", "RK4")), "pybullet": ("urdf", ("semi-implicit",))}
"""Of each engine the format that it reads, and its integrators."""
BODY = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 131 / 350 * 8e-6, "I3": 3.2e-6, "g": 9.82}
START = {"theta": 0.1, "omega3": 155.0, "centre_at_rest": True}
HEADER = "t [s]," + ",".join(
    ["q_w", "q_x", "q_y", "q_z", *(f"{c} [m]" for c in "xyz"), *(f"v{c} [m/s]" for c in "xyz")]
    + [f"omega_body_{c} [rad/s]" for c in "xyz"]
)


class Case(NamedTuple):
    """A question: a name, why it is asked, and the scenario's tables."""

    name: str
    why: str
    tables: dict[str, Any]


def _tables(friction: dict[str, Any], until: float, **more: Any) -> dict[str, Any]:
    initial = {**START, **more.pop("initial", {})}
    return {
        "system": "tippe-top",
        "parameters": BODY,
        "friction": friction,
        "initial": initial,
        "run": {"until": until},
        **more,
    }


CASES = (
    Case(
        "flight",
        "no contact: the integrator alone",
        _tables({"law": "coulomb", "mu": 0.3}, 0.1, initial={"gap": 0.08}, contact={}),
    ),
    Case("gliding", "contact without friction: nothing is lost", _tables({"law": "none"}, 1.0)),
    Case(
        "coulomb",
        "contact with friction, exact Coulomb law",
        _tables({"law": "coulomb", "mu": 0.3}, 2.0),
    ),
)


def _bullet(problem: Any, text: str, step: float, integrator: str, until: float) -> np.ndarray:
    """As `_mujoco`; Bullet has one integrator."""
    import pybullet

    start = start_of(problem)
    mu = float(getattr(problem.friction, "mu", 0.0))
    client = pybullet.connect(pybullet.DIRECT)
    try:
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(text)
            file.flush()
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            top = pybullet.loadURDF(
                file.name, start.place.tolist(), np.roll(start.quaternion, -1).tolist(), flags=flags
            )
        floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
        for body, friction in ((top, mu), (floor, 1.0)):  # the friction of a contact is the product
            pybullet.changeDynamics(
                body,
                -1,
                lateralFriction=friction,
                spinningFriction=0,
                rollingFriction=0,
                restitution=0,
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                maxJointVelocity=1e9,
            )
        pybullet.changeDynamics(top, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        pybullet.setGravity(0, 0, -problem.body().g)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step,
            numSubSteps=0,
            numSolverIterations=1000,
            solverResidualThreshold=0,
            enableConeFriction=1,
            contactBreakingThreshold=1e-3,
        )
        turn = np.array(
            pybullet.getMatrixFromQuaternion(np.roll(start.quaternion, -1).tolist())
        ).reshape(3, 3)
        pybullet.resetBaseVelocity(top, start.velocity.tolist(), (turn @ start.omega).tolist())
        rows = []
        count = round(until / step)
        for k in range(count + 1):
            if k % max(1, count // 1000) == 0:
                place, turned = pybullet.getBasePositionAndOrientation(top)
                velocity, omega = pybullet.getBaseVelocity(top)
                axes = np.array(pybullet.getMatrixFromQuaternion(turned)).reshape(3, 3)
                rows.append(
                    [k * step, *np.roll(turned, 1), *place, *velocity, *(axes.T @ np.array(omega))]
                )
            pybullet.stepSimulation()
    finally:
        pybullet.disconnect(client)
    return np.array(rows)


def _mujoco(problem: Any, text: str, step: float, integrator: str, until: float) -> np.ndarray:
    """Rows of a motion, (rows, 14): time, quaternion, place, velocity, angular velocity in body
    axes.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.geom_solref[:, 0], model.geom_solref[:, 1] = 2 * step, 1.0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rows = []
    count = round(until / step)
    for k in range(count + 1):
        if k % max(1, count // 1000) == 0:
            rows.append([k * step, *data.qpos[3:], *data.qpos[:3], *data.qvel])
        mujoco.mj_step(model, data)
    return np.array(rows)


def answers(case: Case, folder: Path, engine: str) -> dict[str, Comparison]:
    """What an engine makes of a case, by integrator."""
    problem = tt.load(_file(case, folder))
    to, integrators = ENGINES[engine]
    text, stepped = text_of(problem, to), _mujoco if engine == "mujoco" else _bullet
    made = {}
    for integrator in integrators:
        files = []
        for step in STEPS:
            path = folder / f"{case.name} {integrator} dt={step:g}.csv"
            rows = stepped(problem, text, step, integrator, problem.until)
            np.savetxt(path, rows, delimiter=",", header=HEADER, comments="", fmt="%.17g")
            files.append(path)
        made[integrator] = tt.compare(files, problem)
    return made


def _file(case: Case, folder: Path) -> Path:
    lines = [f'system = "{case.tables["system"]}"']
    for name, table in case.tables.items():
        if isinstance(table, dict):
            lines += [f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    path = folder / f"{case.name}.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(float(value))


def table(made: dict[str, dict[str, Comparison]]) -> str:
    """A Markdown table of all answers."""
    lines = [
        "| case | integrator | step [s] | attitude, largest error [rad] | leaves 1e-3, 1e-2, "
        "1e-1 rad at [s] | "
        "theta, largest error [rad] | order | Jellett drift | energy drift | in the floor [m] |",
        "|" + " --- |" * 10,
    ]
    for name, by in made.items():
        for integrator, comparison in by.items():
            for i, motion in enumerate(comparison.motions):
                n = motion.numbers
                leaves = ", ".join(
                    "never" if t is None else f"{t:.3g}" for t in n["attitude"]["leaves"].values()
                )
                order = f"{comparison.orders[i - 1].get('attitude', float('nan')):.2f}" if i else ""
                lines.append(
                    f"| {name} | {integrator} | {motion.step:g} | {n['attitude']['max']:.2g} | "
                    f"{leaves} | "
                    f"{n['theta']['max']:.2g} | {order} | {n['jellett_drift']:.1e} | "
                    f"{n['energy_drift']:.1e} | "
                    f"{n['contact']['penetration']:.1e} |"
                )
    return "\n".join(lines)


def main() -> None:
    """Prints the table; writes the figure of the case with friction."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--engine", choices=ENGINES, default="mujoco")
    given = parser.parse_args()
    figure = given.figure
    with tempfile.TemporaryDirectory() as name:
        made = {case.name: answers(case, Path(name), given.engine) for case in CASES}
        print(table(made))
        if figure is not None:
            next(iter(made["coulomb"].values())).plot(figure, overwrite=True)


if __name__ == "__main__":
    main()
