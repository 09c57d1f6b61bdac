"""A body as it is seen: balls, rods, ellipsoids and cylinders met by parallel rays, shaded, with a
shadow on the floor.

Lengths are in units of the body. The camera looks along y, from somewhat above; z is up.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np


ELEVATION = np.radians(16.0)  # of the camera
LIGHT = np.array([-0.42, -0.62, 0.66]) / np.linalg.norm([-0.42, -0.62, 0.66])
RIGHT = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, np.sin(ELEVATION), np.cos(ELEVATION)])
AHEAD = np.array([0.0, np.cos(ELEVATION), -np.sin(ELEVATION)])
CREAM, BLUE, ORANGE, WOOD, IRON = (
    np.array(rgb) / 255
    for rgb in ((243, 232, 205), (44, 92, 143), (217, 95, 30), (196, 142, 84), (35, 38, 44))
)
SECTORS = 8  # of a body around its axis, in turns light and dark: they show the spin
SEE_THROUGH = 0.45  # how much of the hidden mass shows through the body
FINE = 2  # rays along each side of a pixel
BEYOND = 1e9  # the depth at which nothing is

Array = np.ndarray
Part = tuple[Array, Array, Array]


class Scene(NamedTuple):
    """A body in a pose: its kind, the space directions of its body axes (3, 3, a column for each),
    its centre of mass, its balls (centre and radius), and half axes of its ellipsoid, across and
    along.
    """

    kind: str
    axes: Array
    mass: Array
    balls: Sequence[tuple[Array, float]]
    ellipsoid: tuple[float, float]
    tip: Array | None = None


def picture(
    scene: Scene, left: float, right: float, bottom: float, top: float, pixels: int
) -> Array:
    """The scene as (height, width, 4): colours and how opaque, from 0 to 1; what is beside the body
    is transparent.

    Parameters
    ----------
    scene
        What is seen.
    left, right, bottom, top
        The part of the plane of the picture.
    pixels
        The height of the picture.
    """
    rows, columns = FINE * pixels, FINE * max(1, round(pixels * (right - left) / (top - bottom)))
    x = left + (right - left) * (np.arange(columns) + 0.5) / columns
    y = top - (top - bottom) * (np.arange(rows) + 0.5) / rows
    origin = x[None, :, None] * RIGHT + y[:, None, None] * UP - 50.0 * AHEAD
    depth, normal, paint = _body(scene, origin)
    seen = depth < BEYOND
    colour = np.where(seen[..., None], _lit(normal, paint), 0.0)
    alpha = np.where(seen, 1.0, _shadow(scene, origin))
    whole = np.concatenate([colour * alpha[..., None], alpha[..., None]], axis=-1)
    mean = whole.reshape(pixels, FINE, -1, FINE, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-12)
    return np.clip(mean, 0, 1)


def _body(scene: Scene, origin: Array) -> Part:
    """Depth, outer normal and colour of what each ray meets first."""
    centre, radius = scene.balls[0]
    if scene.kind == "heavy":
        across, along = scene.ellipsoid
        tip = scene.mass if scene.tip is None else scene.tip
        depth, normal, local = _quadric(origin, scene.mass, scene.axes, (across, across, along))
        end = scene.mass + (along + 0.3) * scene.axes[:, 2]
        return _nearest(
            [(depth, normal, _sectors(local)), *_rod(origin, scene.axes, tip, end, 0.05, IRON)]
        )
    if scene.kind == "cylinder":
        parts = _cylinder(origin, scene)
    else:
        depth, normal, local = _quadric(origin, centre, scene.axes, 3 * (radius,))
        parts = [(depth, normal, _sectors(local))]
    inner, *_ = _quadric(origin, scene.mass, scene.axes, 3 * (0.17 * radius,))
    opaque = np.where(inner < BEYOND, 1 - SEE_THROUGH, 1.0)[
        ..., None
    ]  # the hidden mass shines through
    parts = [
        (depth, normal, opaque * paint + (1 - opaque) * IRON) for depth, normal, paint in parts
    ]
    for end, thickness in scene.balls[1:]:
        parts += _rod(origin, scene.axes, centre, end, thickness, WOOD)
    return _nearest(parts)


def _nearest(parts: Sequence[Part]) -> Part:
    """Of several parts what each ray meets first."""
    depths, *others = (np.stack(each) for each in zip(*parts, strict=True))
    first = depths.argmin(axis=0)[None]
    normal, paint = (np.take_along_axis(each, first[..., None], axis=0)[0] for each in others)
    return depths.min(axis=0), normal, paint


def _sectors(local: Array, equator: bool = True) -> Array:
    """The paint at these directions (..., 3) of the body: its upper half light, its lower half
    blue, sectors around its axis, and a cap at the pole.
    """
    turn = np.floor((np.arctan2(local[..., 1], local[..., 0]) / (2 * np.pi)) * SECTORS) % 2
    half = local[..., 2] > 0 if equator else turn > 0
    paint = np.where(half[..., None], CREAM, BLUE)
    if equator:
        paint = np.where(
            turn[..., None] > 0, paint, np.where(half[..., None], 0.82 * CREAM, 0.62 * BLUE)
        )
        paint = np.where((local[..., 2] > 0.93)[..., None], ORANGE, paint)
    return paint


def _quadric(origin: Array, centre: Array, axes: Array, sizes: Sequence[float]) -> Part:
    """Depth and outer normal of an ellipsoid with these half axes, and the place on it in units of
    them, along its axes. With an infinite half axis it is a cylinder.
    """
    scale = 1 / np.array(sizes)
    o, d = (origin - centre) @ axes * scale, AHEAD @ axes * scale
    a, b = max(d @ d, 1e-12), o @ d
    root = b**2 - a * ((o**2).sum(axis=-1) - 1)
    depth = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, BEYOND)
    local = o + depth[..., None] * d
    outward = (local * scale) @ axes.T
    return depth, outward / np.linalg.norm(outward, axis=-1, keepdims=True), local


def _rod(
    origin: Array, axes: Array, start: Array, end: Array, radius: float, colour: Array
) -> list[Part]:
    """The parts of a rod along axis 3 with round ends."""
    depth, normal, _ = _quadric(origin, start, axes, (radius, radius, np.inf))
    along = (origin + depth[..., None] * AHEAD - start) @ axes[:, 2] / ((end - start) @ axes[:, 2])
    side = np.where((along > 0) & (along < 1), depth, BEYOND)
    ends = (_quadric(origin, place, axes, 3 * (radius,)) for place in (start, end))
    return [(t, n, np.broadcast_to(colour, n.shape)) for t, n, *_ in ((side, normal), *ends)]


def _cylinder(origin: Array, scene: Scene) -> list[Part]:
    """The side and the face of a cylinder that lies along y."""
    centre, radius = scene.balls[0]
    half, off = 0.7 * radius, origin - centre
    depth, normal, local = _quadric(origin, centre, scene.axes, (radius, np.inf, radius))
    depth = np.where(np.abs(off[..., 1] + depth * AHEAD[1]) < half, depth, BEYOND)
    face = (-half - off[..., 1]) / AHEAD[1]
    on_face = (off + face[..., None] * AHEAD) @ scene.axes / radius
    face = np.where(on_face[..., 0] ** 2 + on_face[..., 2] ** 2 < 1, face, BEYOND)
    return [
        (t, np.broadcast_to(n, normal.shape), _sectors(place[..., [2, 0, 1]], equator=False))
        for t, n, place in ((depth, normal, local), (face, (0.0, -1.0, 0.0), on_face))
    ]


def _lit(normal: Array, paint: Array) -> Array:
    """The paint in the light of a lamp at the upper left, with a gleam."""
    diffuse = np.clip(normal @ LIGHT, 0, 1)[..., None]
    half = (LIGHT - AHEAD) / np.linalg.norm(LIGHT - AHEAD)
    gleam = np.clip(normal @ half, 0, 1)[..., None] ** 40
    return np.clip(paint * (0.42 + 0.64 * diffuse) + 0.30 * gleam, 0, 1)


def _shadow(scene: Scene, origin: Array) -> Array:
    """How dark the floor is where no ray meets the body: its shadow, and the dark spot where it
    touches.
    """
    if scene.tip is not None and scene.tip[2] > scene.mass[2]:
        return np.zeros(origin.shape[:2])  # it hangs: there is no floor
    floor = origin - (origin[..., 2] / AHEAD[2])[..., None] * AHEAD
    thick = [(scene.mass, max(scene.ellipsoid))] if scene.kind == "heavy" else list(scene.balls)
    dark: Any = np.zeros(origin.shape[:2])
    for centre, radius in thick:
        between = centre - floor
        off = np.linalg.norm(between - (between @ LIGHT)[..., None] * LIGHT, axis=-1) / radius
        dark = np.maximum(dark, 0.30 * np.clip((1.15 - off) / 0.5, 0, 1))
        if scene.kind != "heavy" and centre[2] - radius < 0.05:
            touch = np.linalg.norm(between[..., :2], axis=-1) / radius
            dark = np.maximum(dark, 0.45 * np.exp(-((touch / 0.35) ** 2)))
    return dark
