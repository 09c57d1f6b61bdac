"""Rotations are those of SciPy, in Python and in the JavaScript of the pages."""

import json
import shutil
import subprocess

import numpy as np
import pytest
from limits import assert_near
from scipy.spatial.transform import Rotation

from tippetop.mechanics import rotation
from tippetop.mechanics.operand import Vector
from tippetop.mechanics.rotation import Quaternion
from tippetop.views.javascript import rotations


NODE = shutil.which("node")


def random(rng: np.random.Generator, n: int) -> tuple[Rotation, Quaternion]:
    turns = Rotation.random(n, random_state=rng)
    return turns, Quaternion(*np.roll(turns.as_quat(), 1, axis=1).T)


def assert_same(p: Quaternion, q: Quaternion) -> None:
    """Check that quaternions are those of one rotation."""
    assert_near(np.abs((np.array(p) * np.array(q)).sum(axis=0)), 1, 1e-14)


def assert_is(turns: Rotation, q: Quaternion) -> None:
    assert_same(q, np.roll(turns.as_quat(), 1, axis=1).T)


def test_products_axes_and_turned_vectors(rng: np.random.Generator) -> None:
    (a, p), (b, q) = random(rng, 50), random(rng, 50)
    assert_is(a * b, rotation.after(p, q))
    assert_is(a.inv(), rotation.inverse(p))
    assert_near(np.array(rotation.axes(p)).transpose(2, 1, 0), a.as_matrix(), 1e-14)
    v = rng.normal(size=(50, 3))
    assert_near(np.array(rotation.rotated(p, Vector(*v.T))).T, a.apply(v), 1e-14)


def test_a_swing_turns_one_axis_to_another_and_nothing_about_it(rng: np.random.Generator) -> None:
    u, v = (Rotation.random(50, random_state=rng).apply([0, 0, 1]) for _ in range(2))
    q = rotation.swing(Vector(*u.T), Vector(*v.T))
    assert_near(np.array(rotation.rotated(q, Vector(*u.T))).T, v, 1e-14)
    normal = np.cross(u, v)
    assert_near(np.cross(np.array(q)[1:].T, normal), 0, 1e-14)


def test_products_of_a_rotation_with_itself_come_from_its_axes(rng: np.random.Generator) -> None:
    _, q = random(rng, 50)
    first, _, third = rotation.axes(q)
    expected = 4 * np.einsum("in,jn->ijn", np.array(q), np.array(q))
    assert_near(np.array(rotation.outer(first, third)), expected, 1e-14)


def test_between_has_the_rotations_of_its_ends_and_the_velocities_of_their_axes(
    rng: np.random.Generator,
) -> None:
    for _ in range(20):
        (_, p), (turns, _) = random(rng, 1), random(rng, 1)
        p, h = Quaternion(*(float(x[0]) for x in p)), 0.1
        wp, wq = (Vector(*(4 * rng.normal(size=3))) for _ in range(2))
        way = turns[0] ** 0.1
        q = rotation.after(Quaternion(*np.roll(way.as_quat(), 1)), p)
        steps = np.array([-1e-5, 1e-5])
        for s, end, w in ((0.0, p, wp), (1.0, q, wq)):
            found = rotation.between(p, wp, q, wq, h, s)
            assert_same(found, end)
            low, high = (
                np.array(rotation.axes(rotation.between(p, wp, q, wq, h, s + ds))[2])
                for ds in steps
            )
            moved = np.cross(w, rotation.axes(end)[2])
            assert_near((high - low) / (2e-5 * h), moved, 1e-7 * np.linalg.norm(w))
        assert abs(np.linalg.norm(rotation.between(p, wp, q, wq, h, 0.4)) - 1) < 1e-14


def test_between_is_exact_for_a_steady_spin_of_many_turns() -> None:
    """A body that spins 40 rad about its axis, which stands still, between two samples."""
    axis = Vector(0.6, 0.0, 0.8)
    tilt = rotation.swing(Vector(0.0, 0.0, 1.0), axis)
    spin = Vector(*(200.0 * c for c in axis))
    ends = [rotation.after(rotation.turn(axis, angle), tilt) for angle in (0.3, 40.3)]
    for s in (0.0, 0.21, 0.5, 1.0):
        found = rotation.between(ends[0], spin, ends[1], spin, 0.2, s)
        expected = rotation.after(rotation.turn(axis, 0.3 + 40 * s), tilt)
        assert_same(found, expected)


@pytest.mark.skipif(NODE is None, reason="no node")
def test_the_pages_compute_the_same(rng: np.random.Generator) -> None:
    _, p = random(rng, 1)
    _, q = random(rng, 1)
    p, q = (Quaternion(*(float(v[0]) for v in r)) for r in (p, q))
    w, o = Vector(*rng.normal(size=3)), Vector(*rng.normal(size=3))
    script = rotations().replace("export ", "")
    calls = (
        f"[between({[*p]}, {[*map(float, w)]}, {[*q]}, {[*map(float, o)]}, 0.3, 0.4), "
        f"axes({[*p]}), "
    )
    calls += f"outer({[*map(float, w)]}, {[*map(float, o)]})]"
    done = subprocess.run(
        [str(NODE), "-e", f"{script} console.log(JSON.stringify({calls}))"],
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    np.testing.assert_allclose(found[0], rotation.between(p, w, q, o, 0.3, 0.4), rtol=1e-13)
    np.testing.assert_allclose(found[1], rotation.axes(p), rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(found[2], rotation.outer(w, o), rtol=1e-14, atol=1e-16)
