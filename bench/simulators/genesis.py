"""Genesis on its CPU backend, in double precision: soft contact as in MuJoCo, other options.

`best` follows the API reference of `gs.options.RigidOptions`: the elliptic cone with its impratio
of 100, contact_resolution = signorini (sliding does not inflate the normal force), Euler's rule, a
short constraint_timeconst; and `morphs.MJCF(align=False)`, which leaves the body frame at the
centre of the ball (see mujoco.py) instead of moving it to the centre of mass.
"""

import os
import tempfile
from collections.abc import Iterator

import numpy as np

from .case import Case, rotation


SETTINGS = {
    "default": {},
    "best": {"timeconst": 0.004},
}
SCAN = ("timeconst", (0.02, 0.004, 0.002, 0.001, 0.0005))
LACKS = {
    "joint": "a floating base has no fixed point",
    "restitution": "no coefficient of restitution",
}


def _mjcf(case: Case) -> str:
    frame = case.balls[0].offset
    inertia = " ".join(f"{moment!r}" for moment in case.inertia.tolist())
    balls = "".join(
        f'<geom type="sphere" size="{ball.radius!r}" pos="0 0 {ball.offset - frame!r}"/>'
        for ball in case.balls
    )
    return f"""<mujoco><worldbody><body name="top"><freejoint/>
<inertial pos="0 0 {-frame!r}" mass="{case.mass!r}" diaginertia="{inertia}"/>{balls}
</body></worldbody></mujoco>"""


def _scene(engine, case: Case, setting: dict, step: float):
    if not 0.01 <= case.mu <= 5:
        raise ValueError("friction must be 0.01 to 5")
    options, patch = {}, {}
    if setting:
        options = {
            "enable_torsional_friction": bool(case.torsion),
            "enable_rolling_friction": bool(case.rolling),
            "friction_cone": engine.friction_cone.elliptic,
            "contact_resolution": engine.contact_resolution.signorini,
            "integrator": engine.integrator.Euler,
            "constraint_timeconst": max(setting["timeconst"], 2 * step),
            "iterations": 200,
            "tolerance": 1e-12,
        }
        patch = {"friction_torsional": case.torsion} if case.torsion else {}
        patch |= {"friction_rolling": case.rolling} if case.rolling else {}
    scene = engine.Scene(
        sim_options=engine.options.SimOptions(dt=step, gravity=(0, 0, -case.gravity)),
        rigid_options=engine.options.RigidOptions(**options),
        show_viewer=False,
    )
    material = engine.materials.Rigid(friction=case.mu, **patch)
    scene.add_entity(engine.morphs.Plane(), material=material)
    with tempfile.NamedTemporaryFile("w", suffix=".xml", delete=False) as file:
        file.write(_mjcf(case))
    top = scene.add_entity(engine.morphs.MJCF(file=file.name, align=not setting), material=material)
    scene.build()
    os.remove(file.name)
    return scene, top


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    import genesis as engine

    if not engine._initialized:
        engine.init(backend=engine.cpu, precision="64", logging_level="error")
    scene, top = _scene(engine, case, setting, step)
    shift = case.balls[0].offset if setting else 0.0
    axis = rotation(case.quaternion)[:, 2]
    top.set_qpos(np.r_[case.position + shift * axis, case.quaternion])
    turned = rotation(case.quaternion).T @ case.omega
    speed = case.velocity + shift * np.cross(case.omega, axis)
    top.set_dofs_velocity(np.r_[speed, turned])
    while True:
        q, v = top.get_qpos().numpy(), top.get_dofs_velocity().numpy()
        axes = rotation(q[3:])
        omega, arm = axes @ v[3:], -shift * axes[:, 2]
        yield np.concatenate([q[:3] + arm, q[3:], v[:3] + np.cross(omega, arm), omega])
        scene.step()
