"""Drake: compliant point contact, discrete steps solved as a convex problem.

`best` follows the API reference: the approximation "similar" (DiscreteContactApproximation: where
strong transients must be resolved), a small stiction tolerance (MultibodyPlantConfig), and a tenth
of the default stiffness. 20 g then sink in by 2 um; landings on a stiffer plane are less accurate.
"""

from collections.abc import Iterator

import numpy as np

from .case import Case, rotation


SETTINGS = {
    "default": {},
    "best": {"stiction": 1e-6, "stiffness": 1e5},
}
SCAN = ("stiffness", (1e3, 1e4, 1e5, 1e6, 1e7))
LACKS = {
    "joint": "its ball constraint ends Drake 1.51 with a segmentation fault",
    "torsion": "a point contact has no torsional friction",
    "rolling": "a point contact has no rolling friction",
    "restitution": "discrete contact has no coefficient of restitution",
}


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    from pydrake import all as engine

    builder = engine.DiagramBuilder()
    config = engine.MultibodyPlantConfig(time_step=step, contact_model="point")
    if setting:
        config.discrete_contact_approximation = "similar"
        config.stiction_tolerance = setting["stiction"]
    plant, _ = engine.AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -case.gravity])
    inertia = engine.SpatialInertia(
        case.mass, np.zeros(3), engine.UnitInertia(*(case.inertia / case.mass))
    )
    body = plant.AddRigidBody("top", inertia)
    material = engine.ProximityProperties()
    friction = engine.CoulombFriction(case.mu, case.mu)
    engine.AddContactMaterial(
        properties=material,
        point_stiffness=setting.get("stiffness"),
        friction=friction,
    )
    for i, ball in enumerate(case.balls):
        pose = engine.RigidTransform([0, 0, ball.offset])
        shape = engine.Sphere(ball.radius)
        plant.RegisterCollisionGeometry(body, pose, shape, f"ball {i}", material)
    floor = engine.RigidTransform()
    world = plant.world_body()
    plant.RegisterCollisionGeometry(world, floor, engine.HalfSpace(), "floor", material)
    plant.Finalize()
    diagram = builder.Build()
    simulator = engine.Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    pose = engine.RigidTransform(engine.RotationMatrix(rotation(case.quaternion)), case.position)
    plant.SetFreeBodyPose(context, body, pose)
    velocity = engine.SpatialVelocity(case.omega, case.velocity)
    plant.SetFreeBodySpatialVelocity(context, body, velocity)
    simulator.Initialize()
    k = 0
    while True:
        pose = plant.EvalBodyPoseInWorld(context, body)
        moving = plant.EvalBodySpatialVelocityInWorld(context, body)
        turned = pose.rotation().ToQuaternion().wxyz()
        yield np.concatenate(
            [pose.translation(), turned, moving.translational(), moving.rotational()]
        )
        k += 1
        simulator.AdvanceTo(k * step)
