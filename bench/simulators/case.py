"""A case of the benchmark as an adapter reads it: only from the exported folder."""

import json
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation


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


def read(folder: Path) -> Case:
    """Return the case in an exported folder."""
    described = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    body, laws = described["body"], described["law"] or {}
    friction = laws.get("friction", {})
    mu = friction.get("mu", 0.0)
    joint = body["fixed_point"]
    law = "joint" if joint is not None else friction.get("law", "rolling")
    return Case(
        name=folder.name,
        mass=body["mass"],
        inertia=np.array(body["moments_of_inertia"]),
        gravity=body["gravity"],
        balls=tuple(Ball(**ball) for ball in body["balls"].values()),
        joint=joint,
        mu=10.0 if law == "rolling" else mu,
        torsion=TOOTH * mu * friction.get("patch", 0.0) + friction.get("mu_d", 0.0),
        rolling=friction.get("mu_r", 0.0),
        restitution=laws.get("contact", {}).get("e_n", 0.0),
        **{name: np.array(vector) for name, vector in described["start"].items()},
        until=described["until"],
        law=law,
    )


def rotation(q: np.ndarray) -> np.ndarray:
    """Return the matrix, body to space, of a quaternion w x y z."""
    return Rotation.from_quat(q, scalar_first=True).as_matrix()
