"""Drake: compliant point contact, discrete steps with the SAP convex solver.

`best` follows the API reference, MultibodyPlantConfig and "Contact Modeling in Drake": the
approximation "lagged" (convergent in the step, and Coulomb's cone without the gap of "sap"), a
small penetration allowance, a small stiction tolerance, and a dissipation without rebound.
"""

from collections.abc import Iterator

import numpy as np

from .case import Case, rotation


LAW = "compliant normal force, Coulomb friction regularised below the stiction tolerance"
SETTINGS = {
    "default": {"allowance": 1e-3, "stiction": 1e-4, "dissipation": None},
    "best": {"allowance": 1e-5, "stiction": 1e-6, "dissipation": 500.0},
}
SCAN = ("stiction", (1e-3, 1e-4, 1e-5, 1e-6, 1e-7))


def cannot(case: Case, setting: dict) -> str | None:
    """Return the reason why the engine does not express a case."""
    if case.joint is not None:
        return "its ball constraint ends Drake 1.51 with a segmentation fault"
    if case.torsion or case.rolling:
        return "a point contact has no torsional or rolling friction"
    if case.restitution:
        return "discrete contact has no coefficient of restitution"
    return f"no friction law {case.law}" if case.law in ("viscous", "stribeck") else None


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    from pydrake import all as engine

    builder = engine.DiagramBuilder()
    config = engine.MultibodyPlantConfig(
        time_step=step,
        penetration_allowance=setting["allowance"],
        stiction_tolerance=setting["stiction"],
        contact_model="point",
    )
    plant, _ = engine.AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -case.gravity])
    inertia = engine.SpatialInertia(
        case.mass, np.zeros(3), engine.UnitInertia(*(case.inertia / case.mass))
    )
    body = plant.AddRigidBody("top", inertia)
    material = engine.ProximityProperties()
    friction = engine.CoulombFriction(case.mu, case.mu)
    engine.AddContactMaterial(
        properties=material, dissipation=setting["dissipation"], friction=friction
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
