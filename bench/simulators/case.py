"""A case of the benchmark as an adapter reads it: only from the exported folder."""

import math
import tomllib
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np


TOOTH = 3 * math.pi / 16
"""Drilling torque of a disc without slip, per mu N and radius, under the pressure of Hertz."""


class Ball(NamedTuple):
    """A ball of the body: offset of its centre along the axis, and radius [m]."""

    offset: float
    radius: float


class Case(NamedTuple):
    """A body with its start. SI; quaternion w x y z; velocities in the space frame."""

    name: str
    mass: float
    inertia: np.ndarray
    gravity: float
    balls: tuple[Ball, ...]
    joint: float | None
    """Offset of the fixed point from the centre of mass; None for a free body."""
    mu: float
    torsion: float
    """Coefficient of the drilling torque [m]."""
    rolling: float
    """Coefficient of the rolling resistance [m]."""
    restitution: float
    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    until: float
    law: str
    """The friction law of the reference; "rolling" for pure rolling."""

    @property
    def has_viscous_friction(self) -> bool:
        """Whether the friction grows with the slip: that of no engine does."""
        return self.law in ("viscous", "stribeck")


def _floats(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def read(folder: Path) -> Case:
    """Return the case in an exported folder."""
    root = ElementTree.parse(folder / "model.mjcf.xml").getroot()
    body = root.find("worldbody/body")
    inertial = body.find("inertial")
    centre = _floats(inertial.get("pos", "0 0 0"))[2]
    with (folder / "scenario.toml").open("rb") as file:
        scenario = tomllib.load(file)
    friction = scenario.get("friction", {})
    rows = np.genfromtxt(folder / "reference.csv", delimiter=",", names=True, deletechars="")
    start = {
        name.split("_[")[0]: value for name, value in zip(rows.dtype.names, rows[0], strict=True)
    }

    def vector(*names: str) -> np.ndarray:
        return np.array([float(start[name]) for name in names])

    mu = float(friction.get("mu", 0.0))
    joint = body.find("joint[@type='ball']")
    law = "joint" if joint is not None else friction.get("law", "rolling")
    return Case(
        name=folder.name,
        mass=float(inertial.get("mass")),
        inertia=np.array(_floats(inertial.get("diaginertia"))),
        gravity=-_floats(root.find("option").get("gravity"))[2],
        balls=tuple(
            Ball(_floats(geom.get("pos", "0 0 0"))[2] - centre, _floats(geom.get("size"))[0])
            for geom in body.findall("geom")
        ),
        joint=None if joint is None else _floats(joint.get("pos", "0 0 0"))[2] - centre,
        mu=10.0 if law == "rolling" else mu,
        torsion=TOOTH * mu * friction.get("patch", 0.0) + friction.get("mu_d", 0.0),
        rolling=friction.get("mu_r", 0.0),
        restitution=scenario.get("contact", {}).get("e_n", 0.0),
        position=vector("x", "y", "z"),
        quaternion=vector("q_w", "q_x", "q_y", "q_z"),
        velocity=vector("vx", "vy", "vz"),
        omega=vector("omega_x", "omega_y", "omega_z"),
        until=float(rows[rows.dtype.names[0]][-1]),
        law=law,
    )


def rotation(q: np.ndarray) -> np.ndarray:
    """Return the matrix, body to space, of a quaternion w x y z."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
