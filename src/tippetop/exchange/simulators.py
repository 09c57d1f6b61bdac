"""A body with its start and friction as a file for a simulator, with remarks on differences."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..engine.observables import Observables
from ..errors import InputError, a_system
from ..mechanics.contact import body as contact
from ..mechanics.contact.state import moving, row_of_angles
from ..mechanics.friction import is_frictionless
from ..mechanics.operand import Vector
from ..mechanics.rotation import Quaternion, inverse, rotated
from ..mechanics.units import ANGULAR_MOMENTUM, METRE, METRE_PER_SECOND, NEWTON
from ..problem import Problem


FORMATS = ("mjcf", "urdf", "sdf")
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
    if problem.contact is not None or problem.system.name == "heavy-top":
        place, q, velocity, w, _ = (part[0] for part in motion_of(problem, problem.start()[None]))
    else:
        place, q, velocity, w = _gliding_start(problem)
    return Start(place, q, velocity, np.array(rotated(inverse(Quaternion(*q)), Vector(*w))))


def motion_of(problem: Problem, rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the motion in internal rows of a body whose contact may open, or of a heavy top.

    Parameters
    ----------
    problem : Problem
        With orientation.
    rows : ndarray
        (n, variables).

    Returns
    -------
    tuple of ndarray
        Position of the centre of mass, quaternion, its velocity, angular velocity in space and the
        force of the plane or the joint, (n, 3) or (n, 4), SI.
    """
    read, body = Observables(problem), problem.body()
    columns = read.columns(np.zeros(len(rows)), rows)
    q, scale = columns["orientation"].values, problem.scales.of
    state, carried = read.state(rows)
    u = np.stack(state[:3], axis=1).astype(float)
    L = np.stack(state[3:6], axis=1).astype(float) * scale(ANGULAR_MOMENTUM)
    fixed = problem.system.name == "heavy-top"
    inertia = contact.tip_inertia(body) if fixed else body.I1
    spin = (L * u).sum(axis=1)[:, None]
    w = L / inertia + (1 / body.I3 - 1 / inertia) * spin * u
    if fixed:
        weight = np.array([0.0, 0.0, -body.m * body.g])
        place, rate = -body.c * u, np.cross(w, u)
        bend = np.cross(np.cross(place, weight), u) + np.cross(L, rate)
        return place, q, -body.c * rate, w, -body.m * body.c / inertia * bend - weight
    y = getattr(carried, "y", 0 * carried.x)  # a cylinder moves in a plane
    place = np.stack([carried.x, y, state.height], axis=1).astype(float) * scale(METRE)
    velocity = np.stack(state[6:9], axis=1).astype(float) * scale(METRE_PER_SECOND)
    force = np.stack([state.Fx, state.Fy, state.force], axis=1).astype(float) * scale(NEWTON)
    return place, q, velocity, w, force


def _gliding_start(problem: Problem) -> tuple[np.ndarray, ...]:
    """Return the same, without the force, of a start on a plane that is never left."""
    data, body = problem.initial, problem.body()
    theta = data.get("theta", 0.0)
    s, z = math.sin(theta), math.cos(theta)
    row = row_of_angles(problem.system.start(data, s, z, body), s, z, body)
    x = moving(row, ())
    velocity = np.array(x.velocity)
    if data.get("centre_at_rest"):
        velocity[:2] = 0.0
    w = np.array(contact.angular_velocity(x.u, x.L, body))
    columns = Observables(problem).columns(np.zeros(1), problem.start()[None, :])
    place = np.array([data.get("x", 0.0), data.get("y", 0.0), x.height])
    return place, columns["orientation"].values[0], velocity, w


def text_of(problem: Problem, to: str) -> str:
    """Return the text of the file.

    Raises InputError for a planar body whose contact never opens, or another format.
    """
    if to not in FORMATS:
        raise InputError(f"--to must be one of {', '.join(FORMATS)} for a scenario, but is `{to}`.")
    planar = "axis" not in problem.system.vectors and problem.contact is None
    if planar or not isinstance(problem.body(), contact.Touch):
        raise InputError(
            f"a body for a simulator must be a top, but this is {a_system(problem.system.name)}."
        )
    if not problem.orientation:
        raise InputError("`run.orientation` must be true for a simulator, but is false.")
    return {"mjcf": _mjcf, "urdf": _urdf, "sdf": _sdf}[to](problem)


DIGITS = 12
"""Significant digits of exported numbers, so that rounding errors do not change a file."""


def rounded_to_digits(values: Any) -> np.ndarray:
    """Return a vector or a table, rounded to `DIGITS` significant digits of its largest number."""
    values = np.asarray(values, float)
    largest = float(np.max(np.abs(values), initial=0.0))
    if not largest:
        return np.abs(values)
    return np.round(values, DIGITS - 1 - math.floor(math.log10(largest))) + 0.0


def _numbers(*values: Any) -> str:
    return " ".join(
        f"{float(v):.{DIGITS}g}" for part in values for v in np.ravel(rounded_to_digits(part))
    )


def _balls(problem: Problem) -> list[tuple[str, float, float]]:
    """Return name, offset along the axis and radius of each ball that touches the plane."""
    body = problem.body()
    if body.R == 0:
        return [("tip", body.c, TIP * abs(body.c))]
    balls = [("sphere", body.c, body.R)]
    if problem.contact is not None and problem.contact.stem:
        balls.append(("stem", body.c + problem.contact.h, problem.contact.r))
    return balls


DRILLING = 3 * math.pi / 16
"""Drilling torque of a disc that does not slide, per mu N and radius, under Hertz's pressure."""


class Friction(NamedTuple):
    """Friction coefficients: of sliding, and of drilling and rolling torques [m]."""

    mu: float
    torsion: float
    rolling: float


def _cannot(problem: Problem) -> tuple[Friction, list[str]]:
    """Return the friction coefficients, and the differences of a simulator in sentences."""
    law, body = problem.friction, problem.body()
    fixed = problem.system.name == "heavy-top"
    sentences = (
        []
        if fixed
        else ["contacts in simulators are soft, or solved once a step: refine step and stiffness"]
    )
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
    elif "eps" in law._fields and problem.law.key == "coulomb":
        sentences.append(
            f"the regularisation speed eps = {law.eps:g} m/s of the law: a simulator has its own"
        )
    elif problem.system.frictional:
        words = problem.law.long_name
        sentences.append(
            f"the friction law {words}: here Coulomb friction with the number mu = {mu:g}, "
            "another law"
        )
    torsion = DRILLING * mu * getattr(law, "patch", 0.0) + getattr(law, "mu_d", 0.0)
    rolling = float(getattr(law, "mu_r", 0.0))
    if problem.contact is not None and problem.contact.e_n:
        sentences.append(f"restitution e_n = {problem.contact.e_n:g}: set it in the simulator")
    if "axis" not in problem.system.vectors:
        sentences.append("a cylinder: here a ball, with the same motion in the plane of motion")
    if body.R == 0 and not fixed:
        sentences.append(f"a tip that is a point: here a ball of radius {TIP * abs(body.c):.3g} m")
    if problem.contact is None and not fixed:
        sentences.append("a plane that the body cannot leave: here it can bounce and lift off")
    return Friction(mu, torsion, rolling), sentences


def _comment(problem: Problem, sentences: list[str]) -> str:
    lines = "\n".join(f"    - {sentence}" for sentence in sentences).replace("--", "-")
    return (
        f"<!--\n  {problem.system.title}, from tippetop. SI units, z up, z of the body along its "
        "axis of symmetry.\n"
        f"  Compare the output with: {RESULT}\n"
        f"  Differences from tippetop:\n{lines}\n-->\n"
    )


def _mjcf(problem: Problem) -> str:
    body, start = problem.body(), start_of(problem)
    friction, sentences = _cannot(problem)
    fixed = problem.system.name == "heavy-top"
    frame = body.c  # the centre of the ball that touches, or the fixed tip
    inertia = (
        f'<inertial pos="0 0 {_numbers(-frame)}" mass="{_numbers(body.m)}" '
        f'diaginertia="{_numbers(body.I1, body.I1, body.I3)}"/>'
    )
    condim = 6 if friction.rolling else 4 if friction.torsion else 3 if friction.mu else 1
    geoms = "\n".join(
        f'      <geom name="{name}" type="sphere" size="{_numbers(radius)}" pos="0 0 '
        f'{_numbers(offset - frame)}" '
        f'condim="{condim}" friction="{_numbers(*friction)}"/>'
        for name, offset, radius in _balls(problem)
    )
    floor = (
        f'<geom name="floor" type="plane" size="1 1 0.1" condim="{condim}" '
        f'friction="{_numbers(*friction)}"/>'
    )
    if fixed:
        joint, geoms, floor = (
            '<joint name="tip" type="ball" damping="0"/>',
            "",
            "",
        )
        qpos, qvel = _numbers(start.quaternion), _numbers(start.omega)
    else:
        joint = "<freejoint/>"
        arm = frame * np.array(rotated(Quaternion(*start.quaternion), Vector(0.0, 0.0, 1.0)))
        turning = rotated(Quaternion(*start.quaternion), Vector(*start.omega))
        qpos = _numbers(start.place + arm, start.quaternion)
        qvel = _numbers(start.velocity + np.cross(turning, arm), start.omega)
    default = f'<default>\n    <geom solref="{_numbers(2 * STEP)} 1"/>\n  </default>\n  '
    if fixed:
        sentences.append("the tip is held by a ball joint at the origin: there is no plane")
        default = ""
    else:
        sentences.append(
            "the contact is as stiff as the step allows, solref = 2 timestep: change both together"
        )
    sentences.append(
        "the body frame is at the centre of the ball, or at a fixed tip: only there MuJoCo "
        "computes the acceleration of the contact in full; the centre of mass is xipos"
    )
    return f"""{_comment(problem, sentences)}<mujoco model="{problem.system.name}">
  <option timestep="{_numbers(STEP)}" gravity="0 0 {_numbers(-body.g)}" cone="elliptic"
          integrator="RK4" impratio="10"
          density="0" viscosity="0"/>
  {default}<worldbody>
    {floor}
    <body name="top">
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
    body = problem.body()
    _, sentences = _cannot(problem)
    sentences.append(
        "URDF has no start, gravity or friction: set them in the simulator, as follows; "
        "the body frame is at the centre of mass"
    )
    fixed = problem.system.name == "heavy-top"
    if fixed:
        sentences.append(
            f"a ball joint, which URDF lacks, must hold the point 0 0 {_numbers(body.c)} of the "
            "body (the tip) at the origin"
        )
    balls = "\n".join(
        f'    <collision name="{name}">\n      <origin xyz="0 0 {_numbers(offset)}"/>\n'
        f'      <geometry><sphere radius="{_numbers(radius)}"/></geometry>\n    </collision>'
        for name, offset, radius in ([] if fixed else _balls(problem))
    )
    inertia = " ".join(f'{name}="{value}"' for name, value in _moments(problem).items())
    return f"""<?xml version="1.0"?>
{_comment(problem, [*sentences, *_settings(problem)])}<robot name="{problem.system.name}">
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


def _moments(problem: Problem) -> dict[str, str]:
    """Return the moments of inertia about the centre of mass by their names in URDF and SDF."""
    body = problem.body()
    across, along = _numbers(body.I1), _numbers(body.I3)
    return {"ixx": across, "iyy": across, "izz": along, "ixy": "0", "ixz": "0", "iyz": "0"}


def _settings(problem: Problem) -> tuple[str, ...]:
    """Return sentences about settings that a model file lacks: gravity, friction, start."""
    start, friction = start_of(problem), _cannot(problem)[0]
    bounce = problem.contact.e_n if problem.contact is not None else 0.0
    return (
        f"gravity 0 0 {_numbers(-problem.body().g)}; friction {_numbers(friction.mu)}; "
        f"restitution {_numbers(bounce)}",
        f"place of the centre of mass {_numbers(start.place)}; quaternion w x y z "
        f"{_numbers(start.quaternion)}",
        f"velocity {_numbers(start.velocity)}; angular velocity in body axes "
        f"{_numbers(start.omega)}",
    )


def _roll_pitch_yaw(quaternion: np.ndarray) -> list[float]:
    """Return the angles of SDF: rotations about the fixed axes x, y and z [rad]."""
    w, x, y, z = rounded_to_digits(quaternion)
    total, difference = math.atan2(z + x, w - y), math.atan2(z - x, w + y)
    pitch = 2 * math.atan2(math.hypot(w + y, z - x), math.hypot(w - y, z + x)) - math.pi / 2
    return [total - difference, pitch, total + difference]


def _sdf(problem: Problem) -> str:
    body, start = problem.body(), start_of(problem)
    friction, sentences = _cannot(problem)
    sentences.append(
        "SDF has no initial velocity: set it in the simulator, as follows; the body frame is at "
        "the centre of mass, and the pose ends with roll, pitch and yaw"
    )
    bounce = problem.contact.e_n if problem.contact is not None else 0.0
    surface = f"""<surface>
            <friction>
              <ode><mu>{_numbers(friction.mu)}</mu><mu2>{_numbers(friction.mu)}</mu2></ode>
              <torsional>
                <coefficient>{_numbers(friction.torsion)}</coefficient>
                <use_patch_radius>false</use_patch_radius>
              </torsional>
            </friction>
            <bounce><restitution_coefficient>{_numbers(bounce)}</restitution_coefficient></bounce>
          </surface>"""
    fixed = problem.system.name == "heavy-top"
    balls = "".join(
        f"""
        <collision name="{name}">
          <pose>0 0 {_numbers(offset)} 0 0 0</pose>
          <geometry><sphere><radius>{_numbers(radius)}</radius></sphere></geometry>
          {surface}
        </collision>"""
        for name, offset, radius in ([] if fixed else _balls(problem))
    )
    inertia = "".join(f"<{name}>{value}</{name}>" for name, value in _moments(problem).items())
    pose = _numbers(start.place, _roll_pitch_yaw(start.quaternion))
    floor = f"""
    <model name="floor">
      <static>true</static>
      <link name="floor">
        <collision name="floor">
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          {surface}
        </collision>
      </link>
    </model>"""
    joint = f"""
      <joint name="tip" type="ball">
        <parent>world</parent>
        <child>top</child>
        <pose>0 0 {_numbers(body.c)} 0 0 0</pose>
      </joint>"""
    return f"""<?xml version="1.0"?>
{_comment(problem, [*sentences, *_settings(problem)])}<sdf version="1.6">
  <world name="default">
    <gravity>0 0 {_numbers(-body.g)}</gravity>{"" if fixed else floor}
    <model name="top">
      <pose>{pose}</pose>
      <link name="top">
        <inertial>
          <mass>{_numbers(body.m)}</mass>
          <inertia>{inertia}</inertia>
        </inertial>{balls}
      </link>{joint if fixed else ""}
    </model>
  </world>
</sdf>
"""
