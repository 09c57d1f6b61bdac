"""A body as it is seen: balls, rods, ellipsoids and cylinders met by parallel rays, shaded, with a shadow on the floor.

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
    np.array(rgb) / 255 for rgb in ((243, 232, 205), (44, 92, 143), (217, 95, 30), (196, 142, 84), (35, 38, 44))
)
SECTORS = 8  # of a body around its axis, in turns light and dark: they show the spin
SEE_THROUGH = 0.45  # how much of the hidden mass shows through the body
BEYOND = 1e9  # the depth at which nothing is

Array = np.ndarray


class Scene(NamedTuple):
    """A body in a pose: its kind, the space directions of its body axes (3, 3, a column for each), its centre of mass,
    its balls (centre and radius), and half axes of its ellipsoid, across and along."""

    kind: str
    axes: Array
    mass: Array
    balls: Sequence[tuple[Array, float]]
    ellipsoid: tuple[float, float]
    tip: Array | None = None


def picture(scene: Scene, left: float, right: float, bottom: float, top: float, pixels: int, fine: int = 2) -> Array:
    """The scene as (height, width, 4): colours and how opaque, from 0 to 1; what is beside the body is transparent.

    Parameters
    ----------
    scene
        What is seen.
    left, right, bottom, top
        The part of the plane of the picture.
    pixels
        The height of the picture.
    fine
        Rays along each side of a pixel.
    """
    rows = pixels * fine
    columns = max(1, round(pixels * (right - left) / (top - bottom))) * fine
    x = left + (right - left) * (np.arange(columns) + 0.5) / columns
    y = top - (top - bottom) * (np.arange(rows) + 0.5) / rows
    origin = x[None, :, None] * RIGHT + y[:, None, None] * UP - 50.0 * AHEAD
    depth, normal, paint = _body(scene, origin)
    seen = depth < BEYOND
    colour = np.where(seen[..., None], _lit(normal, paint), 0.0)
    alpha = np.where(seen, 1.0, _shadow(scene, origin))
    whole = np.concatenate([colour * alpha[..., None], alpha[..., None]], axis=-1)
    mean = whole.reshape(rows // fine, fine, columns // fine, fine, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-12)
    return np.clip(mean, 0, 1)


def _body(scene: Scene, origin: Array) -> tuple[Array, Array, Array]:
    """Depth, outer normal and colour of what each ray meets first."""
    parts = []
    third = scene.axes[:, 2]
    centre, radius = scene.balls[0]
    if scene.kind == "heavy":
        across, along = scene.ellipsoid
        t, normal, local = _ellipsoid(origin, scene.mass, scene.axes, across, along)
        parts.append((t, normal, _sectors(local)))
        tip = scene.mass if scene.tip is None else scene.tip
        parts.append(_rod(origin, tip, scene.mass + (along + 0.3) * third, 0.05, IRON))
    elif scene.kind == "cylinder":
        t, normal, local = _cylinder(origin, centre, radius, scene.axes)
        t, paint = _with_mass(origin, scene, t, _sectors(local[..., [2, 0, 1]] / radius, equator=False))
        parts.append((t, normal, paint))
    else:
        t, normal = _ball(origin, centre, radius)
        local = np.where((t < BEYOND)[..., None], normal, 0.0) @ scene.axes
        t, paint = _with_mass(origin, scene, t, _sectors(local))
        parts.append((t, normal, paint))
        for end, thickness in scene.balls[1:]:
            parts.append(_rod(origin, centre, end, thickness, WOOD))
    depth, normal, paint = parts[0]
    for t, n, c in parts[1:]:
        nearer = t < depth
        depth = np.where(nearer, t, depth)
        normal = np.where(nearer[..., None], n, normal)
        paint = np.where(nearer[..., None], c, paint)
    return depth, normal, paint


def _sectors(local: Array, equator: bool = True) -> Array:
    """The paint at these directions (..., 3) of the body: its upper half light, its lower half blue, sectors around
    its axis, and a cap at the pole."""
    turn = np.floor((np.arctan2(local[..., 1], local[..., 0]) / (2 * np.pi)) * SECTORS) % 2
    half = local[..., 2] > 0 if equator else turn > 0
    paint = np.where(half[..., None], CREAM, BLUE)
    if equator:
        paint = np.where(turn[..., None] > 0, paint, np.where(half[..., None], 0.82 * CREAM, 0.62 * BLUE))
        paint = np.where((local[..., 2] > 0.93)[..., None], ORANGE, paint)
    return paint


def _with_mass(origin: Array, scene: Scene, t: Array, paint: Array) -> tuple[Array, Array]:
    """The depth, and the paint with the hidden mass shining through it."""
    radius = 0.17 * scene.balls[0][1]
    inner, _ = _ball(origin, scene.mass, radius)
    shows = ((inner < BEYOND) & (t < BEYOND))[..., None]
    return t, np.where(shows, (1 - SEE_THROUGH) * paint + SEE_THROUGH * IRON, paint)


def _ball(origin: Array, centre: Array, radius: float) -> tuple[Array, Array]:
    """Depth and normal of a ball."""
    between = origin - centre
    b = between @ AHEAD
    root = b**2 - (between**2).sum(axis=-1) + radius**2
    t = np.where(root > 0, -b - np.sqrt(np.maximum(root, 0)), BEYOND)
    return t, (between + t[..., None] * AHEAD) / max(radius, 1e-12)


def _ellipsoid(origin: Array, centre: Array, axes: Array, across: float, along: float) -> tuple[Array, Array, Array]:
    """Depth, normal, and direction within the body, of an ellipsoid of revolution."""
    scale = np.array([across, across, along])
    o, d = ((origin - centre) @ axes) / scale, (AHEAD @ axes) / scale
    a, b, c = d @ d, o @ d, (o**2).sum(axis=-1) - 1
    root = b**2 - a * c
    t = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, BEYOND)
    local = o + t[..., None] * d
    outward = (local / scale) @ axes.T
    return t, outward / np.maximum(np.linalg.norm(outward, axis=-1, keepdims=True), 1e-12), local


def _rod(origin: Array, start: Array, end: Array, radius: float, colour: Array) -> tuple[Array, Array, Array]:
    """Depth, normal and colour of a rod with round ends."""
    along = end - start
    length = float(np.linalg.norm(along)) or 1e-12
    along = along / length
    o, across = origin - start, AHEAD - (AHEAD @ along) * along
    p = o - (o @ along)[..., None] * along
    a, b, c = across @ across, p @ across, (p**2).sum(axis=-1) - radius**2
    root = b**2 - a * c
    t = np.where((root > 0) & (a > 1e-12), (-b - np.sqrt(np.maximum(root, 0))) / max(a, 1e-12), BEYOND)
    place = o + t[..., None] * AHEAD
    height = place @ along
    side = (height > 0) & (height < length)
    depth = np.where(side, t, BEYOND)
    normal = (place - height[..., None] * along) / radius
    for centre in (start, end):
        t, n = _ball(origin, centre, radius)
        nearer = t < depth
        depth, normal = np.where(nearer, t, depth), np.where(nearer[..., None], n, normal)
    return depth, normal, np.broadcast_to(colour, normal.shape)


def _cylinder(origin: Array, centre: Array, radius: float, axes: Array) -> tuple[Array, Array, Array]:
    """Depth, normal, and place within the body, of a cylinder that lies along the line of sight: its face and side."""
    half, (o, d) = 0.7 * radius, ((origin - centre), AHEAD)
    a, b, c = d[0] ** 2 + d[2] ** 2, o[..., 0] * d[0] + o[..., 2] * d[2], o[..., 0] ** 2 + o[..., 2] ** 2 - radius**2
    root = b**2 - a * c
    t = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, BEYOND)
    place = o + t[..., None] * d
    t = np.where(np.abs(place[..., 1]) < half, t, BEYOND)
    normal = np.stack([place[..., 0], 0 * t, place[..., 2]], axis=-1) / radius
    face = (-half - o[..., 1]) / d[1]
    on_face = o + face[..., None] * d
    within = on_face[..., 0] ** 2 + on_face[..., 2] ** 2 < radius**2
    nearer = within & (face < t)
    t, place = np.where(nearer, face, t), np.where(nearer[..., None], on_face, place)
    normal = np.where(nearer[..., None], np.array([0.0, -1.0, 0.0]), normal)
    return t, normal, np.where((t < BEYOND)[..., None], place, 0.0) @ axes


def _lit(normal: Array, paint: Array) -> Array:
    """The paint in the light of a lamp at the upper left, with a gleam."""
    diffuse = np.clip(normal @ LIGHT, 0, 1)[..., None]
    half = (LIGHT - AHEAD) / np.linalg.norm(LIGHT - AHEAD)
    gleam = np.clip(normal @ half, 0, 1)[..., None] ** 40
    return np.clip(paint * (0.42 + 0.64 * diffuse) + 0.30 * gleam, 0, 1)


def _shadow(scene: Scene, origin: Array) -> Array:
    """How dark the floor is where no ray meets the body: its shadow, and the dark spot where it touches."""
    if scene.tip is not None and scene.tip[2] > scene.mass[2]:
        return np.zeros(origin.shape[:2])  # it hangs: there is no floor
    floor = origin - (origin[..., 2] / AHEAD[2])[..., None] * AHEAD
    thick = [(scene.mass, max(scene.ellipsoid))] if scene.kind == "heavy" else list(scene.balls)
    dark: Any = np.zeros(origin.shape[:2])
    for centre, radius in thick:
        between = centre - floor
        off = np.linalg.norm(between - (between @ LIGHT)[..., None] * LIGHT, axis=-1) / max(radius, 1e-12)
        dark = np.maximum(dark, 0.30 * np.clip((1.15 - off) / 0.5, 0, 1))
        touch = np.linalg.norm(floor - centre * np.array([1, 1, 0]), axis=-1) / max(radius, 1e-12)
        dark = np.maximum(
            dark, 0.45 * np.exp(-((touch / 0.35) ** 2)) * (scene.kind != "heavy" and centre[2] - radius < 0.05)
        )
    return dark
