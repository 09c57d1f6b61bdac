"""PyBullet: sequential impulses with velocity steps, maximal coordinates.

`best` follows the PyBullet quickstart guide, changeDynamics and setPhysicsEngineParameter: no
damping, no limit of speed, cone friction, a residual threshold of 0, many solver iterations.
"""

import os
import tempfile
from collections.abc import Iterator

import numpy as np

from .case import Case


SETTINGS = {"default": {}, "best": {"iterations": 1000, "contactERP": 0.2}}
SCAN = ("contactERP", (0.8, 0.4, 0.2, 0.1, 0.05))
LACKS = {"joint": "a fixed point needs a chain of joints"}


def _urdf(case: Case) -> str:
    ixx, iyy, izz = case.inertia
    balls = "".join(
        f'<collision><origin xyz="0 0 {ball.offset!r}"/>'
        f'<geometry><sphere radius="{ball.radius!r}"/></geometry></collision>'
        for ball in case.balls
    )
    return (
        f'<robot name="top"><link name="top"><inertial><mass value="{case.mass!r}"/><inertia '
        f'ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>{balls}'
        "</link></robot>"
    )


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    import pybullet as engine

    client = engine.connect(engine.DIRECT)
    try:
        with tempfile.NamedTemporaryFile("w", suffix=".urdf", delete=False) as file:
            file.write(_urdf(case))
        top = engine.loadURDF(file.name, flags=engine.URDF_USE_INERTIA_FROM_FILE)
        os.remove(file.name)
        floor = engine.createMultiBody(0, engine.createCollisionShape(engine.GEOM_PLANE))
        for body, mu, restitution in ((top, case.mu, case.restitution), (floor, 1.0, 1.0)):
            engine.changeDynamics(body, -1, lateralFriction=mu, restitution=restitution)
        engine.setGravity(0, 0, -case.gravity)
        engine.setPhysicsEngineParameter(fixedTimeStep=step, numSubSteps=0)
        if setting:
            engine.changeDynamics(
                top,
                -1,
                linearDamping=0,
                angularDamping=0,
                maxJointVelocity=1e9,
                spinningFriction=case.torsion,
                rollingFriction=case.rolling,
                activationState=engine.ACTIVATION_STATE_DISABLE_SLEEPING,
            )
            engine.setPhysicsEngineParameter(
                numSolverIterations=setting["iterations"],
                solverResidualThreshold=0,
                enableConeFriction=1,
                contactBreakingThreshold=1e-3,
                contactERP=setting["contactERP"],
                restitutionVelocityThreshold=0.0,
            )
        engine.resetBasePositionAndOrientation(
            top, case.position.tolist(), np.roll(case.quaternion, -1).tolist()
        )
        engine.resetBaseVelocity(top, case.velocity.tolist(), case.omega.tolist())
        while True:
            place, turned = engine.getBasePositionAndOrientation(top)
            velocity, omega = engine.getBaseVelocity(top)
            yield np.concatenate([place, np.roll(turned, 1), velocity, omega])
            engine.stepSimulation()
    finally:
        engine.disconnect(client)
