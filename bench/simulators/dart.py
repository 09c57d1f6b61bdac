"""DART: rigid contact as a complementarity problem in each step.

`best` follows the DART documentation of `NsgsFrictionSolver` (exact Coulomb cone by nonsmooth
Gauss-Seidel, maxSweeps and tolerance) in place of the boxed problem that is the default.
"""

from collections.abc import Iterator

import numpy as np

from .case import Case, rotation


SETTINGS = {"default": {}, "best": {"tolerance": 1e-12}}
SCAN = ("tolerance", (1e-2, 1e-4, 1e-6, 1e-9, 1e-12))
LACKS = {"torsion": "no torsional friction", "rolling": "no rolling friction"}


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    import dartpy as engine

    dynamics = engine.dynamics
    world = engine.simulation.World()
    world.setTimeStep(step)
    world.setGravity([0, 0, -case.gravity])
    solver = world.getConstraintSolver()
    solver.setCollisionDetector(engine.collision.DARTCollisionDetector())
    if setting:
        options = engine.constraint.NsgsFrictionSolver.Options()
        options.maxSweeps, options.tolerance = 10000, setting["tolerance"]
        solver.setBoxedLcpSolver(engine.constraint.NsgsFrictionSolver(options))
    top = dynamics.Skeleton("top")
    if case.joint is None:
        joint, body = top.createFreeJointAndBodyNodePair()
        for ball in case.balls:
            shape = dynamics.SphereShape(ball.radius)
            node = body.createShapeNode(shape)
            node.setRelativeTranslation([0, 0, ball.offset])
            node.createCollisionAspect()
            aspect = node.createDynamicsAspect()
            aspect.setFrictionCoeff(case.mu)
            aspect.setRestitutionCoeff(case.restitution)
    else:
        joint, body = top.createBallJointAndBodyNodePair()
        pivot = engine.math.Isometry3()
        pivot.set_translation([0, 0, case.joint])
        joint.setTransformFromChildBodyNode(pivot)
    inertia = dynamics.Inertia()
    inertia.setMass(case.mass)
    inertia.setMoment(np.diag(case.inertia))
    body.setInertia(inertia)
    world.addSkeleton(top)
    floor = dynamics.Skeleton("floor")
    _, ground = floor.createWeldJointAndBodyNodePair()
    node = ground.createShapeNode(dynamics.BoxShape([10, 10, 1]))
    node.setRelativeTranslation([0, 0, -0.5])
    node.createCollisionAspect()
    aspect = node.createDynamicsAspect()
    aspect.setFrictionCoeff(max(case.mu, 1.0))
    aspect.setRestitutionCoeff(1.0)
    if case.joint is None:
        world.addSkeleton(floor)
    axes = rotation(case.quaternion)
    # generalised velocities: of a free joint in the space frame, of a ball joint in the body's
    if case.joint is None:
        pose = engine.math.Isometry3()
        pose.set_rotation(axes)
        pose.set_translation(case.position)
        joint.setPositions(dynamics.FreeJoint.convertToPositions(pose))
        top.setVelocities(np.r_[case.omega, case.velocity])
    else:
        joint.setPositions(dynamics.BallJoint.convertToPositions(axes))
        top.setVelocities(axes.T @ case.omega)
    while True:
        transform = body.getWorldTransform()
        place, turned = transform.translation(), transform.quaternion().wxyz()
        yield np.concatenate([place, turned, body.getLinearVelocity(), body.getAngularVelocity()])
        world.step()
