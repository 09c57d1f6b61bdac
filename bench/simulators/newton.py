"""Newton on its CPU backend, in single precision: position-based dynamics or Kamino.

`default` is SolverXPBD as its class is constructed. `best` is SolverKamino, which solves the
complementarity problem of rigid contact with Coulomb's cone (API reference, SolverKamino.Config and
PADMMSolverConfig: tolerances, Moreau's midpoint integrator).
"""

from collections.abc import Iterator

import numpy as np

from .case import Case


SETTINGS = {"default": {}, "best": {"tolerance": 1e-6}}
SCAN = ("tolerance", (1e-2, 1e-3, 1e-4, 1e-5, 1e-6))
LACKS = {
    "joint": "a fixed point needs the coordinates of a joint, which differ between its solvers",
    "torsion": "XPBD and Kamino have no torsional friction in metres",
    "rolling": "XPBD and Kamino have no rolling friction in metres",
    "restitution": "restitution is off by default and not in the cone of Kamino",
}


def _model(case: Case):
    import newton as engine
    import warp as wp

    builder = engine.ModelBuilder(gravity=(0.0, 0.0, -case.gravity))
    body = builder.add_body(
        xform=wp.transform(case.position.tolist(), np.roll(case.quaternion, -1).tolist()),
        mass=case.mass,
        inertia=wp.mat33(*np.diag(case.inertia).ravel().tolist()),
        lock_inertia=True,
    )
    material = builder.ShapeConfig(
        density=0.0, mu=case.mu, mu_torsional=0.0, mu_rolling=0.0, restitution=0.0
    )
    for ball in case.balls:
        offset = wp.transform([0.0, 0.0, ball.offset], wp.quat_identity())
        builder.add_shape_sphere(body, xform=offset, radius=ball.radius, cfg=material)
    builder.add_ground_plane(cfg=material)
    return builder.finalize(device="cpu")


def _solver(model, setting: dict):
    from newton import solvers

    if not setting:
        return solvers.SolverXPBD(model)
    config = solvers.SolverKamino.Config(integrator="moreau", use_collision_detector=True)
    config.padmm.primal_tolerance = config.padmm.dual_tolerance = setting["tolerance"]
    config.padmm.compl_tolerance = setting["tolerance"]
    return solvers.SolverKamino(model, config=config)


def motion(case: Case, setting: dict, step: float) -> Iterator[np.ndarray]:
    """Yield place, quaternion, velocity and angular velocity in space, one row a step."""
    import warp as wp

    wp.config.quiet = True
    model = _model(case)
    solver = _solver(model, setting)
    now, then = model.state(), model.state()
    twist = np.concatenate([case.velocity, case.omega]).astype(np.float32)[None]
    for state in (now, then, model):
        if state.body_qd is not None:
            state.body_qd.assign(twist)
        if state.joint_qd is not None:
            state.joint_qd.assign(twist[0])
    control = model.control()
    while True:
        pose, moving = now.body_q.numpy()[0], now.body_qd.numpy()[0]
        yield np.concatenate([pose[:3], np.roll(pose[3:], 1), moving]).astype(float)
        now.clear_forces()
        contacts = None if setting else model.collide(now)  # Kamino finds contacts itself
        solver.step(now, then, control, contacts, step)
        now, then = then, now
