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
from tippetop.mechanics.contact.outline import root
from tippetop.runs import shape as shapes


STONE = tt.Ellipsoid(
    m=1,
    a=0.2,
    b=0.03,
    c=0.02,
    delta=0.4,
    x=0.01,
    y=-0.002,
    h=0.005,
    I1=2e-3,
    I2=3e-3,
    I3=1e-3,
    g=9.81,
).body()


def quaternions(count: int) -> np.ndarray:
    return np.roll(Rotation.random(count, rng=np.random.default_rng(3)).as_quat(), 1, axis=1)


def points(half: Any, centre: Any, turn: float = 0.0) -> np.ndarray:
    """Return points of an ellipsoid that is turned about axis 3, (n, 3)."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 250), np.linspace(0, 2 * np.pi, 250))
    parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    cloud = np.stack([p.ravel() for p in parts], axis=1) * half
    return Rotation.from_euler("z", turn).apply(cloud) + centre


def rim(ring: float, tube: float, c: float) -> np.ndarray:
    """Return points of a disc with a rounded rim, (n, 3)."""
    tilt, phi = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 250), np.linspace(0, 2 * np.pi, 250))
    radius, height = ring + tube * np.cos(tilt), c + tube * np.sin(tilt)
    parts = radius * np.cos(phi), radius * np.sin(phi), height
    return np.stack([p.ravel() for p in parts], axis=1)


DISC = tt.Disc(m=0.01, ring=0.011, tube=1e-3, c=1e-3, I1=1e-6, I3=2e-6, g=9.81)
SHARP = DISC._replace(tube=0.0).body()
EGG = tt.Spheroid(m=0.01, a=0.03, b=0.02, c=4e-3, I1=1e-6, I3=2e-6, g=9.81).body()
CASES = {
    "disc": (DISC.body(), rim(0.011, 1e-3, 1e-3)),
    "sharp": (SHARP, rim(0.011, 0.0, 1e-3)),
    "egg": (EGG, points([0.02, 0.02, 0.03], [0, 0, 4e-3])),
    "stone": (STONE, points([0.2, 0.03, 0.02], [0.01, -0.002, 0.005], 0.4)),
}


@pytest.mark.parametrize("name", CASES)
def test_the_lowest_point_of_equations_and_drawings_is_that_of_a_search(name: str) -> None:
    """In drawings to the rounding of a meridian: the body touches the plane."""
    body, cloud = CASES[name]
    surface, q = shapes.surface_of(body), quaternions(10)
    profile = np.array(film._capsule(1.0, 1.0))
    if len(surface.meridian):
        profile = surface.meridian[::-1, 1::-1].T
    size = np.abs(cloud).max()
    for i, turned in enumerate(map(shapes.rotation, q)):
        low = (cloud @ turned.T)[:, 2].min()
        axes = turned @ surface.axes
        drawn = surface.centre @ surface.axes + film._farthest(-axes[2], surface.half, profile)
        assert (axes @ drawn)[2] == pytest.approx(low, abs=0.005 * size)
        if name != "stone":
            assert shapes.lowest(q, body)[i, 2] == pytest.approx(low, abs=1e-4 * size)


class Pear(NamedTuple):
    """The outline of a body with a thick and a thin end."""

    a: float = 0.03

    def height(self, z: Any, s2: Any) -> Any:
        return root(z * z * self.a**2 + s2 * 0.02**2) + z * s2 * 0.003


@pytest.mark.parametrize("name", ["disc", "sharp", "pear"])
def test_a_drawn_meridian_is_convex(name: str) -> None:
    """So that no step along a ray passes it; with the cones at its ends, in single precision."""
    body = EGG._replace(outline=Pear()) if name == "pear" else CASES[name][0]
    height, radius, _ = np.float32(shapes.surface_of(body).meridian).T
    slopes = np.diff(radius) / np.diff(height)
    assert len(radius) == 64
    assert (np.diff(slopes) > -1e-3 * np.abs(slopes[1:])).all()


def test_omega_is_that_of_three_moments() -> None:
    q, w = quaternions(1), np.array([1.0, -2.0, 3.0])
    R = shapes.rotation(q[0])
    L = R @ np.diag(shapes.moments(STONE)) @ R.T @ w
    np.testing.assert_allclose(shapes.angular_velocity(q, L[None], STONE)[0], w, rtol=1e-12)


def test_an_ellipsoid_of_simulators_has_its_axes_and_moments() -> None:
    """Its frame is at the centre of the ellipsoid, along the principal axes of inertia."""
    surface = shapes.surface_of(STONE)
    model = simulators.Model(tt.load("spinning-egg"))
    model.moments, model.surfaces = shapes.moments(STONE), {"ellipsoid": surface}
    model.frame = surface.centre
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
