"""MuJoCo: soft contact as a convex optimisation, in the coordinates of the joints.

`best` follows the manual: XML reference, option: impratio and cone (against slip), and Modeling,
"Solver parameters" (solref; a dampratio below 1 for a rebound). `exported` is the rule of the
exported MJCF, solref = 2 timestep: its contact becomes stiffer as the step shrinks.
"""

import math
from collections.abc import Iterator

import numpy as np

from .case import Case, rotation


SETTINGS = {
    "default": {"cone": "pyramidal", "integrator": "Euler", "impratio": 1.0, "timeconst": 0.02},
    "best": {"cone": "elliptic", "integrator": "RK4", "impratio": 10.0, "timeconst": 0.004},
}
SETTINGS["exported"] = {**SETTINGS["best"], "timeconst": None}
SCAN = ("timeconst", (0.02, 0.004, 0.002, 0.001, 0.0005))
LACKS: dict[str, str] = {}


def origin(case: Case, setting: dict) -> float:
    """Return the offset of the body frame from the centre of mass.

    MuJoCo leaves the change of the contact Jacobian out of the acceleration of a contact. It is
    zero where the frame lies at the centre of the ball that touches.
    """
    if case.joint is not None:
        return case.joint
    return 0.0 if setting.get("frame") == "centre of mass" else case.balls[0].offset


def _model(case: Case, setting: dict, step: float):
    import mujoco

    frame = origin(case, setting)
    timeconst = setting["timeconst"] or 2 * step
    friction = f"{case.mu} {case.torsion} {case.rolling}"
    condim = 6 if case.rolling else 4 if case.torsion else 3 if case.mu else 1
    bounce = math.log(max(case.restitution, 1e-9))
    damping = -bounce / math.hypot(math.pi, bounce) if case.restitution else 1.0
    balls = "".join(
        f'<geom type="sphere" size="{ball.radius!r}" pos="0 0 {ball.offset - frame!r}"/>'
        for ball in case.balls
    )
    joint = "<freejoint/>"
    if case.joint is not None:
        joint, balls = '<joint type="ball"/>', ""
    inertia = " ".join(map(repr, map(float, case.inertia)))
    return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{step!r}" gravity="0 0 {-case.gravity!r}" cone="{setting["cone"]}"
    integrator="{setting["integrator"]}" impratio="{setting["impratio"]}"/>
  <default>
    <geom condim="{condim}" friction="{friction}" solref="{timeconst} {damping}"/>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="top">{joint}
      <inertial pos="0 0 {-frame!r}" mass="{case.mass!r}" diaginertia="{inertia}"/>{balls}
    </body>
  </worldbody>
</mujoco>""")


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    import mujoco

    model = _model(case, setting, step)
    data = mujoco.MjData(model)
    shift = origin(case, setting)
    axes = rotation(case.quaternion)
    data.qvel[-3:], data.qpos[-4:] = axes.T @ case.omega, case.quaternion
    if case.joint is None:
        data.qpos[:3] = case.position + shift * axes[:, 2]
        data.qvel[:3] = case.velocity + shift * np.cross(case.omega, axes[:, 2])
    while True:
        axes = rotation(data.qpos[-4:])
        omega, arm = axes @ data.qvel[-3:], -shift * axes[:, 2]
        place, velocity = arm, np.cross(omega, arm)
        if case.joint is None:
            place, velocity = data.qpos[:3] + arm, data.qvel[:3] + velocity
        yield np.concatenate([place, data.qpos[-4:], velocity, omega])
        mujoco.mj_step(model, data)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            return  # MuJoCo has put the body back to its start
