"""The surfaces that are drawn and exported: their lowest points, found by search, are on the plane
where the equations say that the body touches it.
"""

from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tippetop as tt
from tippetop.exchange import simulators
from tippetop.figures import film
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.outline import root
from tippetop.mechanics.friction import Frictionless
from tippetop.runs import shape as shapes


class Lopsided(NamedTuple):
    """An outline without an axis of symmetry: its numbers are parameters of the body."""


STONE = Touch(1.0, (), (), 2e-3, 1e-3, 9.81, Frictionless(), outline=Lopsided())
NUMBERS = {"a": 0.2, "b": 0.03, "c": 0.02, "delta": 0.4, "x": 0.01, "y": -0.002, "h": 0.005}


def quaternions(count: int) -> np.ndarray:
    return np.roll(Rotation.random(count, rng=np.random.default_rng(3)).as_quat(), 1, axis=1)


def points(half: Any, centre: Any, turn: float = 0.0) -> np.ndarray:
    """Return points of an ellipsoid that is turned about axis 3, (n, 3)."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 400), np.linspace(0, 2 * np.pi, 400))
    parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    cloud = np.stack([p.ravel() for p in parts], axis=1) * half
    return Rotation.from_euler("z", turn).apply(cloud) + centre


def rim(ring: float, tube: float, c: float) -> np.ndarray:
    """Return points of a disc with a rounded rim, (n, 3)."""
    tilt, phi = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 400), np.linspace(0, 2 * np.pi, 400))
    radius, height = ring + tube * np.cos(tilt), c + tube * np.sin(tilt)
    parts = radius * np.cos(phi), radius * np.sin(phi), height
    return np.stack([p.ravel() for p in parts], axis=1)


DISC = {"ring": 0.011, "tube": 1e-3, "c": 1e-3}
EGG = {"a": 0.03, "b": 0.02, "c": 4e-3}
CASES = {
    "disc": (tt.Disc(m=0.01, I1=1e-6, I3=2e-6, g=9.81, **DISC).body(), DISC, rim(**DISC)),
    "sharp": (
        tt.Disc(m=0.01, I1=1e-6, I3=2e-6, g=9.81, ring=0.011, tube=0.0, c=0.0).body(),
        {},
        rim(0.011, 0.0, 0.0),
    ),
    "egg": (
        tt.Spheroid(m=0.01, I1=1e-6, I3=2e-6, g=9.81, **EGG).body(),
        EGG,
        points([0.02, 0.02, 0.03], [0, 0, 4e-3]),
    ),
    "stone": (
        STONE,
        NUMBERS,
        points([0.2, 0.03, 0.02], [0.01, -0.002, 0.005], 0.4),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_the_lowest_point_is_that_of_a_search(name: str) -> None:
    body, numbers, cloud = CASES[name]
    q = quaternions(20)
    found = shapes.lowest(q, body, numbers)
    for one, low in zip(q, found, strict=True):
        turned = Rotation.from_quat(np.roll(one, -1)).apply(cloud)
        assert low[2] == pytest.approx(turned[:, 2].min(), abs=1e-4 * np.abs(cloud).max())


@pytest.mark.parametrize("name", CASES)
def test_drawers_take_the_surface_of_the_equations(name: str) -> None:
    """To the rounding of a drawn meridian: the body touches the plane in pictures."""
    body, numbers, _ = CASES[name]
    surface = shapes.surface_of(body, numbers)
    for q, low in zip(quaternions(20), shapes.lowest(quaternions(20), body, numbers), strict=True):
        axes = shapes.rotation(q) @ surface.axes
        profile = np.array(film._capsule(1.0, 1.0))
        if len(surface.meridian):
            profile = surface.meridian[::-1, 1::-1].T
        drawn = surface.centre @ surface.axes + film._farthest(-axes[2], surface.half, profile)
        assert (axes @ drawn)[2] == pytest.approx(low[2], abs=0.005 * surface.half.max())


class Pear(NamedTuple):
    """The outline of a body with a thick and a thin end."""

    a: float = 0.03

    def height(self, z: Any, s2: Any) -> Any:
        return root(z * z * self.a**2 + s2 * 0.02**2) + z * s2 * 0.003


@pytest.mark.parametrize("name", ["disc", "sharp", "pear"])
def test_a_drawn_meridian_is_convex(name: str) -> None:
    """So that no step along a ray passes it; with the cones at its ends, in single precision."""
    body = STONE._replace(outline=Pear()) if name == "pear" else CASES[name][0]
    height, radius, _ = np.float32(shapes.surface_of(body, {}).meridian).T
    slopes = np.diff(radius) / np.diff(height)
    assert len(radius) == 64
    assert (np.diff(slopes) > -1e-3 * np.abs(slopes[1:])).all()


def test_omega_is_that_of_three_moments() -> None:
    q, w = quaternions(1), np.array([1.0, -2.0, 3.0])
    R, moments = shapes.rotation(q[0]), np.array([3.0, 1.0, 4.0])
    L = R @ np.diag(moments) @ R.T @ w
    np.testing.assert_allclose(shapes.angular_velocity(q, L[None], moments)[0], w, rtol=1e-12)


def test_an_ellipsoid_of_simulators_has_its_axes_and_moments() -> None:
    """Its frame is at the centre of the ellipsoid, along the principal axes of inertia."""
    surface = shapes.surface_of(STONE, NUMBERS)
    model = simulators._model(tt.load("spinning-egg"))
    model = model._replace(moments=[2e-3, 3e-3, 1e-3], surfaces={"ellipsoid": surface})
    body = ElementTree.fromstring(simulators._mjcf(model)).find("worldbody/body")
    assert body is not None
    geom, inertial = (body.find(name).attrib for name in ("geom", "inertial"))  # type: ignore
    assert inertial["pos"] == "-0.01 0.002 -0.005"
    assert inertial["diaginertia"] == "0.002 0.003 0.001"
    assert (geom["type"], geom["size"], geom["pos"]) == ("ellipsoid", "0.2 0.03 0.02", "0 0 0")
    turned = Rotation.from_quat(np.roll([float(v) for v in geom["quat"].split()], -1))
    np.testing.assert_allclose(turned.as_matrix(), surface.axes, atol=1e-11)
    sdf = ElementTree.fromstring(simulators._sdf(model)).find(".//collision[@name='ellipsoid']")
    assert sdf is not None
    assert sdf.findtext("geometry/ellipsoid/radii") == "0.2 0.03 0.02"
    assert sdf.findtext("pose") == "0.01 -0.002 0.005 0 0 0.4"


def test_mujoco_moves_an_egg_as_its_scenario() -> None:
    mujoco = pytest.importorskip("mujoco")
    free = {"law": "none"}
    start = {"theta": 1.0, "phi_dot": 10.0, "omega3": 30.0}
    options: dict[str, Any] = {"friction": free, "start": start, "until": 0.2}
    run = tt.run("spinning-egg", **options, contact={"e_n": 0.0})
    model = mujoco.MjModel.from_xml_string(simulators.text_of(run.problem, "mjcf"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, 2000)
    q = run.trajectory.orientation.values[-1]
    assert abs(data.qpos[3:7] @ q) == pytest.approx(1.0, abs=1e-8)
    assert data.qpos[2] == pytest.approx(float(run.trajectory.z[-1]), abs=1e-6)
