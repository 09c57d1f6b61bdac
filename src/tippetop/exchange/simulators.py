"""A body with its start and friction as a file for a simulator, with remarks on differences.

A problem goes in; text in MJCF, URDF or SDF comes out, by way of a `Model`. The text of a problem
is the same at each export, as the benchmark lists checksums of its files (SHA256SUMS).
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..columns import Arrays
from ..engine.observables import Observables
from ..errors import InputError
from ..mechanics.contact import body as contact
from ..mechanics.contact.surroundings import require_still
from ..mechanics.friction import is_frictionless
from ..mechanics.units import METRE_PER_SECOND, NEWTON, Unit
from ..problem import Problem
from ..runs.shape import Surface, angular_velocity, lowest, moments, surface_of
from .motion import in_body_axes, turned


TIP = 1e-3  # radius of the ball for a tip, in lengths from the tip to the centre of mass
# [s]. A soft contact is as stiff as the step allows; see docs/how-to/compare-a-simulator.md.
STEP = 1e-4
RESULT = "tippetop compare OTHER.csv SCENARIO"


class Start(NamedTuple):
    """The state at t = 0, SI: place, quaternion wxyz, velocity, angular velocity in body axes.

    Place and velocity are those of the centre of mass in space. The quaternion is (4,), the others
    are (3,).
    """

    place: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray


def start_of(problem: Problem) -> Start:
    """Return the start of a body on the plane, in any form, whatever columns a run would have.

    The body must have an outline, or be a heavy top: see `columns_of`.
    """
    problem = replace(problem, columns=None, orientation=True)
    columns = columns_of(problem, np.zeros(1), problem.start()[None])
    names = ("place", "orientation", "velocity", "omega")
    place, q, velocity, w = (columns[name][0] for name in names)
    return Start(place, q, velocity, in_body_axes(q, w))


def columns_of(problem: Problem, times: np.ndarray, rows: np.ndarray) -> Arrays:
    """Return the columns of a motion by name, and quantities that a table may have instead, SI.

    `rows` (n, variables) are internal states at times [s], (n,). The quantities have the names of
    `headers.KINDS`, by which `comparison.compare` and `benchmark.truth` read them. A heavy top has
    all; other bodies have no `force` where the contact never opens, and none without an outline.
    """
    body = problem.body()
    view = Observables(problem)
    columns = {name: column.values for name, column in view.columns(times, rows).items()}
    if problem.system.name == "heavy-top":
        u = columns["axis"]
        L = columns["L"]
        inertia = contact.tip_inertia(body)
        w = angular_velocity(u, L, body._replace(I1=inertia))
        weight = np.array([0.0, 0.0, -body.m * body.g])
        place = -body.c * u
        rate = np.cross(w, u)
        # u' = L x u/inertia, so u'' = bend/inertia; the force is m place'' - weight
        bend = np.cross(np.cross(place, weight), u) + np.cross(L, rate)
        force = -body.m * body.c / inertia * bend - weight
        return columns | {"place": place, "velocity": -body.c * rate, "omega": w, "force": force}
    if not hasattr(body, "outline"):
        return columns
    none = np.zeros(len(rows))
    if "axis" in columns:
        attitude = attitude_of(columns, body)
        omega = angular_velocity(attitude, columns["L"], body)
    else:  # a cylinder, which moves in the plane of x and z
        theta = columns["theta"]
        attitude = np.stack([np.sin(theta), none, np.cos(theta)], axis=1)
        omega = np.stack([none, columns["theta_dot"], none], axis=1)
    state, carried = view.state(rows)

    def vectors(unit: Unit, *parts: Any) -> np.ndarray:
        """Return three arrays of components (n,), internal units of `unit`, as (n, 3), SI."""
        return np.stack(parts, axis=1).astype(float) * problem.unit(unit)

    if problem.contact is None:
        rates = {i.name: i.rate(state, carried, view.body) for i in problem.variables.integrals}
        across = (rates.get(name, none) + none for name in "xy")
        down = lowest(attitude, body)
        velocity = vectors(METRE_PER_SECOND, *across, none)
        velocity[:, 2] = np.cross(down, omega)[:, 2]
        z = -down[:, 2]
    else:
        velocity = vectors(METRE_PER_SECOND, *(getattr(state, n) for n in contact.VELOCITY))
        columns["force"] = vectors(NEWTON, state.Fx, state.Fy, state.force)
        z = columns["z"]
    place = np.stack([columns["x"], columns.get("y", none), z], axis=1)
    return columns | {"place": place, "velocity": velocity, "omega": omega}


def attitude_of(motion: Arrays, body: Any) -> Any:
    """Return the orientation (rows, 4) or the axis (rows, 3), as `shape.lies` takes it, or None.

    `motion` are columns by name, of a run or of a table; `body` is the `b` of formulas in SI. A
    body without an axis of symmetry (it has `I2`) needs its orientation.
    """
    name = "orientation" if hasattr(body, "I2") else "axis"
    return motion.get(name) if hasattr(body, "outline") else None


def text_of(problem: Problem, to: str) -> str:
    """Return the text of the file in the format `to`: "mjcf", "urdf" or "sdf".

    Raises InputError for a body that is neither a top nor a cylinder whose contact may open, for a
    surface that the format cannot express, and for air, a vibrating plane or a turntable.
    """
    # one whose contact never opens may have the reaction `modified`, which no simulator has
    planar = "axis" not in problem.system.vectors and problem.contact is None
    if planar or not hasattr(problem.body(), "outline"):
        raise InputError(
            "a body for a simulator must be a top, or a cylinder whose contact may open, but is "
            f"`{problem.system.name}`."
        )
    if to not in formats_of(problem):
        raise InputError(
            f"the surface of `{problem.system.name}` must be one that `{to}` can express: MJCF and "
            "SDF have spheres and ellipsoids, URDF has spheres."
        )
    require_still(problem.tables, "a body for a simulator", tilted=True)
    return {"mjcf": _mjcf, "urdf": _urdf, "sdf": _sdf}[to](Model(problem))


def formats_of(problem: Problem) -> tuple[str, ...]:
    """Return the formats that can express the surface of a body, which must have an outline.

    `benchmark.case_files` writes a file for each. `_urdf` relies on URDF being one of spheres only.
    """
    surface = surface_of(problem.body())
    if len(surface.meridian):
        return ()
    return ("mjcf", "sdf") if np.ptp(surface.half) else ("mjcf", "urdf", "sdf")


def gravity(body: Any) -> np.ndarray:
    """Return gravity in the axes of the plane, (3,) [m/s^2]."""
    slope = (body.around and body.around.slope) or (0.0, 0.0)
    return np.array([*slope, -body.g])


DIGITS = 12
"""Significant digits of exported numbers, so that rounding errors do not change a file."""


def rounded_to_digits(values: Any) -> np.ndarray:
    """Return a vector or a table, rounded to `DIGITS` significant digits of its largest number.

    No zero has a minus sign, which texts would show. `benchmark.case_files` uses it too.
    """
    values = np.asarray(values, float)
    largest = float(np.max(np.abs(values), initial=0.0))
    if not largest:
        return np.abs(values)
    return np.round(values, DIGITS - 1 - math.floor(math.log10(largest))) + 0.0


def _numbers(*values: Any) -> str:
    """Return numbers as text, separated by spaces."""
    return " ".join(
        f"{float(v):.{DIGITS}g}" for part in values for v in np.ravel(rounded_to_digits(part))
    )


DRILLING = 3 * math.pi / 16
"""Drilling torque of a disc that does not slide, per mu N and radius, under Hertz's pressure."""


class Model:
    """A body as simulators take it.

    Attributes
    ----------
    system
        Its system, with name and title.
    body, start
        In SI units.
    fixed
        Whether its tip is fixed.
    frame
        The tip, or the centre of the surface, from the centre of mass.
    moments, inertia
        Principal moments of inertia; the same as text by their names in URDF and SDF.
    gravity
        In the axes of the plane, which is level in a simulator, as text.
    surfaces
        A `shape.Surface` for each that touches the plane, by name: the sphere, tip or ellipsoid,
        and the stem; none if the tip is fixed. Names become those of geoms and collisions; an
        `ellipsoid` needs SDF 1.8.
    friction
        Coefficients of sliding, and of drilling and rolling torques [m], in the order of MJCF.
    bounce
        Restitution.
    differences
        Those of a simulator from the scenario, in sentences.
    """

    def __init__(self, problem: Problem):
        """Choose surfaces and coefficients, and list what a simulator computes differently."""
        law = problem.friction
        opens = problem.contact
        self.system = problem.system
        self.body = problem.body()
        self.start = start_of(problem)
        self.fixed = fixed = problem.system.name == "heavy-top"
        self.moments = moments(self.body)
        self.inertia = dict(zip(("ixx", "iyy", "izz"), map(_numbers, self.moments), strict=True))
        self.inertia |= {"ixy": "0", "ixz": "0", "iyz": "0"}
        self.gravity = _numbers(*gravity(self.body))
        touching = surface_of(self.body)
        pointed = not touching.half.any()
        tip = TIP * abs(touching.centre[2])
        self.frame = touching.centre
        self.surfaces = dict[str, Surface]()
        if not fixed:
            name = "tip" if pointed else "ellipsoid" if np.ptp(touching.half) else "sphere"
            self.surfaces[name] = touching._replace(half=np.full(3, tip)) if pointed else touching
        if opens is not None and opens.stem:
            centre = touching.centre + np.array([0.0, 0.0, opens.h])
            self.surfaces["stem"] = Surface(centre, np.full(3, opens.r))
        mu = float(getattr(law, "mu", 0.0))
        self.differences = sentences = list[str]()
        if not fixed:
            sentences.append(
                "contacts in simulators are soft, or solved once a step: refine step and stiffness"
            )
        if problem.system.name.startswith("rolling"):
            mu = 10.0  # also in the sentence: a change of one is a change of both
            sentences.append(
                "pure rolling: here Coulomb friction so large (mu = 10) that it hardly slips"
            )
        elif problem.system.frictional and is_frictionless(law):
            mu = 0.0
        elif "eps" in law._fields and problem.law.key == "coulomb":
            sentences.append(
                f"the regularisation speed eps = {law.eps:g} m/s of the law: a simulator has its "
                "own"
            )
        elif problem.system.frictional and not problem.law.set_valued:
            words = problem.law.long_name
            sentences.append(
                f"the friction law {words}: here Coulomb friction with the number mu = {mu:g}, "
                "another law"
            )
        torsion = DRILLING * mu * getattr(law, "patch", 0.0) + getattr(law, "mu_d", 0.0)
        self.friction = mu, torsion, float(getattr(law, "mu_r", 0.0))
        self.bounce = opens.e_n if opens is not None else 0.0
        if self.bounce:
            sentences.append(f"restitution e_n = {self.bounce:g}: set it in the simulator")
        if "axis" not in problem.system.vectors:
            sentences.append("a cylinder: here a ball, with the same motion in the plane of motion")
        if pointed and not fixed:
            sentences.append(f"a tip that is a point: here a ball of radius {tip:.3g} m")
        if opens is None and not fixed:
            sentences.append("a plane that the body cannot leave: here it can bounce and lift off")

    def comment(self, *sentences: str) -> str:
        """Return the differences of a simulator, and further ones, as a comment of XML.

        XML allows no `--` in a comment, so that it becomes `-`.
        """
        sentences = (*self.differences, *sentences)
        lines = "\n".join(f"    - {sentence}" for sentence in sentences).replace("--", "-")
        third = "its axis of symmetry" if self.moments[0] == self.moments[1] else "axis 3"
        return (
            f"<!--\n  {self.system.title}, from tippetop. SI units, z up, z of the body along "
            f"{third}.\n"
            f"  Compare the output with: {RESULT}\n"
            f"  Differences from tippetop:\n{lines}\n-->\n"
        )

    def settings(self) -> tuple[str, ...]:
        """Return what a simulator must be told: gravity, friction, start, in sentences."""
        start = self.start
        return (
            f"gravity {self.gravity}; friction {_numbers(self.friction[0])}; "
            f"restitution {_numbers(self.bounce)}",
            f"place of the centre of mass {_numbers(start.place)}; quaternion w x y z "
            f"{_numbers(start.quaternion)}",
            f"velocity {_numbers(start.velocity)}; angular velocity in body axes "
            f"{_numbers(start.omega)}",
        )


def _ellipsoid(surface: Surface) -> str:
    """Return type, size and attitude of a geom in MJCF."""
    if not np.ptp(surface.half):
        return f'type="sphere" size="{_numbers(surface.half[0])}"'
    angle = surface.turn / 2
    quaternion = _numbers([math.cos(angle), 0.0, 0.0, math.sin(angle)])
    return f'type="ellipsoid" size="{_numbers(surface.half)}" quat="{quaternion}"'


def _mjcf(model: Model) -> str:
    """Return the text of a model of MuJoCo (MJCF); the start is its keyframe."""
    body, start, (mu, torsion, rolling) = model.body, model.start, model.friction
    frame = model.frame
    inertia = (
        f'<inertial pos="{_numbers(-frame)}" mass="{_numbers(body.m)}" '
        f'diaginertia="{_numbers(*model.moments)}"/>'
    )
    # directions of friction in MuJoCo: none, sliding, also drilling, also rolling
    condim = 6 if rolling else 4 if torsion else 3 if mu else 1
    surface = f'condim="{condim}" friction="{_numbers(*model.friction)}"'
    geoms = "\n".join(
        f'      <geom name="{name}" {_ellipsoid(each)} pos="{_numbers(each.centre - frame)}" '
        f"{surface}/>"
        for name, each in model.surfaces.items()
    )
    frames = (
        "the body frame is at the centre of the ball, or at a fixed tip: only there MuJoCo "
        "computes the acceleration of the contact in full; the centre of mass is xipos"
    )
    if model.fixed:
        joint = '<joint name="tip" type="ball" damping="0"/>'
        floor = ""
        default = ""
        contact_words = "the tip is held by a ball joint at the origin: there is no plane"
        qpos = _numbers(start.quaternion)
        qvel = _numbers(start.omega)
    else:
        joint = "<freejoint/>"
        floor = f'<geom name="floor" type="plane" size="1 1 0.1" {surface}/>'
        default = f'<default>\n    <geom solref="{_numbers(2 * STEP)} 1"/>\n  </default>\n  '
        contact_words = (
            "the contact is as stiff as the step allows, solref = 2 timestep: change both together"
        )
        arm = turned(start.quaternion, frame)
        turning = turned(start.quaternion, start.omega)
        qpos = _numbers(start.place + arm, start.quaternion)
        qvel = _numbers(start.velocity + np.cross(turning, arm), start.omega)
    return f"""{model.comment(contact_words, frames)}<mujoco model="{model.system.name}">
  <option timestep="{_numbers(STEP)}" gravity="{model.gravity}" cone="elliptic"
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


def _urdf(model: Model) -> str:
    """Return the text of a URDF file; start, gravity and friction are in its comment."""
    body = model.body
    sentences = [
        "URDF has no start, gravity or friction: set them in the simulator, as follows; "
        "the body frame is at the centre of mass"
    ]
    if model.fixed:
        sentences.append(
            f"a ball joint, which URDF lacks, must hold the point 0 0 {_numbers(body.c)} of the "
            "body (the tip) at the origin"
        )
    balls = "\n".join(
        f'    <collision name="{name}">\n      <origin xyz="{_numbers(each.centre)}"/>\n'
        f'      <geometry><sphere radius="{_numbers(each.half[0])}"/></geometry>\n    </collision>'
        for name, each in model.surfaces.items()
    )
    inertia = " ".join(f'{name}="{value}"' for name, value in model.inertia.items())
    return f"""<?xml version="1.0"?>
{model.comment(*sentences, *model.settings())}<robot name="{model.system.name}">
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


def _roll_pitch_yaw(quaternion: np.ndarray) -> list[float]:
    """Return the angles of SDF [rad]: rotations about the fixed axes x, y and z, in this order.

    `quaternion` is w, x, y, z, of length 1. It is rounded first: where the pitch is a right angle,
    both arguments of an atan2 vanish, and rounding errors would choose the angle.
    """
    w, x, y, z = rounded_to_digits(quaternion)
    total = math.atan2(z + x, w - y)
    difference = math.atan2(z - x, w + y)
    pitch = 2 * math.atan2(math.hypot(w + y, z - x), math.hypot(w - y, z + x)) - math.pi / 2
    return [total - difference, pitch, total + difference]


def _sdf_geometry(surface: Surface) -> str:
    """Return a surface as an SDF element, a sphere or an ellipsoid."""
    if not np.ptp(surface.half):
        return f"<sphere><radius>{_numbers(surface.half[0])}</radius></sphere>"
    return f"<ellipsoid><radii>{_numbers(surface.half)}</radii></ellipsoid>"


def _sdf(model: Model) -> str:
    """Return the text of a world of Gazebo (SDF); the initial velocity is in its comment."""
    body, fixed, (mu, torsion, _) = model.body, model.fixed, model.friction
    sentence = (
        "SDF has no initial velocity: set it in the simulator, as follows; the body frame is at "
        "the centre of mass, and the pose ends with roll, pitch and yaw"
    )
    surface = f"""<surface>
            <friction>
              <ode><mu>{_numbers(mu)}</mu><mu2>{_numbers(mu)}</mu2></ode>
              <torsional>
                <coefficient>{_numbers(torsion)}</coefficient>
                <use_patch_radius>false</use_patch_radius>
              </torsional>
            </friction>
            <bounce><restitution_coefficient>{_numbers(model.bounce)}</restitution_coefficient></bounce>
          </surface>"""
    balls = "".join(
        f"""
        <collision name="{name}">
          <pose>{_numbers(each.centre)} 0 0 {_numbers(each.turn)}</pose>
          <geometry>{_sdf_geometry(each)}</geometry>
          {surface}
        </collision>"""
        for name, each in model.surfaces.items()
    )
    inertia = "".join(f"<{name}>{value}</{name}>" for name, value in model.inertia.items())
    pose = _numbers(model.start.place, _roll_pitch_yaw(model.start.quaternion))
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
        <pose>{_numbers(model.frame)} 0 0 0</pose>
      </joint>"""
    version = "1.8" if "ellipsoid" in model.surfaces else "1.6"
    return f"""<?xml version="1.0"?>
{model.comment(sentence, *model.settings())}<sdf version="{version}">
  <world name="default">
    <gravity>{model.gravity}</gravity>{"" if fixed else floor}
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
