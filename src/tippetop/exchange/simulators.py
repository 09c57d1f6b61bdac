"""A body with its start and friction as a file for a simulator, with remarks on differences."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..engine.observables import Observables
from ..errors import InputError, a_system
from ..mechanics.contact import body as contact
from ..mechanics.friction import has_parts, is_frictionless
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, inverse, rotated
from ..problem import Problem


FORMATS = ("mjcf", "urdf")
TIP = 1e-3  # radius of the ball for a tip, in lengths from the tip to the centre of mass
# [s]. A soft contact is as stiff as the step allows; see docs/how-to/compare-a-simulator.md.
STEP = 1e-4
RESULT = "tippetop compare OTHER.csv SCENARIO"


class Start(NamedTuple):
    """The state at t = 0, SI: place, quaternion wxyz, velocity, angular velocity in body axes."""

    place: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray


def start_of(problem: Problem) -> Start:
    """Return the start of a body on the plane, in any form."""
    columns = {
        k: c.values[0]
        for k, c in Observables(problem).columns(np.zeros(1), problem.start()[None, :]).items()
    }
    body = problem.body()
    u, L = np.asarray(columns["axis"]), np.asarray(columns["L"])
    fixed = problem.system.name == "heavy-top"
    inertia = contact.tip_inertia(body) if fixed else body.I1
    w = np.array(
        contact.angular_velocity_of(Vector(*u), Vector(*L), float(L @ u), body._replace(I1=inertia))
    )
    offset, radius = body.c, body.R
    if problem.contact is not None and columns["ball"]:  # it starts on its stem
        offset, radius = body.c + problem.contact.h, problem.contact.r
    arm = offset * u - np.array([0.0, 0.0, radius])
    slip = np.zeros(3)
    if "nu_x" in columns:
        phi, along, across = (
            float(np.nan_to_num(columns[name])) for name in ("phi", "nu_x", "nu_y")
        )
        e, f = math.cos(phi), math.sin(phi)
        slip = np.array([along * e - across * f, along * f + across * e, columns.get("nu_z", 0.0)])
    velocity = slip - np.cross(w, arm)
    height = columns.get("z", contact.height(u[2], body))
    place = -arm if fixed else np.array([columns.get("x", 0.0), columns.get("y", 0.0), height])
    q = np.asarray(columns["orientation"])
    return Start(place, q, velocity, np.array(rotated(inverse(Quaternion(*q)), Vector(*w))))


def text_of(problem: Problem, to: str) -> str:
    """Return the text of the file.

    Raises InputError for a planar body, or another format.
    """
    if to not in FORMATS:
        raise InputError(f"--to must be one of {', '.join(FORMATS)} for a scenario, but is `{to}`.")
    if not isinstance(problem.body(), contact.Touch) or "axis" not in problem.system.vectors:
        raise InputError(
            f"a body for a simulator must be a top, but this is {a_system(problem.system.name)}."
        )
    if not problem.orientation:
        raise InputError("`run.orientation` must be true for a simulator, but is false.")
    return (_mjcf if to == "mjcf" else _urdf)(problem)


def _numbers(*values: Any) -> str:
    return " ".join(f"{float(v):.15g}" for part in values for v in np.ravel(part))


def _balls(problem: Problem) -> list[tuple[str, float, float]]:
    """Return name, offset along the axis and radius of each ball that touches the plane."""
    body = problem.body()
    if body.R == 0:
        return [("tip", body.c, TIP * abs(body.c))]
    balls = [("sphere", body.c, body.R)]
    if problem.contact is not None and problem.contact.stem:
        balls.append(("stem", body.c + problem.contact.h, problem.contact.r))
    return balls


def _cannot(problem: Problem) -> tuple[float, list[str]]:
    """Return the friction coefficient, and the differences of a simulator in sentences."""
    law, body = problem.friction, problem.body()
    sentences = [
        "contacts in simulators are soft, or solved once a step: refine step and stiffness"
    ]
    mu = float(getattr(law, "mu", 0.0))
    if problem.system.name.startswith("rolling"):
        mu = 10.0
        sentences.append(
            "pure rolling: here Coulomb friction so large (mu = 10) that it hardly slips"
        )
    elif problem.system.frictional and is_frictionless(law):
        mu = 0.0
    elif problem.law.set_valued:
        pass
    elif "eps" in law._fields and problem.law_name == "coulomb":
        sentences.append(
            f"the regularisation speed eps = {law.eps:g} m/s of the law: a simulator has its own"
        )
    elif problem.system.frictional:
        words = problem.law.long_name
        sentences.append(
            f"the friction law {words}: here Coulomb friction with the number mu = {mu:g}, "
            "another law"
        )
    if has_parts(law):
        sentences.append("rolling resistance and the drilling torque of the law: here neither")
    if body.R == 0 and problem.system.name != "heavy-top":
        sentences.append(f"a tip that is a point: here a ball of radius {TIP * abs(body.c):.3g} m")
    if problem.contact is None:
        sentences.append("a plane that the body cannot leave: here it can bounce and lift off")
    return mu, sentences


def _comment(problem: Problem, sentences: list[str]) -> str:
    lines = "\n".join(f"    - {sentence}" for sentence in sentences).replace("--", "-")
    return (
        f"<!--\n  {problem.system.title}, from tippetop. SI units, z up; the body's frame is at "
        "its centre of mass,\n"
        f"  z along its axis of symmetry. Compare the output with: {RESULT}\n"
        f"  Differences from tippetop:\n{lines}\n-->\n"
    )


def _mjcf(problem: Problem) -> str:
    body, start = problem.body(), start_of(problem)
    mu, sentences = _cannot(problem)
    fixed = problem.system.name == "heavy-top"
    inertia = (
        f'<inertial pos="0 0 0" mass="{_numbers(body.m)}" '
        f'diaginertia="{_numbers(body.I1, body.I1, body.I3)}"/>'
    )
    condim = 3 if mu > 0 else 1
    geoms = "\n".join(
        f'      <geom name="{name}" type="sphere" size="{_numbers(radius)}" pos="0 0 '
        f'{_numbers(offset)}" '
        f'condim="{condim}" friction="{_numbers(mu)} 0 0"/>'
        for name, offset, radius in _balls(problem)
    )
    floor = (
        f'<geom name="floor" type="plane" size="1 1 0.1" condim="{condim}" '
        f'friction="{_numbers(mu)} 0 0"/>'
    )
    if fixed:
        joint, geoms, floor = (
            f'<joint name="tip" type="ball" pos="0 0 {_numbers(body.c)}" damping="0"/>',
            "",
            "",
        )
        qpos, qvel = _numbers(start.quaternion), _numbers(start.omega)
    else:
        joint = "<freejoint/>"
        qpos, qvel = _numbers(start.place, start.quaternion), _numbers(start.velocity, start.omega)
    place = _numbers(0, 0, -body.c) if fixed else "0 0 0"
    default = f'<default>\n    <geom solref="{_numbers(2 * STEP)} 1"/>\n  </default>\n  '
    if fixed:
        sentences.append("the tip is held by a ball joint at the origin: there is no plane")
        default = ""
    else:
        sentences.append(
            "the contact is as stiff as the step allows, solref = 2 timestep: change both together"
        )
    return f"""{_comment(problem, sentences)}<mujoco model="{problem.system.name}">
  <option timestep="{_numbers(STEP)}" gravity="0 0 {_numbers(-body.g)}" cone="elliptic"
          integrator="RK4" impratio="10"
          density="0" viscosity="0"/>
  {default}<worldbody>
    {floor}
    <body name="top" pos="{place}">
      {joint}
      {inertia}
{geoms}
    </body>
  </worldbody>
  <keyframe>
    <key name="start" qpos="{qpos}" qvel="{qvel}"/>
  </keyframe>
</mujoco>
"""


def _urdf(problem: Problem) -> str:
    body, start = problem.body(), start_of(problem)
    mu, sentences = _cannot(problem)
    sentences.append(
        "URDF has no start, gravity or friction: set them in the simulator, as follows"
    )
    state = (
        f"gravity 0 0 {_numbers(-body.g)}; friction {_numbers(mu)}; restitution 0",
        f"place of the centre of mass {_numbers(start.place)}; quaternion w x y z "
        f"{_numbers(start.quaternion)}",
        f"velocity {_numbers(start.velocity)}; angular velocity in body axes "
        f"{_numbers(start.omega)}",
    )
    balls = "\n".join(
        f'    <collision name="{name}">\n      <origin xyz="0 0 {_numbers(offset)}"/>\n'
        f'      <geometry><sphere radius="{_numbers(radius)}"/></geometry>\n    </collision>'
        for name, offset, radius in _balls(problem)
    )
    inertia = (
        f'ixx="{_numbers(body.I1)}" iyy="{_numbers(body.I1)}" izz="{_numbers(body.I3)}" '
        'ixy="0" ixz="0" iyz="0"'
    )
    return f"""<?xml version="1.0"?>
{_comment(problem, [*sentences, *state])}<robot name="{problem.system.name}">
  <link name="top">
    <inertial>
      <origin xyz="0 0 0"/>
      <mass value="{_numbers(body.m)}"/>
      <inertia {inertia}/>
    </inertial>
{balls}
  </link>
</robot>
"""
